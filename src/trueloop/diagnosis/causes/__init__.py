"""The causes of wrong features: causes as data, how each shows, and their probabilities."""
