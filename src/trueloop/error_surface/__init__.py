"""Deviation over a surface: what repeats and what is random, on one part and over many."""
