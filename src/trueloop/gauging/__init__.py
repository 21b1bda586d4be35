"""What the touches mean: error vectors along the nominal normal, with their uncertainty."""
