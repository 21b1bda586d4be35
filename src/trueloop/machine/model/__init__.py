"""How the machine errs: kinematic chain, error terms, their histories in time, evaluation."""
