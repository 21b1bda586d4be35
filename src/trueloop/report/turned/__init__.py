"""Figures and page of a turned part."""
