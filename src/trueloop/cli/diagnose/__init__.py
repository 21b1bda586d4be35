"""`trueloop diagnose`."""
