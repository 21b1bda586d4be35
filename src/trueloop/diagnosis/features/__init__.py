"""The errors of a feature, from points: radius, length, taper, straightness, roundness; and those of a fixturing."""
