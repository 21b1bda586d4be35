"""A table as one row a value, whatever stood in its columns: values, parts, repeats or characteristics.

Its columns of text become numbers in mm and degrees, with the symbols and units that stand in the cells.
"""

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Unit
from trueloop.formats.inspections.shared.text import NUMBER, is_empty, number_in
from trueloop.formats.inspections.tables.grid import Grid, Row
from trueloop.formats.inspections.tables.header import Header, is_unit_row
from trueloop.formats.inspections.tables.headings import (
    ANGLE_DEG,
    LENGTH_MM,
    LENGTHS,
    OF_VALUES,
    Role,
    is_statistic,
    plain,
    unit_in_heading,
    unit_named,
    without_unit,
)
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.mapping import map_command
from trueloop.wording import shell_word


@dataclass(frozen=True)
class Long:
    """Texts by role, one for each value, with the lines they stand in; empty where a cell states nothing.

    `columns` are those of the roles, for places; `units` those of columns whose heading or row of units names one.
    `left_out`: rows of statistics, the text by which each is known, by its line. `quantity` is that of the headings of
    values.
    """

    grid: Grid
    lines: Sequence[int]
    texts: Mapping[Role, Sequence[str]]
    columns: Mapping[Role, Sequence[int]]
    units: Mapping[Role, str] = field(default_factory=dict)
    left_out: Mapping[int, str] = field(default_factory=dict)
    quantity: Quantity | None = None

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
    units = {role: unit for role, unit in units.items() if role in LENGTHS or role is Role.TOLERANCE}
    quantity = _quantity(body) if not columns.characteristics else None
    return Long(grid, long.lines, texts, long.columns, units, left_out=left_out, quantity=quantity)


def _quantity(body: _Body) -> Quantity | None:
    """The quantity that headings of values name. Raises MSR-MEANING for several, as `Ø Ist` and `Radius Abw`."""
    header = body.header
    places = [header.names.index(name) for role, name in body.named.items() if role in OF_VALUES]
    named = {quantity: header.names[k] for k in places if (quantity := header.quantities[k]) is not None}
    if len(named) > 1:
        first, other = list(named.values())[:2]
        command = map_command(body.grid.path, f"--column ignored={shell_word(other)}")
        raise Code.MSR_MEANING.refusal(
            f"{body.grid.path.name!r}: {first!r} and {other!r} are of {len(named)} quantities",
            hint=f"leave one of them out: {command}",
            place=body.grid.at(header.row),
        )
    return next(iter(named), None)


def _unit(name: str, header: Header, unit_row: Row) -> str:
    place = header.names.index(name)
    below = unit_named(unit_row[place]) if place < len(unit_row) else ""
    return below or unit_in_heading(name)


def _body(grid: Grid, header: Header, mapping: TableMapping, first: int) -> tuple[_Body, dict[int, str]]:
    """The rows with something in a mapped column; headings that are repeated and rows of statistics left out."""
    used = [header.names.index(name) for name in mapping.columns.all() if name not in mapping.columns.ignored]
    named = mapping.columns.named()
    heading = grid.rows[header.row]
    body = [
        (row, line)
        for row, line in zip(grid.rows[first:], grid.lines[first:], strict=True)
        if any(row) and row != heading and any(row[k] for k in used if k < len(row))
    ]
    left_out = _statistics(body, header, mapping, used[0])
    rows, lines = (
        [row for row, line in body if line not in left_out],
        [line for _, line in body if line not in left_out],
    )
    return _Body(grid, rows, lines, header, named), left_out


OF_ROW: Final = (Role.SERIAL, Role.CHARACTERISTIC, Role.DATE, Role.TIME, Role.PART)
"""Roles of texts that state the content of a row: `Mean` in them names a statistic."""
SHORT: Final = 2
"""Words of so few letters may be initials, or a part's number: `MW`, `Cp`, `3s`."""
LABELS: Final = (Role.SERIAL, Role.CHARACTERISTIC, Role.FEATURE)
"""Roles of texts by which a row is known, the first that a table has."""


def _statistics(
    body: Sequence[tuple[Row, int]], header: Header, mapping: TableMapping, first_used: int
) -> dict[int, str]:
    """Returns the rows of statistics: the text by which each is known, by its line.

    It stands in a column that states the content of a row, or in a first column without a role. Short words such as
    `MW` or `Cp` are initials or serial numbers where the row has a serial number or a date beside them.
    """
    place = {role: header.names.index(name) for role, name in mapping.columns.named().items()}
    label = next((place[role] for role in LABELS if role in place), first_used)
    of_row = {label, *(place[role] for role in OF_ROW if role in place)} | ({0} - set(place.values()))
    times = {place[role] for role in (Role.DATE, Role.TIME) if role in place}
    own = times | ({place[Role.SERIAL]} if Role.SERIAL in place else set())
    wide, labels = bool(mapping.columns.characteristics), set(map(plain, mapping.rows.named().values()))

    def words(row: Row, columns: set[int]) -> dict[int, str]:
        cells = {k: row[k] for k in sorted(columns) if k < len(row) and not is_empty(row[k])}
        return {k: name for k, text in cells.items() if (name := plain(text)) and name not in labels}

    def of_statistics(row: Row, columns: set[int], doubtful: bool) -> Iterator[str]:
        stated = any(not is_statistic(name, doubtful=True) for name in words(row, own).values())
        for k, name in words(row, columns).items():
            short = len(name.replace(" ", "")) <= SHORT
            if is_statistic(name, doubtful and (wide or not short)) and not (short and stated):
                yield row[k]

    found = {line: text for row, line in body for text in itertools.islice(of_statistics(row, of_row, False), 1)}
    doubtful = times | {label} if wide or found else times
    for row, line in body:
        if label < len(row) and row[label].upper() == "END" and sum(map(bool, row)) == 1:
            found[line] = row[label]
        for text in of_statistics(row, doubtful, True):
            found.setdefault(line, text)
    return dict(sorted(found.items()))


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


PLAIN: Final = frozenset("0123456789+-.,eE")
DRESSED: Final = re.compile(rf"([ØøR⌀∅±n]?)\s*({NUMBER.pattern})\s*(\S*(?: \S+)?)")
PLUS_MINUS: Final = re.compile(rf"(?:±|\+\s*/?\s*-)\s*({NUMBER.pattern})")
BOTH: Final = re.compile(
    rf"\+?\s*({NUMBER.pattern})(?:\s*[/|;]\s*|\s+|(?=[-+]))([-+]\s*(?:{NUMBER.pattern})|0(?:[.,]0*)?)"
)
"""Two tolerances: a separator, a blank or the sign of the second stands between them."""
Where = Callable[[int], Place]


@dataclass(frozen=True)
class Numbers:
    """Numbers, (n,), nan where a cell states nothing; units and symbols that stood in cells, by row."""

    values: Array
    units: dict[int, str]
    symbols: dict[int, str]


def numbers_of(texts: Sequence[str], where: Where) -> Numbers:
    """Reads a column of numbers, each with a decimal point or comma. Raises MSR-NUMBER for a text that is none."""
    if set().union(*set(texts)) <= PLAIN:
        try:
            values = np.array([float(text.replace(",", ".")) if text else np.nan for text in texts])
            if not np.any(np.isinf(values)):
                return Numbers(values, {}, {})
        except ValueError:
            pass
    units: dict[int, str] = {}
    symbols: dict[int, str] = {}
    found = np.full(len(texts), np.nan)
    for row, text in enumerate(texts):
        if text:
            found[row] = _dressed(text.replace("−", "-"), row, where, units, symbols)
    return Numbers(found, units, symbols)


def _dressed(text: str, row: int, where: Where, units: dict[int, str], symbols: dict[int, str]) -> float:
    """A number with what stands before and after it."""
    match, place = DRESSED.fullmatch(text), where(row)
    number = text
    if match is not None and (not match[3] or unit_named(match[3])):
        number = match[2]
        if match[1]:
            symbols[row] = match[1]
        if match[3]:
            units[row] = unit_named(match[3])
    return number_in(number, Path(place.file or ""), place.line or 0, place.column)


def tolerances_of(texts: Sequence[str], zone: Flags) -> tuple[Numbers, Numbers, list[int]]:
    """Returns lower and upper tolerance of cells such as `±0.02`, `+0.02/-0.01 mm`, and the rows of other cells.

    A plain number is the upper tolerance where `zone`, (n,): of a form or a runout; of a size it may be either.
    """
    lower, upper = np.full(len(texts), np.nan), np.full(len(texts), np.nan)
    units: dict[int, str] = {}
    other = []
    for row, cell in enumerate(texts):
        text, unit = _without_unit(cell.replace("−", "-"))
        if plus_minus := PLUS_MINUS.fullmatch(text):
            upper[row] = _float(plus_minus[1])
            lower[row] = -upper[row]
        elif both := BOTH.fullmatch(text):
            ends = _float(both[1]), _float(both[2])
            lower[row], upper[row] = min(ends), max(ends)
        elif zone[row] and NUMBER.fullmatch(text):
            upper[row] = _float(text)
        elif text:
            other.append(row)
            continue
        if unit:
            units[row] = unit
    return Numbers(lower, units, {}), Numbers(upper, units, {}), other


def _without_unit(cell: str) -> tuple[str, str]:
    """A cell without the unit behind its last digit, and that unit."""
    end = max((k for k, letter in enumerate(cell) if letter.isdigit()), default=-1) + 1
    end += cell[end : end + 1] in (".", ",")
    unit = unit_named(cell[end:])
    return (cell[:end], unit) if unit else (cell, "")


def _float(text: str) -> float:
    return float(text.replace(",", ".").replace(" ", ""))


def factor_of(unit: str, is_angle: bool) -> float | None:
    """Returns the factor from that unit to mm, or of an angle to degrees; None: no unit of it."""
    return ANGLE_DEG.get(unit, 1.0 if unit in LENGTH_MM else None) if is_angle else LENGTH_MM.get(unit)


def lengths_of(long: Long, role: Role, unit: Unit | None) -> Array:
    """Reads a column of lengths in mm, (n,), nan where not stated. Raises MSR-UNIT where its unit is stated nowhere."""
    numbers = numbers_of(long.texts[role], long.where(role))
    return numbers.values * factors_of(long, role, numbers, unit, np.zeros(len(long), dtype=bool))


def factors_of(long: Long, role: Role, numbers: Numbers, unit: Unit | None, angle: Flags) -> Array:
    """Returns the mm, where `angle` the degrees, in the unit of each number of a column, (n,).

    A unit in the cell counts for that cell alone; then those of the heading, of the row, and of the whole file count.
    Raises MSR-UNIT where a number has none.
    """
    own = long.units.get(role)
    each = [own] if own else [unit_named(text) or unit or "" for text in long.texts.get(Role.UNIT, ())] or [unit or ""]
    of_length = {
        name: (unit or "") if name in ANGLE_DEG and not own else name for name in set(each)
    }  # an angle's place
    lengths = {name: factor_of(other, False) or np.nan for name, other in of_length.items()}
    angles = {name: factor_of(name, True) or 1.0 for name in set(each)}
    factors = np.where(angle, [angles[name] for name in each], [lengths[name] for name in each])
    for row, name in numbers.units.items():
        factors[row] = factor_of(name, bool(angle[row])) or np.nan
    missing = ~np.isnan(numbers.values) & np.isnan(factors)
    if np.any(missing):
        row = int(np.argmax(missing))
        raise _no_unit(long, role, row, numbers.units.get(row) or each[row % len(each)])
    return factors


def _no_unit(long: Long, role: Role, row: int, own: str) -> TrueloopError:
    """Returns the refusal MSR-UNIT of a number whose unit is not known."""
    name = long.grid.path.name
    why = f"{own!r} is not a unit of length" if own else f"the unit of {role} is stated nowhere in {name!r}"
    return Code.MSR_UNIT.refusal(
        why,
        hint='state it: `--unit mm` or `--unit inch`, or unit = "mm" in the mapping',
        place=long.place(role, row),
        values={"file": name},
    )
