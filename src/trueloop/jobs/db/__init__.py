"""Files into the store: of which part each inspection is, and what came of it."""
