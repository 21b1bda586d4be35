"""The commands: thin, no numerics, no file formats."""
