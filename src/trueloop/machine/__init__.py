"""The errors of the machine: kinematic chain, error terms, thermal terms, identification, machine-coordinate
correction.
"""
