"""Measured points of a surface as deviations along its normal: alignment, duplicates, plausibility."""
