"""Curves by what is known beforehand: of features without a touch, and from readings of gauges."""
