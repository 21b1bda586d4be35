"""Closed-loop machining: measure the part, model the error, cut the next pass true."""

__version__ = "0.1.0"
