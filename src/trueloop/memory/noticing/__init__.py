"""What changed: tests on what a part showed beyond what was predicted of it."""
