"""An edge and what it has taught: page, figures, lines, JSON."""
