"""Options of commands that correct a program by a field: limits and tolerance, as the catalogue has them."""

from typing import Annotated, Final

import typer

from trueloop.cli.program_file import Reading
from trueloop.cli.shared_options import positive
from trueloop.domain.limits import LIMITS
from trueloop.domain.map_options import MAP_OPTIONS, MapOptions
from trueloop.units import UM_PER_MM

LARGEST_UM: Final[float] = LIMITS["correction_mm"].default
STEEPEST: Final[float] = LIMITS["slope"].default
TOLERANCE_UM: Final[float] = MAP_OPTIONS["tolerance_mm"].default

LimitUm = Annotated[float, typer.Option("--limit-um", min=0.0, help=LIMITS["correction_mm"].option.meaning)]
Slope = Annotated[float, typer.Option("--slope", min=0.0, help=f"{LIMITS['slope'].option.meaning[:-1]}, µm/mm.")]
ToleranceUm = Annotated[
    float,
    typer.Option("--tolerance-um", min=0.001, callback=positive, help=MAP_OPTIONS["tolerance_mm"].option.meaning),
]


def map_options(reading: Reading, decimals: int, tolerance_um: float, limit_um: float, slope: float) -> MapOptions:
    """The options of a command as a loop takes them; slope in µm/mm."""
    return MapOptions(
        tolerance_um / UM_PER_MM,
        limit_um / UM_PER_MM,
        slope / UM_PER_MM,
        reading.skipped_blocks,
        reading.unit,
        decimals,
    )
