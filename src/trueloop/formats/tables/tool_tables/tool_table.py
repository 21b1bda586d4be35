"""A tool table as it was read: its rows, and where in the file each number stands, so that one can be replaced.

The text is that of the file byte for byte (Latin-1 gives each byte a character): what is not replaced stays as it is,
whatever encoding its comments are in.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.errors import Code, Place
from trueloop.units import MM_PER_INCH

Unit: TypeAlias = Literal["mm", "inch"]
XIs: TypeAlias = Literal["radius", "diameter"]
Kind: TypeAlias = Literal["geometry", "wear"]
UNIT_MM: Final[Mapping[Unit, float]] = {"mm": 1.0, "inch": MM_PER_INCH}
MARK: Final = "trueloop offset"
"""How a row says which correction changed it, in a comment where the format has comments."""
MARKED: Final = re.compile(rf" \(?;?{MARK} \w+(?: of \w+)?\)?")
HINT: Final = "docs/offsets.md lists the tool tables that are read"


@dataclass(frozen=True)
class Number:
    """A number of a table: its value in the table's unit, and the characters from `start` to `end` that it is made of.

    `head` is what has to stand before one that is not in the file yet; then `start` equals `end` and the value is 0.
    `width`: it stands in a column of that many characters, its trailing blanks included; 0: in none.
    """

    value: Decimal
    start: int
    end: int
    head: str = ""
    width: int = 0


@dataclass(frozen=True)
class ToolRow:
    """A table's entry of one tool, or of one edge of it: its geometry, or the wear that is added to that.

    `x`, `z` are offsets along the axes and `nose` the nose, as the table counts them; None: the table does not say, or
    has no place for it. `tip` is the orientation of the tip by the control's own numbers. `others` are further numbers,
    by their name in the table. `line_end` is where text can be added to the row's line.
    """

    tool: int
    kind: Kind
    line: int
    line_end: int
    x: Number | None = None
    z: Number | None = None
    nose: Number | None = None
    tip: int | None = None
    edge: int = 1
    name: str = ""
    others: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Convention:
    """How a format counts: X as a radius or a diameter (None: as the control is set up), likewise the nose.

    `decimals` are those of mm and of inch that are written, never fewer than a number has. `comment` opens and closes
    a comment at the end of a row; None: there are none. `read_only` says why tables of the format are not written.
    """

    name: str
    x_is: XIs | None
    nose_is: XIs
    decimals: tuple[int, int]
    comment: tuple[str, str] | None = None
    read_only: str = ""


@dataclass(frozen=True)
class ToolTable:
    """A table: `unit` is what the file itself says, or what was stated of it; None: neither."""

    path: Path
    convention: Convention
    text: str
    unit: Unit | None
    rows: tuple[ToolRow, ...]
    remarks: tuple[str, ...] = ()

    @property
    def known_unit(self) -> Unit:
        """The unit. Raises OFS-UNIT where neither the file nor anybody says it."""
        if self.unit is None:
            raise Code.OFS_UNIT.refusal(
                f"{self.path.name!r} ({self.convention.name}) does not say whether its {len(self.rows)} rows are in mm "
                "or inch",
                hint="state it: `--unit mm` or `--unit inch`; in a job, `tool.table_unit`",
                place=Place(str(self.path)),
            )
        return self.unit

    @property
    def step(self) -> Decimal:
        """The smallest step that is written, in the table's unit."""
        return Decimal(1).scaleb(-self.convention.decimals[self.known_unit == "inch"])

    def place(self, row: ToolRow) -> Place:
        """Where the row stands."""
        return Place(str(self.path), row.line)

    def with_unit(self, stated: Unit | None) -> Unit | None:
        """The unit, the one that is stated included. Raises OFS-UNIT where the file says another."""
        if stated is not None and self.unit not in (None, stated):
            raise Code.OFS_UNIT.refusal(
                f"{self.path.name!r} says that it is in {self.unit}, where {stated} is stated",
                hint="take the table of the control that runs the program, or leave out what is stated",
                place=Place(str(self.path)),
            )
        return self.unit or stated


def replaced(table: ToolTable, values: Iterable[tuple[Number, Decimal]], row: ToolRow, mark: str) -> bytes:
    """The file with numbers of a row replaced and, where the format has comments, a mark added to the row.

    A mark of an earlier correction goes: LinuxCNC's rows have a length that they may not exceed. Raises OFS-ROW where a
    number does not fit into its column.
    """
    edits = [(number.start, number.end, _text(table, row, number, value)) for number, value in values]
    if table.convention.comment is not None:
        opened, closed = table.convention.comment
        start = table.text.rfind("\n", 0, row.line_end) + 1
        line = table.text[start : row.line_end]
        edits += [(start + old.start(), start + old.end(), "") for old in MARKED.finditer(line)]
        opened = "" if opened == ";" and ";" in MARKED.sub("", line) else opened
        edits.append((row.line_end, row.line_end, f" {opened}{mark}{closed}"))
    text = table.text
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text.encode("latin-1")


def _text(table: ToolTable, row: ToolRow, number: Number, value: Decimal) -> str:
    """The number in the style of the old one: its sign habit, and at least as many decimals."""
    old = table.text[number.start : number.end].strip()
    new = f"{value:+f}" if old.startswith("+") else f"{value:f}"
    if not number.width:
        return number.head + new
    if len(new) >= number.width:
        raise Code.OFS_ROW.refusal(
            f"{new!r} does not fit into a column of {number.width} characters, where {old!r} stands",
            hint="enter the number at the control",
            place=table.place(row),
        )
    return new.ljust(number.width)


Line = tuple[int, int, str]
"""Its number from 1, the place of its first character in the text, and its characters without the line's end."""


def lines_of(text: str) -> Iterator[Line]:
    """The lines of a text, which end with a line feed, with or without a carriage return."""
    start = 0
    for number, line in enumerate(text.split("\n"), 1):  # `splitlines` would split at bytes of UTF-8 letters too
        yield number, start, line.rstrip("\r")
        start += len(line) + 1


def decimal(text: str, path: Path, line: int, column: int) -> Decimal:
    """A number. Raises OFS-NUMBER for what is none."""
    try:
        value = Decimal(text.strip())
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or abs(value) > 10**6:
        raise Code.OFS_NUMBER.refusal(
            f"{text!r} is no number that a tool table could hold",
            hint="save the table anew at the control",
            place=Place(str(path), line, column),
            values={"text": text},
        )
    return value


def whole(text: str, path: Path, line: int, column: int) -> int:
    """A whole number. Raises OFS-NUMBER for what is none."""
    value = decimal(text, path, line, column)
    if value != int(value):
        raise Code.OFS_NUMBER.refusal(
            f"{text!r} is no whole number", hint=HINT, place=Place(str(path), line, column), values={"text": text}
        )
    return int(value)


def words_of(text: str) -> str:
    """Text of a comment or a name: UTF-8 where it is that."""
    raw = text.encode("latin-1")
    try:
        return raw.decode("utf-8").strip()
    except UnicodeDecodeError:
        return text.strip()
