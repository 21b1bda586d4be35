"""Jobs of surfaces: their files to values, and what comes of them to files."""
