"""Figures and pages of a surface."""
