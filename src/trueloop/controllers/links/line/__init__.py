"""Controls at a serial line: characters, the port, and programs over it."""
