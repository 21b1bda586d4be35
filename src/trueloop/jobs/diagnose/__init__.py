"""The work of `trueloop diagnose`: records of a store to diagnoses."""
