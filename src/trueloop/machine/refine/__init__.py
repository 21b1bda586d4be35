"""The model of a machine refined from what it left on parts."""
