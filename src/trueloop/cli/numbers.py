"""What options ask of their numbers: typer's own bounds let nan through, which is neither below nor above any."""

import math

import typer


def positive(value: float | None) -> float | None:
    """A finite number above 0, as an option's callback."""
    if value is not None and not 0 < value < math.inf:
        raise typer.BadParameter(f"{value} is not a finite number above 0")
    return value


def not_negative(value: float | None) -> float | None:
    """A finite number not below 0, as an option's callback."""
    if value is not None and not 0 <= value < math.inf:
        raise typer.BadParameter(f"{value} is not a finite number from 0 up")
    return value
