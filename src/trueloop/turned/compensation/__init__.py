"""Error curves to a displaced contour: decisions, limits, targets, prediction."""
