"""A table as one row a value, whatever stood in its columns: values, parts, repeats or characteristics."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from trueloop.errors import Place
from trueloop.formats.inspections.tables.grid import Grid, Row, is_empty
from trueloop.formats.inspections.tables.header import Header, is_unit_row
from trueloop.formats.inspections.tables.headings import SUMMARIES, plain
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.roles import LENGTHS, Role, unit_in_heading, unit_named, without_unit


@dataclass(frozen=True)
class Long:
    """Texts by role, one for each value, with the lines they stand in; empty where a cell states nothing.

    `columns` are those of the roles, for places; `units` those of columns whose heading or row of units names one.
    """

    grid: Grid
    lines: Sequence[int]
    texts: Mapping[Role, Sequence[str]]
    columns: Mapping[Role, Sequence[int]]
    units: Mapping[Role, str] = field(default_factory=dict)
    left_out: Sequence[int] = ()

    def place(self, role: Role, row: int) -> Place:
        """Returns the place of a value's text."""
        columns = self.columns.get(role, ())
        column = columns[row % len(columns)] + 1 if columns else None
        return Place(str(self.grid.path), self.lines[row], column)

    def where(self, role: Role) -> Callable[[int], Place]:
        """Returns the function from a row to the place of a role's cell."""
        return lambda row: self.place(role, row)

    def __len__(self) -> int:
        return len(self.lines)


@dataclass(frozen=True)
class _Body:
    """The rows under the headings, and how to get at a column."""

    grid: Grid
    rows: Sequence[Row]
    lines: Sequence[int]
    header: Header
    named: Mapping[Role, str]

    def column(self, name: str) -> list[str]:
        """Its texts, empty where a cell states nothing or is missing."""
        place = self.header.names.index(name)
        texts = [row[place] if place < len(row) else "" for row in self.rows]
        states = {text: "" if is_empty(text) else text for text in set(texts)}
        return [states[text] for text in texts]


def long_of(grid: Grid, header: Header, mapping: TableMapping) -> Long:
    """Returns the table's values under their roles."""
    first = header.row + 1
    unit_row = grid.rows[first] if first < len(grid.rows) and is_unit_row(grid.rows[first]) else ()
    body, left_out = _body(grid, header, mapping, first + bool(unit_row))
    shape: Callable[[_Body, TableMapping], Long]
    columns = mapping.columns
    shape = _of_characteristics if columns.characteristics else _of_several if columns.values else _plain
    long = shape(body, mapping)
    units = {role: unit for role, name in body.named.items() if (unit := _unit(name, header, unit_row))}
    several = {unit for name in columns.values if (unit := _unit(name, header, unit_row))}
    if len(several) == 1 and not columns.characteristics:
        units[Role.ACTUAL] = several.pop()
    units |= {Role(role): unit_named(unit) or unit for role, unit in mapping.units.items() if role in set(Role)}
    texts = dict(long.texts)
    if columns.characteristics and Role.UNIT not in texts:
        each = [_unit(name, header, unit_row) for name in columns.characteristics]
        texts |= {Role.UNIT: each * (len(long) // len(each))} if any(each) else {}
    return Long(grid, long.lines, texts, long.columns, {k: v for k, v in units.items() if k in LENGTHS}, left_out)


def _unit(name: str, header: Header, unit_row: Row) -> str:
    place = header.names.index(name)
    below = unit_named(unit_row[place]) if place < len(unit_row) else ""
    return below or unit_in_heading(name)


def _body(grid: Grid, header: Header, mapping: TableMapping, first: int) -> tuple[_Body, list[int]]:
    """The rows with something in a mapped column; headings that are repeated and rows of statistics left out."""
    used = [header.names.index(name) for name in mapping.columns.all() if name not in mapping.columns.ignored]
    named = mapping.columns.named()
    label = header.names.index(named.get(Role.SERIAL) or named.get(Role.CHARACTERISTIC) or header.names[used[0]])
    heading, wide = grid.rows[header.row], bool(mapping.columns.characteristics)
    rows, lines, left_out = [], [], []
    for row, line in zip(grid.rows[first:], grid.lines[first:], strict=True):
        if not any(row) or row == heading or not any(row[k] for k in used if k < len(row)):
            continue
        cell = row[label] if label < len(row) else ""
        if (wide and plain(cell) in SUMMARIES) or (cell.upper() == "END" and sum(map(bool, row)) == 1):
            left_out.append(line)
            continue
        rows.append(row)
        lines.append(line)
    return _Body(grid, rows, lines, header, named), left_out


def _plain(body: _Body, _: TableMapping) -> Long:
    texts = {role: body.column(name) for role, name in body.named.items()}
    columns: dict[Role, Sequence[int]] = {role: (body.header.names.index(name),) for role, name in body.named.items()}
    return Long(body.grid, body.lines, texts, columns)


def _of_several(body: _Body, mapping: TableMapping) -> Long:
    """One part or one repeat a column: those of one part stay together, in the order of the rows."""
    names, rows = mapping.columns.values, len(body.rows)
    places = [body.header.names.index(name) for name in names]
    actual = [text for name in names for text in body.column(name)]
    texts = {role: body.column(name) * len(names) for role, name in body.named.items()}
    which = [text for name in names for text in [name] * rows]
    if mapping.columns.parts:
        texts[Role.SERIAL] = which
    columns: dict[Role, Sequence[int]] = {role: (body.header.names.index(name),) for role, name in body.named.items()}
    columns[Role.ACTUAL] = tuple(place for place in places for _ in range(rows))
    return Long(body.grid, list(body.lines) * len(names), {**texts, Role.ACTUAL: actual}, columns)


def _of_characteristics(body: _Body, mapping: TableMapping) -> Long:
    """One row a part: nominal values and limits are those of the labelled rows."""
    names = mapping.columns.characteristics
    labels = {plain(label): role for role, label in mapping.rows.named().items()}
    label_column = body.column(mapping.columns.label or body.header.names[0])
    kinds = [labels.get(plain(text)) for text in label_column]
    cells = {name: body.column(name) for name in names}
    parts = [k for k, kind in enumerate(kinds) if kind is None]
    texts: dict[Role, list[str]] = {Role.ACTUAL: [cells[name][k] for k in parts for name in names]}
    texts[Role.CHARACTERISTIC] = [without_unit(name).strip() for name in names] * len(parts)
    for k, kind in enumerate(kinds):
        if kind is not None:
            texts[kind] = [cells[name][k] for name in names] * len(parts)
    for role, name in body.named.items():
        column = body.column(name)
        texts[role] = [column[k] for k in parts for _ in names]
    columns: dict[Role, Sequence[int]] = {role: (body.header.names.index(name),) for role, name in body.named.items()}
    columns[Role.ACTUAL] = tuple(body.header.names.index(name) for name in names)
    return Long(body.grid, [body.lines[k] for k in parts for _ in names], texts, columns)
