"""What is chosen where a machine model, or a field of displacements, corrects a program."""

from dataclasses import dataclass
from typing import Annotated, Final, Literal

from trueloop.domain.limits import Limits
from trueloop.domain.option import Option, choices_of


@dataclass(frozen=True)
class MapOptions:
    """How a field is applied.

    tolerance_mm: how far the written path may leave the displaced one, rounding to the control's resolution not
    counted. limit_mm: largest displacement along an axis. slope: largest change of the displacement in a cut over its
    length, mm/mm. skipped_blocks: displace the blocks that start with a slash as well. unit: what is in force at the
    program's start, where it does not state it. decimals: how many are written at least, beside those that the control
    resolves and those that the program has.

    >>> trueloop.MapOptions(limit_mm=0.05).tolerance_mm
    0.0005
    """

    tolerance_mm: Annotated[
        float, Option("tolerance_um", "How far a block may leave the displaced path.", least=0.001)
    ] = 0.0005
    limit_mm: float = Limits.correction_mm
    slope: float = Limits.slope
    skipped_blocks: bool = False
    unit: Literal["mm", "inch"] | None = None
    decimals: int = 0


USUAL: Final = MapOptions()
MAP_OPTIONS: Final = choices_of(MapOptions)
"""By field: unit, default and meaning, for commands."""
