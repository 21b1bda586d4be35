"""Deviation along a profile: constrained splines, lines, junctions, the nose model."""
