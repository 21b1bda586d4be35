"""The step in which a program writes its coordinates."""

import re
from typing import Final

from trueloop.nc.program.dialect import Dialect
from trueloop.units import MM_PER_INCH

COARSEST_MM: Final = 0.001
"""The coarsest step assumed, mm: programs of round numbers do not show their rounding."""

_ENOUGH: Final = 1 << 20
_COORDINATE: Final = re.compile(rb"[XYZ][ \t]*[-+]?\d*\.(\d+)", re.IGNORECASE)


def written_step_mm(source: bytes, dialect: Dialect, inch: bool) -> float:
    """Returns one unit of the last decimal that the program's coordinates use, in mm; at most `COARSEST_MM`.

    Never finer than the control's resolution. inch: the unit of the first move. The program's first megabyte is
    searched with its comments: a coordinate in a comment has the program's decimals too.
    """
    decimals = max((len(found) for found in _COORDINATE.findall(source, 0, _ENOUGH)), default=0)
    return min(max(10.0**-decimals, dialect.step(inch)) * (MM_PER_INCH if inch else 1.0), COARSEST_MM)
