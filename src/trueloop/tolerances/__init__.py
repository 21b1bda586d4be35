"""Tolerances: limits by ISO 286 and ISO 2768, and whether a value is inside them, by ISO 14253-1."""
