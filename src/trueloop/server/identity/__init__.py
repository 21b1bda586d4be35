"""Who asks: accounts and their passwords, sessions, keys of cells, and what attempts to get in cost."""
