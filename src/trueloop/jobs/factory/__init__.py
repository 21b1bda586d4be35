"""The work of the factory's workers."""
