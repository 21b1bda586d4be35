"""What earlier parts teach: models of an edge and of a series, weights, and changes noticed. Numbers only, no files."""
