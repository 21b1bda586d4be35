"""What measuring devices write: touches, points, readings, logs."""
