"""Error to correction: contour, tool offsets, table, limits and the correction record."""
