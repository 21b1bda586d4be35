"""Figures and pages of a machine."""
