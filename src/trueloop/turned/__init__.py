"""A turned part: touches, error curves, compensation of contours and of their programs."""
