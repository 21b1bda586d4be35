"""A part turned on the virtual lathe that warms up: the part, its program, and what comes of the drives."""
