"""Learning from earlier parts: models of an edge and of a series, weights, changes noticed. Numbers only."""
