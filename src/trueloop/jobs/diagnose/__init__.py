"""What commands `trueloop diagnose` do: records of a store to diagnoses."""
