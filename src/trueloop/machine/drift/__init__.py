"""Thermal drift of one point as a function of temperatures and speeds."""
