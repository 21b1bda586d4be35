"""Learning from earlier parts: models of an edge and of a series, weights, and changes noticed. Numbers only, no
files.
"""
