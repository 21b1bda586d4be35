"""Characteristics of a turned part: sizes as functions of the part error, their values and their uncertainties."""
