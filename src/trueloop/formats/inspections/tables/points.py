"""The points of a table: measured x, y, z, with their nominal points and normals where it has them."""

from collections.abc import Sequence

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import CmmPoint, Vector
from trueloop.formats.inspections.measured_file import MeasuredFile, Remark, Unit
from trueloop.formats.inspections.tables.common import Common
from trueloop.formats.inspections.tables.long import Long
from trueloop.formats.inspections.tables.roles import NOMINAL_POINT, NORMAL, POINT, Role
from trueloop.formats.inspections.tables.values import length_factor, lengths_of, numbers_of
from trueloop.units import MM_PER_INCH


def with_points(common: Common, unit: Unit | None, sha256: str, said: Sequence[Remark]) -> MeasuredFile:
    """The inspections of a table of points. Raises MSR-UNIT, MSR-NUMBER and MSR-TIME."""
    long = common.long
    points, base = points_of(long, unit)
    moments = common.moments()
    inspections = []
    for key, rows in common.groups().items():
        values = [point for row in rows if (point := points[row]) is not None]
        if values:
            inspections.append(common.inspection(key, rows, sha256, values, moments[rows[0]]))
    missing = sum(point is None for point in points)
    remarks = [Remark(f"{missing} of {len(points)} points are not measured: cells are empty")] if missing else []
    return MeasuredFile(
        path=long.grid.path,
        format="table of points",
        encoding=long.grid.encoding,
        unit=base,
        inspections=tuple(inspections),
        remarks=(*said, *remarks),
    )


def points_of(long: Long, unit: Unit | None) -> tuple[list[CmmPoint | None], Unit]:
    """The points in mm, None for rows without one, and the file's unit."""
    measured, base = _vectors(long, POINT, unit), _unit_of(long, unit)
    nominal = _vectors(long, NOMINAL_POINT, unit) if all(role in long.texts for role in NOMINAL_POINT) else None
    normal = _normals(long) if all(role in long.texts for role in NORMAL) else None
    names = long.texts.get(Role.CHARACTERISTIC) or long.texts.get(Role.FEATURE) or [""] * len(long)
    nothing: list[Vector | None] = [None] * len(long)
    columns = zip(measured, nominal or nothing, normal or nothing, names, strict=True)
    return [
        None if point is None else CmmPoint(point, expected, direction, name)
        for point, expected, direction, name in columns
    ], base


def _unit_of(long: Long, unit: Unit | None) -> Unit:
    """The unit of x."""
    numbers = numbers_of(long.texts[Role.X], long.where(Role.X))
    return "inch" if length_factor(long, Role.X, numbers, unit) == MM_PER_INCH else "mm"


def _vectors(long: Long, roles: Sequence[Role], unit: Unit | None) -> list[Vector | None]:
    return _rows(np.stack([lengths_of(long, role, unit) for role in roles], axis=-1))


def _normals(long: Long) -> list[Vector | None]:
    columns = [numbers_of(long.texts[role], long.where(role)).values for role in NORMAL]
    vectors = np.stack(columns, axis=-1)
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return _rows(vectors / np.where(lengths > 0, lengths, np.nan))


def _rows(vectors: Array) -> list[Vector | None]:
    return [None if sum(row) != sum(row) else (row[0], row[1], row[2]) for row in vectors.tolist()]
