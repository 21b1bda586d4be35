"""Tables of any columns, CSV or workbook, read by a mapping: one that is given, else the one their headings say."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import CmmPoint, Vector
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts, Unit
from trueloop.formats.inspections.shared.text import beginning, read_decoded
from trueloop.formats.inspections.tables.grid import Grid, grid_of_text, is_workbook, sheets_of
from trueloop.formats.inspections.tables.header import Header, find_header, header_at, score
from trueloop.formats.inspections.tables.headings import NOMINAL_POINT, NORMAL, POINT, Role
from trueloop.formats.inspections.tables.long import Long, factors_of, lengths_of, long_of, numbers_of
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.mapping import map_command, read_mapping, require_columns
from trueloop.formats.inspections.tables.propose import numbers_left_out, propose
from trueloop.formats.inspections.tables.readings import (
    Common,
    statistics_left_out,
    title_of,
    unit_of_headings,
    unit_of_title,
    with_readings,
)
from trueloop.formats.inspections.tables.sizes import sizes_of
from trueloop.units import MM_PER_INCH
from trueloop.wording import shell_word


def with_points(common: Common, unit: Unit | None, sha256: str, notes: Sequence[Remark]) -> MeasuredFile:
    """Returns the inspections of a table of points. Raises MSR-UNIT, MSR-NUMBER and MSR-TIME."""
    long = common.long
    points, base = points_of(long, unit)
    inspections = []
    for key, rows, at in common.groups(points):
        values = [point for row in rows if (point := points[row]) is not None]
        if values:
            inspections.append(common.inspection(key, rows, sha256, values, at))
    missing = sum(point is None for point in points)
    remarks = [Remark(f"{missing} of {len(points)} points are not measured: cells hold no number")] if missing else []
    return MeasuredFile(
        path=long.grid.path,
        format="table of points",
        encoding=long.grid.encoding,
        unit=base,
        inspections=tuple(inspections),
        remarks=(*notes, *remarks, *statistics_left_out(long)),
    )


def points_of(long: Long, unit: Unit | None) -> tuple[list[CmmPoint | None], Unit]:
    """Returns the points in mm, None for rows without one, and the file's unit."""
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
    factors = factors_of(long, Role.X, numbers, unit, np.zeros(len(long), dtype=bool))
    return "inch" if factors[0] == MM_PER_INCH else "mm"


def _vectors(long: Long, roles: Sequence[Role], unit: Unit | None) -> list[Vector | None]:
    return _rows(np.stack([lengths_of(long, role, unit) for role in roles], axis=-1))


def _normals(long: Long) -> list[Vector | None]:
    columns = [numbers_of(long.texts[role], long.where(role)).values for role in NORMAL]
    vectors = np.stack(columns, axis=-1)
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return _rows(vectors / np.where(lengths > 0, lengths, np.nan))


def _rows(vectors: Array) -> list[Vector | None]:
    return [None if sum(row) != sum(row) else (row[0], row[1], row[2]) for row in vectors.tolist()]


NAMES: Final = frozenset((".csv", ".tsv", ".tab"))


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether the file is a workbook, named as CSV, or a text with a row of known headings."""
    if is_workbook(path, head) or path.suffix.lower() in NAMES:
        return True
    if b"\0" in head[:64] and not head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return False
    return score(grid_of_text(beginning(head), path, "", "", score).rows) > 0


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the file's inspections, by the stated mapping or by the headings.

    Raises MSR-MAPPING where the mapping is not of this file, MSR-MEANING where headings leave a choice, MSR-UNIT,
    MSR-NUMBER, MSR-EXCHANGED and MSR-TIME for the cells' content, MSR-FILE for a file that cannot be read.
    """
    if stated.mapping is None:
        grid = grid_of(path)
        mapping = propose(grid)
        said = [Remark(f"columns by their headings: {described(mapping)}", mapping.header_row)]
        if unread := numbers_left_out(grid, mapping):
            listed = ", ".join(map(repr, unread))
            said.append(Remark(f"{len(unread)} columns of numbers are not read: {listed}", mapping.header_row))
        return read_mapped(grid, mapping, stated, None, said)
    mapping = read_mapping(stated.mapping)
    return read_mapped(grid_of(path, mapping.sheet, mapping.separator), mapping, stated, stated.mapping)


def grid_of(path: Path, sheet: str = "", separator: str = "") -> Grid:
    """Returns a file's cells; of a workbook those of the sheet of that name, or of the only one with headings.

    Raises MSR-FILE, and MSR-MEANING where several sheets have headings or none has that name.
    """
    with path.open("rb") as file:
        head = file.read(8)
    if not is_workbook(path, head):
        text, encoding = read_decoded(path)
        return grid_of_text(text, path, encoding, separator, score)
    sheets = sheets_of(path)
    if sheet in sheets:
        return sheets[sheet]
    names = [name for name, grid in sheets.items() if find_header(grid.rows)] or list(sheets)
    if sheet or len(names) != 1:
        listed = ", ".join(map(repr, names[:8]))
        why = f"has no sheet {sheet!r}" if sheet else f"has {len(names)} sheets that may be read"
        hint = f"name one: {map_command(path, '--sheet ' + shell_word(names[0] if names else 'NAME'))}"
        raise Code.MSR_MEANING.refusal(f"{path.name!r} {why}: {listed}", hint=hint, place=Place(str(path))
        )  # fmt: skip
    return sheets[names[0]]


def described(mapping: TableMapping) -> str:
    """Describes the mapping in one line."""
    parts = [f"{role} {name!r}" for role, name in mapping.columns.named().items()]
    for key in ("parts", "repeats", "characteristics", "ignored"):
        if names := getattr(mapping.columns, key):
            parts.append(f"{key} {', '.join(map(repr, names))}")
    return "; ".join(parts)


def read_mapped(
    grid: Grid, mapping: TableMapping, stated: StatedFacts, source: Path | None, remarks: Sequence[Remark] = ()
) -> MeasuredFile:
    """Returns the inspections of a table by its mapping from the file `source`. Raises as `read`."""
    header = _header(grid, mapping, source)
    title = title_of(grid, header, mapping)
    long = long_of(grid, header, mapping)
    unit = _unit(grid, header, long, mapping, stated)
    if not len(long):
        raise Code.MSR_FILE.refusal(
            f"{grid.path.name!r} has 0 rows under its headings", hint="export it again", place=grid.at(header.row)
        )
    common = Common(long, title, mapping)
    sha256 = sha256_of(grid.path.read_bytes())
    if mapping.columns.has_values:
        return with_readings(common, unit, sha256, remarks)
    return with_points(common, unit, sha256, remarks)


def settled(grid: Grid, mapping: TableMapping, stated: StatedFacts) -> TableMapping:
    """Completes a proposed mapping with the unit and the signs that follow from the file. Raises as `read`."""
    header = _header(grid, mapping, None)
    long = long_of(grid, header, mapping)
    unit = _unit(grid, header, long, mapping, stated)
    if mapping.columns.has_values:
        deviation, lower_tolerance = sizes_of(long, mapping, unit).conventions
        found = {"deviation": deviation if Role.DEVIATION in long.texts else None, "lower_tolerance": lower_tolerance}
        mapping = mapping.model_copy(update=found)
    return mapping.model_copy(update={"unit": unit})


def _unit(grid: Grid, header: Header, long: Long, mapping: TableMapping, stated: StatedFacts) -> Unit | None:
    return mapping.unit or unit_of_title(grid, header) or unit_of_headings(long) or stated.unit


def _header(grid: Grid, mapping: TableMapping, source: Path | None) -> Header:
    """The headings where the mapping says, or in another row that has all of them: titles differ in length."""
    wanted = set(mapping.columns.all())
    rows = range(min(len(grid.rows), 200))
    first = min(mapping.header_row - 1, len(grid.rows) - 1)
    stated = header_at(grid.rows, first, mapping.header_rows)
    if wanted <= set(stated.names):
        return stated
    others = (header_at(grid.rows, row, mapping.header_rows) for row in rows)
    found = next((header for header in others if wanted <= set(header.names)), None)
    if found is None:
        require_columns(mapping, stated.names, grid.at(first), source)
    return found or stated


FORMAT: Final = Format("table (CSV or workbook)", recognises, read)
