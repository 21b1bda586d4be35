"""Data common to the values of a table: part, time, device, stated in columns or in lines above the headings."""

import itertools
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.measured_file import Unit
from trueloop.formats.inspections.shared.times import moment, order_of
from trueloop.formats.inspections.tables.grid import Grid, is_empty
from trueloop.formats.inspections.tables.header import Header
from trueloop.formats.inspections.tables.headings import KNOWN, plain
from trueloop.formats.inspections.tables.long import Long
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.roles import LENGTH_MM, Role, unit_stated_in
from trueloop.units import MM_PER_INCH

TITLES: Final = (Role.PART, Role.SERIAL, Role.DATE, Role.TIME, Role.OPERATOR, Role.DEVICE)
"""Roles that lines above the headings may state for the whole file."""


@dataclass(frozen=True)
class Common:
    """Data common to readings and points of a table: part, time, place, device."""

    long: Long
    title: Mapping[Role, str]
    mapping: TableMapping

    def texts(self, role: Role) -> Sequence[str]:
        """Returns a column's texts, or for all rows the title's."""
        if role in self.long.texts:
            return self.long.texts[role]
        return [self.title.get(role, "")] * len(self.long)

    def text(self, role: Role, row: int) -> str:
        """Returns the cell of a role in a row."""
        return self.long.texts[role][row] if role in self.long.texts else self.title.get(role, "")

    def groups(self) -> dict[tuple[str, str], list[int]]:
        """Returns the rows of each part, in the file's order."""
        found: defaultdict[tuple[str, str], list[int]] = defaultdict(list)
        for row, key in enumerate(zip(self.texts(Role.PART), self.texts(Role.SERIAL), strict=True)):
            found[key].append(row)
        return dict(found)

    def moments(self) -> Sequence[datetime | None]:
        """Returns the time of measurement of each row. Raises MSR-TIME."""
        dates, times = self.texts(Role.DATE), self.texts(Role.TIME)
        if any(dates) and any(times) and not _has_date(times):
            texts = [f"{_day(date)} {time}" if date and time else date for date, time in zip(dates, times, strict=True)]
        else:
            texts = list(times if _has_date(times) else dates)
        role = Role.DATE if Role.DATE in self.long.texts else Role.TIME
        order = self.mapping.dates or order_of(texts, self.long.place(role, 0))
        first = {text: row for row, text in reversed(list(enumerate(texts)))}
        known = {text: moment(text, order, self.long.place(role, row)) for text, row in first.items()}
        return [known[text] for text in texts]

    def inspection(self, key: tuple[str, str], rows: Sequence[int], sha256: str, values: Sequence[Reading | CmmPoint], at: datetime | None) -> Inspection:  # fmt: skip  # noqa: E501
        """Returns the inspection of one part."""
        return Inspection(
            part=Part(PartType(key[0]), key[1]),
            measured="readings" if isinstance(values[0], Reading) else "CMM points",
            sha256=sha256,
            count=len(values),
            values=tuple(values),
            device=self.text(Role.DEVICE, rows[0]),
            operator=self.text(Role.OPERATOR, rows[0]),
            measured_at=at,
        )


def _has_date(texts: Sequence[str]) -> bool:
    return any(
        (len(text) >= 6 and sum(map(text.count, "./-")) >= 2) or (len(text) >= 8 and text.isdigit())
        for text in texts
        if text
    )


def _day(date: str) -> str:
    """A date of a workbook has a time of 0 h beside it."""
    return date.removesuffix(" 00:00:00")


def title_of(grid: Grid, header: Header) -> dict[Role, str]:
    """Reads `Operator: Meier` above the headings, in one cell or in two."""
    found: dict[Role, str] = {}
    for row in grid.rows[: header.title]:
        cells = [cell for cell in row if not is_empty(cell)]
        for cell, after in itertools.pairwise([*cells, ""]):
            name, _, value = cell.partition(":")
            role = KNOWN.get(plain(name), (None, 0))[0]
            if role in TITLES and (text := value.strip() or after):
                found.setdefault(role, text)
    return found


def unit_of_headings(long: Long) -> Unit | None:
    """Returns millimetre or inch where headings name one of them, for the columns whose headings name none."""
    named = {factor for unit in long.units.values() if (factor := LENGTH_MM.get(unit)) in (1.0, MM_PER_INCH)}
    return None if len(named) != 1 else "mm" if named == {1.0} else "inch"


def unit_of_title(grid: Grid, header: Header) -> Unit | None:
    """Returns the unit that the lines above the headings state for all lengths; None: none."""
    for row in grid.rows[: header.title]:
        if unit := unit_stated_in(" ".join(row)):
            return unit
    return None
