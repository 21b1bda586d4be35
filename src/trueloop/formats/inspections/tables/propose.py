"""A mapping proposed from a table's headings, refused where they may mean several things."""

from collections import defaultdict
from collections.abc import Mapping as Map
from collections.abc import Sequence
from typing import Any, Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.shared.text import NUMBER, is_empty
from trueloop.formats.inspections.tables.grid import Grid
from trueloop.formats.inspections.tables.header import (
    Header,
    begins_as_number,
    find_header,
    header_at,
    known,
    numbered,
    role_of,
    stated_above,
)
from trueloop.formats.inspections.tables.headings import (
    BAD,
    ENDS,
    GOOD,
    IGNORED,
    IN_DOUBT,
    KNOWN,
    LIMITS,
    NUMBERS,
    POINT,
    SIZES,
    TYPES,
    Role,
    is_statistic,
    names_in,
    plain,
)
from trueloop.formats.inspections.tables.mapping import Columns, Mapping, RowLabels, check, map_command
from trueloop.wording import first_of, shell_word

LOOKED_AT: Final = 200
"""Rows whose cells separate numbers from texts, and limits from tolerances."""
REPEATS: Final = frozenset(
    names_in("messung, measurement, reading, repeat, wiederholung, trial, run, lauf, durchgang, ablesung")
)
PARTS: Final = frozenset(name for name, (role, _) in KNOWN.items() if role is Role.SERIAL) | {
    "parts",
    "samples",
    "teile",
}
"""Headings that, with a number after them, are those of repeated readings, or of parts."""
LABELLED: Final = (Role.NOMINAL, *LIMITS, Role.TOLERANCE, Role.UNIT)
Given = Map[str, Sequence[str]]
"""The user's statements about columns: headings by role, or by `parts`, `repeats`, `characteristics`, `ignored`."""


def propose(grid: Grid, given: Given | None = None) -> Mapping:
    """The mapping that the headings say. Raises MSR-MEANING where they leave a choice, or name no actual value."""
    header = find_header(grid.rows)
    if header is None:
        raise _refusal(grid, f"none of its first rows, of {len(grid.rows)}, names columns that are known")
    if not any(map(any, grid.rows[header.row + 1 :])):
        raise Code.MSR_FILE.refusal(
            f"{grid.path.name!r} has 0 rows under its headings", hint="export it again", place=grid.at(header.row)
        )
    table = _Table(grid, header, given or {})
    columns = table.columns()
    mapping = Mapping(
        sheet=grid.sheet,
        separator=grid.separator,  # type: ignore[arg-type]  # pydantic checks it
        header_row=header.row + 1,
        header_rows=header.rows,  # type: ignore[arg-type]
        columns=columns,
        rows=table.labels(columns),
    )
    check(mapping, grid.path, Code.MSR_MEANING)
    return mapping


def numbers_left_out(grid: Grid, mapping: Mapping) -> list[str]:
    """Returns the headings of columns of numbers that a proposed mapping of readings leaves out, without statistics."""
    if not mapping.columns.has_values:
        return []
    header = header_at(grid.rows, mapping.header_row - 1, mapping.header_rows)
    table = _Table(grid, header, {})
    places = [header.names.index(name) for name in mapping.columns.ignored]
    free = [k for k in places if not is_statistic(header.plain[k], doubtful=True) and header.plain[k] not in IGNORED]
    return [header.names[k] for k in free if table.is_number(k)]


class _Table:
    """A table with its headings and what the user says of them."""

    def __init__(self, grid: Grid, header: Header, given: Given) -> None:
        self.grid, self.header, self.given = grid, header, given
        self.rows = grid.rows[header.row + 1 : header.row + 1 + LOOKED_AT]
        self.free = set(range(len(header.names)))
        for name in (name for names in given.values() for name in names):
            if name not in header.names:
                raise _refusal(grid, f"{name!r} is not one of its columns: {_listed(header.names)}", header.row)
            self.free.discard(header.names.index(name))

    def columns(self) -> Columns:
        """One column for each thing, and several where values of one kind stand side by side."""
        chosen = {**self._known(), **{key: names[0] for key, names in self.given.items() if key in set(Role)}}
        if chosen.keys() >= _POINTS and Role.NOMINAL not in chosen:
            chosen.pop(Role.DEVIATION, None)  # of points, which have theirs from their own coordinates
        several = {key: tuple(names) for key, names in self.given.items() if key not in set(Role)}
        chosen |= {} if several.keys() - {"ignored"} else self._of_quantity(chosen)
        values = self._several(chosen) if not _has_values(chosen, several) else {}
        taken = {*chosen.values(), *(name for names in (*several.values(), *values.values()) for name in names)}
        ignored = tuple(name for k, name in enumerate(self.header.names) if name not in taken and self.cells(k))
        content: dict[str, Any] = {**chosen, "ignored": ignored, **several, **values}
        return Columns.model_validate(content)

    def cells(self, column: int) -> list[str]:
        """The content under a heading."""
        return [row[column] for row in self.rows if column < len(row) and not is_empty(row[column])]

    def is_number(self, column: int) -> bool:
        """Returns whether most cells of a column are numbers."""
        cells = self.cells(column)
        return sum(map(begins_as_number, cells)) * 2 > len(cells) > 0

    def _known(self) -> dict[str, str]:
        """The headings of one meaning each, of several with one meaning those that say it best."""
        found: defaultdict[Role, list[tuple[int, int]]] = defaultdict(list)
        for column in sorted(self.free):
            role, rank = self._role(column) or (None, 0)
            fits = self.is_number(column) if role in NUMBERS else bool(self.cells(column))
            if role is not None and role.value not in self.given and fits:
                found[role].append((rank, column))
        if Role.SERIAL in found and Role.PART not in found and Role.PART.value not in self.given:
            best = min(rank for rank, _ in found[Role.SERIAL])
            types = [(rank, k) for rank, k in found[Role.SERIAL] if rank > best and self.header.plain[k] in TYPES]
            if not types and self._is_of_one_type([k for rank, k in found[Role.SERIAL] if rank == best]):
                types = found.pop(Role.SERIAL)
            found |= {Role.PART: types} if types else {}
        return {role.value: self._best(role, cases) for role, cases in found.items()}

    def _is_of_one_type(self, columns: Sequence[int]) -> bool:
        """Returns whether columns such as `Teil-Nr.` hold one type, and the serial number stands above the headings."""
        above = stated_above(self.grid.rows[: self.header.title])
        serial = any(role is Role.SERIAL and name not in TYPES for role, name, _ in above)
        return serial and all(self.header.plain[k] in TYPES and len(set(self.cells(k))) == 1 for k in columns)

    def _best(self, role: Role, cases: Sequence[tuple[int, int]]) -> str:
        least = min(rank for rank, _ in cases)
        best = [self.header.names[column] for rank, column in cases if rank == least]
        if len(best) > 1:
            raise self._refusal(f"{len(best)} columns may be the {role.value}: {_listed(best)}", role.value, best[0])
        return best[0]

    def _role(self, column: int) -> tuple[Role, int] | None:
        name = self.header.plain[column]
        if name in IGNORED:
            return None
        if name in SIZES and any("." in cell or "," in cell for cell in self.cells(column)) and self.is_number(column):
            return Role.NOMINAL, 1
        if name in ENDS:
            return self._end(column, ENDS[name])
        if name in IN_DOUBT and role_of(name, self.header.plain) is None:
            heading = self.header.names[column]
            raise self._refusal(f"{heading!r} may be upper_tolerance or lower_tolerance", "lower_tolerance", heading)
        found = role_of(name, self.header.plain)
        if (
            found is not None
            and found[0] is Role.ACTUAL
            and all(plain(cell) in GOOD | BAD for cell in self.cells(column))
        ):
            return None if self.is_number(column) else (Role.VERDICT, found[1])
        return found

    def _end(self, column: int, end: str) -> tuple[Role, int] | None:
        """A limit or a tolerance: the values of a limit are near the nominal ones, those of a tolerance near 0."""
        nominal = next((k for k, name in enumerate(self.header.plain) if role_of(name, ()) in _NOMINALS), None)
        if nominal is None or not self.is_number(column):
            return None
        pairs = [(_number(row[nominal]), _number(row[column])) for row in self.rows if len(row) > max(nominal, column)]
        known = [(abs(size - value), abs(value)) for size, value in pairs if size and value is not None]
        limits = sum(near_nominal < near_zero for near_nominal, near_zero in known)
        if 0 < limits < len(known):
            kind = "limit" if 2 * limits > len(known) else "tolerance"
            names = {ENDS[name]: k for k, name in reversed(list(enumerate(self.header.plain))) if name in ENDS}
            both = {f"{end}_{kind}": self.header.names[k] for end, k in sorted(names.items(), reverse=True)}
            why = f"column {self.header.names[column]!r} holds limits in {limits} of {len(known)} rows"
            raise self._refusal_of(why, {key: [name] for key, name in both.items() if key not in self.given})
        return Role(f"{end}_{'limit' if limits else 'tolerance'}"), 1

    def _of_quantity(self, chosen: dict[str, str]) -> dict[str, str]:
        """The column of actual values by a heading that is a quantity alone, `Diameter`, where a row is one value."""
        header = self.header
        bare = [
            k for k in sorted(self.free) if header.quantities[k] and not known(header.plain[k]) and self.is_number(k)
        ]
        if not bare or Role.ACTUAL in chosen or not {Role.CHARACTERISTIC, Role.FEATURE} & chosen.keys():
            return {}
        if len(bare) > 1:
            names = [header.names[k] for k in bare]
            raise self._refusal(f"{len(bare)} columns may be the actual: {_listed(names)}", "actual", names[0])
        return {"actual": header.names[bare[0]]}

    def _several(self, chosen: dict[str, str]) -> dict[str, tuple[str, ...]]:
        """Columns of numbers without a meaning of their own: of parts, of repeats, or of characteristics."""
        plains = self.header.plain
        free = [
            k
            for k in sorted(self.free)
            if self.header.names[k] not in chosen.values()
            and plains[k] not in IGNORED
            and not is_statistic(plains[k], doubtful=True)
        ]
        numbers = [k for k in free if self.is_number(k) and not self._counts_rows(k)]
        if Role.NOMINAL in chosen:
            numbers = [k for k in numbers if self._near(k, self.header.names.index(chosen[Role.NOMINAL]))] or numbers
        names = tuple(self.header.names[k] for k in numbers)
        bases = {self._base(k) for k in numbers}
        if not numbers or chosen.keys() >= _POINTS:
            return {}
        if Role.NOMINAL in chosen:
            if bases <= PARTS:
                return {"parts": names}
            if bases <= REPEATS:
                return {"repeats": names}
        elif Role.CHARACTERISTIC not in chosen and (
            Role.SERIAL in chosen or Role.TIME in chosen or Role.DATE in chosen
        ):
            return {"characteristics": names}
        key = "actual" if len(names) == 1 else "parts"
        what = "which column is the actual value" if len(names) == 1 else "whether columns are parts or repeats"
        raise self._refusal(f"its headings do not say {what}: {_listed(names)}", key, *names)

    def _counts_rows(self, column: int) -> bool:
        """Returns whether a column without a heading in words, as `#`, holds the numbers of rows."""
        cells = self.cells(column)
        return not self.header.plain[column] and cells == [str(k) for k in range(1, len(cells) + 1)]

    def _near(self, column: int, nominal: int) -> bool:
        """Returns whether most values of a column are nearer to the nominal ones than to 0, as tolerances are not."""
        pairs = [(_number(row[nominal]), _number(row[column])) for row in self.rows if len(row) > max(nominal, column)]
        known = [abs(size - value) <= abs(value) for size, value in pairs if size and value is not None]
        return not known or 2 * sum(known) > len(known)

    def _base(self, column: int) -> str | None:
        """A heading without its number; of a bare number the title in the row above it."""
        base = numbered(self.header.plain[column])
        if base or not self.header.title:
            return base
        above = self.grid.rows[self.header.title - 1][: column + 1]
        return plain(next((cell for cell in reversed(above) if cell), ""))

    def _refusal(self, why: str, key: str, *headings: str) -> TrueloopError:
        return self._refusal_of(why, {key: headings})

    def _refusal_of(self, why: str, columns: Given) -> TrueloopError:
        """The refusal with the command that names these columns, beside those that are named already."""
        every = [(key, name) for named in (self.given, columns) for key, names in named.items() for name in names]
        options = " ".join(f"--column {key}={shell_word(name)}" for key, name in every)
        hint = f"say which: {map_command(self.grid.path, options)}"
        return _refusal(self.grid, why, self.header.row, hint)

    def labels(self, columns: Columns) -> RowLabels:
        """Rows of nominal values and limits in a table of one row a part."""
        if not columns.characteristics:
            return RowLabels()
        column = self.header.names.index(columns.label or self.header.names[0])
        found: dict[str, str] = {}
        for cell in (row[column] for row in self.rows if column < len(row) and row[column]):
            role, _ = KNOWN.get(plain(cell), (None, 0))
            if role in LABELLED:
                found.setdefault(role, cell)
        return RowLabels.model_validate(found)


_NOMINALS: Final = ((Role.NOMINAL, 0),)
_POINTS: Final = frozenset(POINT)


def _has_values(chosen: Map[str, str], several: Map[str, Sequence[str]]) -> bool:
    if Role.ACTUAL in chosen or {"parts", "repeats", "characteristics"} & several.keys():
        return True
    return Role.DEVIATION in chosen and Role.NOMINAL in chosen


def _number(cell: str) -> float | None:
    return float(cell.replace(",", ".")) if NUMBER.fullmatch(cell) else None


def _listed(names: Sequence[str]) -> str:
    return first_of([*map(repr, names)], 8)


def _refusal(grid: Grid, why: str, row: int | None = None, hint: str = "") -> TrueloopError:
    place = Place(str(grid.path)) if row is None else grid.at(row)
    return Code.MSR_MEANING.refusal(
        f"{grid.path.name!r}: {why}",
        hint=hint or f"name the columns: {map_command(grid.path, '--column actual=HEADING')}",
        place=place,
    )
