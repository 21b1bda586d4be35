"""Corrections by the machine model: axis tables, set-ups, displaced points of programs."""
