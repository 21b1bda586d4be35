"""Values that outlive a run: they are stored, sent and read back."""
