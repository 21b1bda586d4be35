"""Tables of any columns, CSV or workbook, read by a mapping: one that is given, else the one their headings say."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, Stated, Unit
from trueloop.formats.inspections.shared.text import beginning, read_decoded
from trueloop.formats.inspections.tables.common import Common, title_of, unit_of_headings, unit_of_title
from trueloop.formats.inspections.tables.grid import Grid, grid_of_text
from trueloop.formats.inspections.tables.header import Header, find_header, header_at, score
from trueloop.formats.inspections.tables.long import Long, long_of
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.mapping import read_mapping, require_columns
from trueloop.formats.inspections.tables.points import with_points
from trueloop.formats.inspections.tables.propose import propose
from trueloop.formats.inspections.tables.readings import with_readings
from trueloop.formats.inspections.tables.roles import Role
from trueloop.formats.inspections.tables.sizes import sizes_of
from trueloop.formats.inspections.tables.workbook import is_workbook, sheets_of

NAMES: Final = frozenset((".csv", ".tsv", ".tab"))
TITLES: Final = (Role.PART, Role.SERIAL, Role.DATE, Role.TIME, Role.OPERATOR, Role.DEVICE)
"""What lines above the headings may say of the whole file."""


def recognises(path: Path, head: bytes) -> bool:
    """A workbook, a file named as CSV, or a text with a row of known headings."""
    if is_workbook(path, head) or path.suffix.lower() in NAMES:
        return True
    if b"\0" in head[:64] and not head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return False
    return score(grid_of_text(beginning(head), path, "", "", score).rows) > 0


def read(path: Path, stated: Stated) -> MeasuredFile:
    """The file's inspections, by the mapping that is stated or by the headings.

    Raises MSR-MAPPING where the mapping is not of this file, MSR-MEANING where headings leave a choice, MSR-UNIT,
    MSR-NUMBER, MSR-EXCHANGED and MSR-TIME for what stands in the cells, MSR-FILE for a file that cannot be read.
    """
    if stated.mapping is None:
        grid = grid_of(path)
        mapping = propose(grid)
        said = (Remark(f"columns by their headings: {described(mapping)}", mapping.header_row),)
        return read_mapped(grid, mapping, stated, None, said)
    mapping = read_mapping(stated.mapping)
    return read_mapped(grid_of(path, mapping.sheet, mapping.separator), mapping, stated, stated.mapping)


def grid_of(path: Path, sheet: str = "", separator: str = "") -> Grid:
    """A file's cells; of a workbook those of the sheet of that name, or of the only one with headings.

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
    names = [name for name, one in sheets.items() if find_header(one.rows)] or list(sheets)
    if sheet or len(names) != 1:
        listed = ", ".join(map(repr, names[:8]))
        why = f"has no sheet {sheet!r}" if sheet else f"has {len(names)} sheets that may be read"
        hint = f"name one: trueloop measure map {path.name} --sheet {names[0] if names else 'NAME'!r}"
        raise TrueloopError(
            Code.MSR_MEANING, f"{path.name!r} {why}: {listed}", hint=hint, place=Place(str(path)),
            values={"file": path.name},
        )  # fmt: skip
    return sheets[names[0]]


def described(mapping: TableMapping) -> str:
    """The mapping in one line."""
    parts = [f"{role} {name!r}" for role, name in mapping.columns.named().items()]
    for key in ("parts", "repeats", "characteristics", "ignored"):
        if names := getattr(mapping.columns, key):
            parts.append(f"{key} {', '.join(map(repr, names))}")
    return "; ".join(parts)


def read_mapped(
    grid: Grid, mapping: TableMapping, stated: Stated, source: Path | None, said: Sequence[Remark] = ()
) -> MeasuredFile:
    """The inspections of a table by its mapping, which `source` holds. Raises as `read`."""
    header = _header(grid, mapping, source)
    title = title_of(grid, header)
    long = long_of(grid, header, mapping)
    unit = _unit(grid, header, long, mapping, stated)
    if not len(long):
        raise TrueloopError(
            Code.MSR_FILE,
            f"{grid.path.name!r} has 0 rows under its headings",
            hint="export it again",
            place=grid.at(header.row),
        )
    common = Common(long, title, mapping)
    sha256 = sha256_of(grid.path.read_bytes())
    if mapping.columns.has_values:
        return with_readings(common, unit, sha256, said)
    return with_points(common, unit, sha256, said)


def settled(grid: Grid, mapping: TableMapping, stated: Stated) -> TableMapping:
    """A proposed mapping with the unit and the signs that the file's values tell. Raises as `read`."""
    header = _header(grid, mapping, None)
    long = long_of(grid, header, mapping)
    unit = _unit(grid, header, long, mapping, stated)
    if mapping.columns.has_values:
        deviation, lower_tolerance = sizes_of(long, mapping, unit).conventions
        found = {"deviation": deviation if Role.DEVIATION in long.texts else None, "lower_tolerance": lower_tolerance}
        mapping = mapping.model_copy(update=found)
    return mapping.model_copy(update={"unit": unit})


def _unit(grid: Grid, header: Header, long: Long, mapping: TableMapping, stated: Stated) -> Unit | None:
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
    found = next((one for one in others if wanted <= set(one.names)), None)
    if found is None:
        require_columns(mapping, stated.names, grid.at(first), source)
    return found or stated


FORMAT: Final = Format("table (CSV or workbook)", recognises, read)
