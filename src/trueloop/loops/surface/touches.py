"""The touch of a part that its surface fits worst, by its number, row and column in the part's file."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trueloop.errors import Code, Finding, Place, Severity
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.separation.outlying_point import OutlyingPoint, outlying_point
from trueloop.surface.separation.separate import Separation
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class WorstTouch:
    """A part's worst touch for people: `name` and `place` of the touch that `found` is about."""

    name: str
    found: OutlyingPoint
    place: Place

    @property
    def words(self) -> str:
        """Describes the touch, how far off it is, and how probable that is by chance."""
        off_um = self.found.off_mm * UM_PER_MM
        return f"{self.name} lies {off_um:+.1f} µm off what the other touches tell (p {self.found.p_value:.2g})"


def worst_touch(points: MeasuredPoints, deviations: SurfaceDeviations, apart: Separation) -> WorstTouch:
    """Returns the worst touch of a part that was taken apart point by point, or cell by cell."""
    found = outlying_point(apart)
    there = np.flatnonzero(deviations.measured)
    if len(there) != len(apart.random_mm):
        u, v = apart.places.u[found.index], apart.places.v[found.index]
        return WorstTouch(f"the cell at u {u:.3f}, v {v:.3f} of {points.name!r}", found, Place(points.file))
    index = int(there[found.index])
    at = ""
    if points.shape is not None:
        row, column = divmod(index, points.shape[1])
        at = f" (row {row + 1}, column {column + 1})"
    return WorstTouch(f"point {index + 1}{at} of {points.name!r}", found, points.place(index + 1))


def touch_findings(worst: WorstTouch, confidence: float) -> Iterator[Finding]:
    """Yields a warning where the worst touch is worse than chance makes it."""
    if worst.found.p_value < 1.0 - confidence:
        hint = "measure it again, or leave it out: it bends the part's surface around it"
        yield Finding(
            Severity.WARNING, Code.SRF_OUTLIER, worst.words, hint, worst.place, values={"p_value": worst.found.p_value}
        )
