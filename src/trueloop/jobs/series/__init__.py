"""Series of parts: files into the store, what the store holds of a series, proposals and decisions."""
