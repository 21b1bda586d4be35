"""Jobs and their store: which one, what a command keeps in it, and what memory gets out of it again."""
