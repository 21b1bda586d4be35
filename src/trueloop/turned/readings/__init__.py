"""Readings of gauges on a turned part: the feature of each, and its information on the error curves."""
