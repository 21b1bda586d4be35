"""`trueloop cell`."""
