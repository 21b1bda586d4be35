"""`trueloop series`."""
