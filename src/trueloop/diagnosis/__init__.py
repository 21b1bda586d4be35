"""Errors to causes: what of a part's error is the machine's, what the process', what the model left."""
