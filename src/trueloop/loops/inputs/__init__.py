"""Inputs of the loops, read from the files that a job names."""
