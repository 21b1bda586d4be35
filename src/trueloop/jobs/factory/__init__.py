"""What the factory's workers do."""
