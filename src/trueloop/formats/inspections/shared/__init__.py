"""Functions shared by the readers of inspection files: text, numbers, times, names, and checks of repeated values."""
