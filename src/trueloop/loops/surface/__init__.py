"""The loop of a surface over many parts."""
