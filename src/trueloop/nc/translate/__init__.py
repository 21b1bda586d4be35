"""A program in the words of another control."""
