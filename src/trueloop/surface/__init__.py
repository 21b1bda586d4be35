"""A free-form part: deviations, separation, pattern, compensation of surfaces and of their programs."""
