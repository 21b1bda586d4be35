"""Nominal shapes from CAD: STEP and DXF."""
