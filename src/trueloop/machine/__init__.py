"""How the machine errs: kinematic chain, error terms, thermal terms, identification, machine-coordinate correction."""
