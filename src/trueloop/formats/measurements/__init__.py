"""Files of measuring devices: touches, points, readings, logs."""
