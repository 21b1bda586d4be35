"""Pages of the real-time loop."""
