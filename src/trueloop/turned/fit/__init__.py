"""Deviation along one chain of tangent lines, arcs and curves: constrained splines, lines, the nose model."""
