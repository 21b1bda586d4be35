"""The pattern that many parts share, and where measured points support it."""
