"""Shorthand (corners, angles, splines, sub-programs) as explicit moves."""
