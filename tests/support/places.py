"""Where things stand in the project."""

from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"
