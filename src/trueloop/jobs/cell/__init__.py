"""A machine's cell by its settings."""
