"""Whether an inspection after the finish cut can be of the part that was touched before it."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.part import Part
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.loops.turned.correction import Correction
from trueloop.statistics import rms
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.plausibility import ON_PROFILE_MM
from trueloop.units import MM_PER_INCH, UM_PER_MM

LARGEST: Final = 2.0
"""A cut whose correction was not run leaves what was touched before it, one corrected twice as much on the other side:
errors this many times as large as those, and as the bands of the prediction, have another cause."""


def other_points(part: Part, before: Correction, after: ErrorVectors) -> Iterator[Finding]:
    """Yields a warning where the points are not those that were touched before the finish cut.

    With memory few are touched: more that are inspected then are no other plan.
    """
    touched, found = len(before.touches.point), len(after.point)
    near = sum(bool(_distances_mm(before, place).min() <= ON_PROFILE_MM) for place in after.nominal_mm)
    fewer_touched = before.memory is not None and near == touched
    if (near, found) != (found, touched) and not fewer_touched:
        yield Finding(
            Severity.WARNING,
            Code.STO_PATTERN,
            f"part {part.serial!r} was inspected at {found} points, {near} of which are among the {touched} that were "
            "touched before its finish cut",
            hint="where a point belongs to another part or another plan, replace the inspection; else it counts",
            values={"serial": part.serial, "points": float(found)},
        )


def require_size(before: Correction, after: ErrorVectors) -> None:
    """Raises STO-UNIT for errors too large to be what a finish cut left, for those that a unit would explain, and for
    errors that are all exactly zero.
    """
    size, touched = rms(after.error_mm), rms(before.model.vectors.error_mm)
    band = rms(before.prediction.expanded_u_mm)
    by_unit = _unlike_mm(before, after) > LARGEST * band and size / MM_PER_INCH <= band
    if 0.0 < size <= LARGEST * (touched + band) and not by_unit:
        return
    factor = f"; {MM_PER_INCH} or {UM_PER_MM:g} times too much?" if size else ": filled in, not measured?"
    raise TrueloopError(
        Code.STO_UNIT,
        f"the errors after the finish cut are {size * UM_PER_MM:.1f} µm RMS, those before it "
        f"{touched * UM_PER_MM:.1f} µm{factor}",
        hint="check the unit of the file (--unit), and that it holds errors of this part",
        override="--accept STO-UNIT",
        values={"size_um": size * UM_PER_MM, "other_um": touched * UM_PER_MM},
    )


def _unlike_mm(before: Correction, after: ErrorVectors) -> float:
    """By how much the errors are other than nothing, than those before the cut (not corrected), and than these with
    the other sign (corrected twice), RMS at common places; 0 without any.
    """
    distances = np.array([_distances_mm(before, place) for place in after.nominal_mm])
    common = distances.min(axis=1) <= ON_PROFILE_MM
    if not np.any(common):
        return 0.0
    found, was = after.error_mm[common], before.model.vectors.error_mm[distances.argmin(axis=1)[common]]
    return min(rms(found - share * was) for share in (0.0, 1.0, -1.0))


def _distances_mm(before: Correction, place: Array) -> Array:
    return np.asarray(np.linalg.norm(before.touches.nominal_mm - place, axis=1))
