"""Changes noticed: tests on the differences of a part from its prediction."""
