"""What makes a feature wrong: causes as data, how each shows, and their probabilities."""
