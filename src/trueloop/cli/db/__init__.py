"""`trueloop db`."""
