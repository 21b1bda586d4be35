"""Programs to and from controls, and what of it is kept."""
