"""Readings of gauges on a turned part: which feature each is of, and what it says of the error curves."""
