"""`trueloop mtconnect`."""
