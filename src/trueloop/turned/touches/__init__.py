"""Touches of a turned part as error vectors along the nominal normal, with their uncertainty."""
