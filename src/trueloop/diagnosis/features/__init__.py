"""What is wrong with a feature, from points: radius, length, taper, straightness, roundness; and with a fixturing."""
