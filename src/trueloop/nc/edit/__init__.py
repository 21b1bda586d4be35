"""Words of a program changed by span; all other characters stay as they are."""
