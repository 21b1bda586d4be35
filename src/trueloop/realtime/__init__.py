"""Correction inside a control, servo period by period: the image of a model and a table, and the judging of a run."""
