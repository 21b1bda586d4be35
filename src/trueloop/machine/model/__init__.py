"""The errors of the machine: kinematic chain, error terms, their histories in time, evaluation."""
