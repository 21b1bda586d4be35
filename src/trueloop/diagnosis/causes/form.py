"""Sizes of form: straightness, waviness, one wave and three waves a turn. Never negative, they are weighed apart.

Of each kind and device the largest mean of a feature over the parts counts. Without a cause it is that of noise, half
normal; with one it can be of any order of magnitude.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from trueloop.diagnosis.causes.catalogue import SIZES_OF_FORM
from trueloop.diagnosis.causes.cause import Cause
from trueloop.diagnosis.causes.rows import Row
from trueloop.diagnosis.causes.seen_part import SeenBy
from trueloop.diagnosis.features.feature_error import ErrorKind

NOISE: Final = 1.5
"""By how many standard uncertainties a size that is none may differ from zero, as a standard deviation."""
NONE_ON_AVERAGE: Final = 0.8
"""Mean of a size that is none, in standard uncertainties of one part: that of a half normal."""
ORDERS: Final = float(np.log(1000.0))
Cell = tuple[ErrorKind, SeenBy]


def largest(rows: Sequence[Row]) -> dict[Cell, tuple[str, float, float]]:
    """The largest mean over parts of each kind and device: its feature, size and standard uncertainty of one, mm."""
    found: dict[Cell, tuple[str, float, float]] = {}
    of: dict[tuple[ErrorKind, SeenBy, str], list[Row]] = {}
    for row in rows:
        of.setdefault((row.kind, row.seen_by, row.feature), []).append(row)
    for (kind, seen_by, feature), some in of.items():
        mean = float(np.mean([row.value_mm for row in some]))
        u = float(np.sqrt(np.mean([row.u_mm**2 for row in some])))
        if len(some) > 1:  # of a mean over parts: what noise alone has on average does not go away, its scatter does
            mean, u = max(mean - NONE_ON_AVERAGE * u, 0.0), u / float(np.sqrt(len(some)))
        if (kind, seen_by) not in found or mean > found[(kind, seen_by)][1]:
            found[(kind, seen_by)] = (feature, mean, u)
    return found


def log_form(seen: Mapping[Cell, tuple[str, float, float]], causes: Iterable[Cause]) -> float:
    """Logarithm of how likely the sizes are if these causes act, beside how likely they are if none does."""
    must: set[Cell] = set()
    may: set[Cell] = set()
    for sign in (sign for cause in causes for sign in cause.signs if sign.kind in SIZES_OF_FORM):
        (must if sign.needed else may).update((sign.kind, seen_by) for seen_by in sign.seen_by)
    total = 0.0
    for cell in seen:
        gain = _log_ratio(*seen[cell][1:])
        total += gain if cell in must else float(np.logaddexp(0.0, gain) - np.log(2.0)) if cell in may else 0.0
    return total


def _log_ratio(mean_mm: float, u_mm: float) -> float:
    """With a cause against without one."""
    size = max(mean_mm, 0.1 * u_mm)
    without = -0.5 * (size / (NOISE * u_mm)) ** 2 + 0.5 * np.log(2 / np.pi) - np.log(NOISE * u_mm)
    with_cause = -np.log(max(size, u_mm)) - np.log(ORDERS) - 0.5 * (max(2 * u_mm - size, 0.0) / (0.3 * u_mm)) ** 2
    return float(with_cause - without)
