"""Commands of `trueloop tool`."""
