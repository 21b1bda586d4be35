"""NC programs read and run: words, tool path, dialects, unit, work offsets."""
