"""Nominal shape: a profile of named lines and arcs, its junctions, its offset by the tool nose."""
