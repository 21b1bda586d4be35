"""The real-time loop as values: from a model or a correction to an image, and a run judged."""
