"""Deviation along one chain of tangent lines and arcs: constrained splines, lines, the nose model."""
