"""Features of a part without a profile, from nominal points, normals, sizes and names of what was measured.

Cylinders, faces and cones: points of one name that lie on a line, or unnamed ones with stated normals of one line. The
side of the material is that of the stated normals; without them outer surfaces are taken, and faces that look to the
free end.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.geometry.feature import Line

ON_LINE_MM: Final = 0.02
"""Nominal points are on one line within this: twice what a report in hundredths rounds to."""
LEAST_MM: Final = 1.0
"""Length that a feature known from one place is given, so that values can be matched with it."""
ALONG: Final = 1e-3
"""A normal with less than this across an axis is along it."""


@dataclass(frozen=True)
class _Hint:
    """That a feature has a point (x as a radius, z); `normal` (x, z) outward, NaN where not stated."""

    name: str
    at_mm: tuple[float, float]
    normal: tuple[float, float] = (float("nan"), float("nan"))


def inferred_shapes(inspections: Sequence[Inspection]) -> tuple[Line, ...]:
    """The straight features, in order from the chuck; those whose points lie on no line are left out."""
    groups: dict[str, list[_Hint]] = {}
    for hint in (hint for one in inspections for hint in _hints(one)):
        groups.setdefault(hint.name, []).append(hint)
    lengths = [one for each in inspections for one in each.readings if one.quantity is Quantity.LENGTH]
    for name, z in _faces(lengths, {name: hints[0].at_mm[1] for name, hints in groups.items()}).items():
        groups.setdefault(name, [_Hint(name, (LEAST_MM / 2.0, z), (0.0, 1.0))])
    shapes = (_line(name, hints) for name, hints in groups.items())
    found = [shape for shape in shapes if shape is not None]
    return tuple(sorted(found, key=lambda line: line.start_mm[1] + line.end_mm[1]))


def _hints(inspection: Inspection) -> Iterator[_Hint]:
    for value in inspection.values:
        if isinstance(value, Touch) and value.feature is not None:
            yield _Hint(value.feature, value.nominal_mm)
        elif isinstance(value, CmmPoint):
            yield from _of_point(value)
        elif isinstance(value, Reading):
            yield from _of_size(value)


def _of_point(point: CmmPoint) -> Iterator[_Hint]:
    """Named by the line that place and normal make: a point's own name may be that of the point alone."""
    if point.nominal_mm is None or point.outward_normal is None:
        return
    x, y, z = point.nominal_mm
    radius = float(np.hypot(x, y))
    across = point.outward_normal[0] if radius == 0.0 else float(np.dot(point.outward_normal[:2], (x, y))) / radius
    along = point.outward_normal[2]
    if abs(along) < ALONG:
        name = f"{'shaft' if across > 0 else 'bore'} of {2 * radius:.2f} mm"
    elif abs(across) < ALONG:
        name = f"face at {z:.2f} mm"
    else:
        off = across * radius + along * z
        name = f"cone of {np.degrees(np.arctan2(along, across)):.1f}° at {off:.1f} mm"
    yield _Hint(name, (radius, z), (across, along))


def _of_size(reading: Reading) -> Iterator[_Hint]:
    """A diameter or a radius makes a cylinder or a piece of a cone; at z 0 where its place is not stated."""
    size = reading.nominal
    if size is not None and reading.quantity in (Quantity.DIAMETER, Quantity.RADIUS):
        radius = size / 2.0 if reading.quantity is Quantity.DIAMETER else size
        at = reading.place_mm[-1] if reading.place_mm else 0.0
        yield _Hint(_name(reading), (radius, at), (-1.0 if reading.side == "inner" else 1.0, 0.0))


def _name(reading: Reading) -> str:
    return reading.feature or reading.characteristic


def _faces(lengths: Sequence[Reading], known_mm: Mapping[str, float]) -> dict[str, float]:
    """Z of the faces between which lengths are read, each away from the chuck of where it counts from, the first zero.

    `known_mm` are places of features that were touched.
    """
    z = {"": 0.0, **known_mm}
    waiting = [one for one in lengths if one.nominal is not None]
    while waiting:
        tied = next((one for one in waiting if one.other in z or _name(one) in z), waiting[0])
        waiting.remove(tied)
        assert tied.nominal is not None  # those without one were left out
        if tied.other not in z:
            z[tied.other] = z[_name(tied)] - tied.nominal if _name(tied) in z else 0.0
        z.setdefault(_name(tied), z[tied.other] + tied.nominal)
    return {name: at for name, at in z.items() if name not in ("", *known_mm)}


def _line(name: str, hints: Sequence[_Hint]) -> Line | None:
    places = np.array(sorted({hint.at_mm for hint in hints}))
    middle = places.mean(axis=0)
    normal = _normal(places - middle, np.array([hint.normal for hint in hints]))
    if normal is None:
        return None
    tangent = np.array([-normal[1], normal[0]])
    along = (places - middle) @ tangent
    short = max(LEAST_MM - float(np.ptp(along)), 0.0) / 2.0
    start, end = middle + (along.min() - short) * tangent, middle + (along.max() + short) * tangent
    return Line(name, (float(start[0]), float(start[1])), (float(end[0]), float(end[1])))


def _normal(off_middle: Array, stated: Array) -> Array | None:
    """Out of the material, of the line through the points; None where they lie on none, or one alone says nothing."""
    known = stated[~np.isnan(stated[:, 0])]
    side = known.mean(axis=0) if len(known) else np.array([1.0, ALONG])
    _, sizes, ways = np.linalg.svd(off_middle)
    if sizes[0] < ON_LINE_MM:
        length = float(np.linalg.norm(side))
        return side / length if len(known) and length > 0.5 else None
    if sizes[1] > ON_LINE_MM:
        return None
    normal: Array = np.where(np.abs(ways[1]) < ALONG, 0.0, ways[1])  # rounded coordinates make no cone
    turned: Array = np.copysign(1.0, normal @ side) * normal / np.linalg.norm(normal)
    return turned
