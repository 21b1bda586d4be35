"""A virtual lathe that errs while it warms up: its truth by plain transforms, its temperatures, instruments on it."""
