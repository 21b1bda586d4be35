"""Errors of the machine: kinematic chain, error and thermal terms, identification, correction of its coordinates."""
