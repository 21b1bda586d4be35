"""Deviation over one part: what is systematic and what is random."""
