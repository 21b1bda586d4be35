"""Probing: plans of where to touch, obstacles, stylus, calibration, and the part errors that touches give."""
