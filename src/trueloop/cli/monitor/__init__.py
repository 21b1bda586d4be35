"""`trueloop monitor`."""
