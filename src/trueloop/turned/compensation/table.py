"""The correction as a table along the commanded nose-centre path, for a control that corrects in real time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.turned.compensation.contour import CentrePiece

STEP_MM = 0.25


@by_content
@dataclass(frozen=True)
class CorrectionTable:
    """Rows in cutting order, chuck end to free end: where the program sends the nose centre, and what to add there.

    `commanded_mm` and `correction_mm` are (n, 2) in (x as a radius, z). Between rows the correction is linear.
    """

    feature: tuple[str, ...]
    commanded_mm: Array
    correction_mm: Array


def correction_table(
    commanded: Sequence[CentrePiece], corrected: Sequence[CentrePiece], offset_mm: tuple[float, float] = (0.0, 0.0)
) -> CorrectionTable:
    """Tabulates both paths feature by feature at equal shares of each, so that corners go to corners.

    `offset_mm` (x as a radius, z) is what a tool offset moves the corrected path by, everywhere: who corrects in real
    time by the table does not change the offset too.

    Valid for small corrections: a row's share differs from the foot of the normal by the tangential shift of the
    corners, micrometres on features of millimetres.
    """
    names: list[str] = []
    positions: list[Array] = []
    corrections: list[Array] = []
    for before, after in zip(commanded, corrected, strict=True):
        count = max(2, int(np.ceil((before.end_mm - before.start_mm) / STEP_MM)) + 1)
        position = before.shifted.centre_mm(np.linspace(before.start_mm, before.end_mm, count))
        names += [before.shifted.feature.name] * count
        positions.append(position)
        corrections.append(after.shifted.centre_mm(np.linspace(after.start_mm, after.end_mm, count)) - position)
    return CorrectionTable(tuple(names), np.concatenate(positions), np.concatenate(corrections) + offset_mm)
