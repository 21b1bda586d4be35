"""Offsets of a Fanuc or Haas control as a program of G10, as the control punches them.

Lathe: `G10 P1 X.. Z.. R.. Q..` is wear 1, `P10001` geometry 1; with L10 and L11 (Haas) geometry and wear of P1. Mill:
`G10 L10 P1 R..` length, L11 its wear, L12 radius or diameter, L13 its wear. A number without a decimal point counts
least increments: 0.001 mm, 0.0001 inch. G20 and G21 say the unit, where they stand. An increment (G91, U, W) is a
change and no value in force: a program that holds one is not a table.
"""

import re
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.tables.tool_tables.tool_table import (
    HINT,
    Convention,
    Kind,
    Line,
    Number,
    ToolRow,
    ToolTable,
    Unit,
    decimal,
    lines_of,
    whole,
)

FANUC: Final = Convention("Fanuc G10", None, "radius", (3, 4), ("(", ")"))
GEOMETRY_FROM: Final = 10_000
WORD: Final = re.compile(r"([A-Z])\s*([-+]?[\d.]*)")
COMMENT: Final = re.compile(r"\([^)]*\)?")
KINDS: Final[dict[int, Kind]] = {10: "geometry", 11: "wear", 12: "geometry", 13: "wear"}
LEAST: Final[dict[Unit, int]] = {"mm": 3, "inch": 4}


def recognises(path: Path, source: bytes) -> bool:
    """Returns whether the file has a block of G10 with P."""
    return re.search(rb"^[^(\n]*G10\s*(?:L\s*1[0-3]\s*)?P\s*\d", source, re.MULTILINE) is not None


def read(path: Path, text: str, unit: Unit | None) -> ToolTable:
    """Raises OFS-NUMBER, OFS-FILE and OFS-UNIT with the line."""
    own: Unit | None = None
    rows: list[ToolRow] = []
    for line in lines_of(text):
        words = _words(line)
        codes = {int(value) for _, letter, value, _ in words if letter == "G" and value.isdigit()}
        if codes & {20, 21}:
            stated: Unit = "inch" if 20 in codes else "mm"
            if own not in (None, stated):
                raise _refused(path, line[0], f"G20 and G21 both stand in the table: rows in {own} and in {stated}")
            own = stated
        if 91 in codes:
            raise _refused(path, line[0], "G91: the numbers are increments, not the values in force")
        if 10 in codes:
            rows.append(_row(path, line, words, own or unit))
    return ToolTable(path, FANUC, text, own, tuple(rows))


Word = tuple[int, str, str, int]
"""Place in the text, letter, value, and place of the value."""


def _words(line: Line) -> list[Word]:
    """The words outside of comments."""
    _, start, content = line
    bare = COMMENT.sub(lambda found: " " * len(found[0]), content.upper())
    return [(start + match.start(), match[1], match[2], start + match.start(2)) for match in WORD.finditer(bare)]


def _row(path: Path, line: Line, words: list[Word], unit: Unit | None) -> ToolRow:
    number, start, content = line
    found = {letter: (at, value) for _, letter, value, at in words if letter not in "GN"}
    if found.keys() & set("UVWC"):
        raise _refused(path, number, "U, V, W or C: the numbers are increments, not the values in force")

    def column(letter: str) -> int:
        return found[letter][0] - start + 1

    if "P" not in found:
        raise _refused(path, number, "G10 without P: no offset is named")
    kind: Kind = "wear"
    tool = whole(found["P"][1], path, number, column("P"))
    length = whole(found["L"][1], path, number, column("L")) if "L" in found else None
    if length is not None:
        kind = KINDS.get(length, "wear")
    elif tool > GEOMETRY_FROM:
        kind, tool = "geometry", tool - GEOMETRY_FROM

    def of(letter: str) -> Number | None:
        if letter not in found:
            return None
        at, text = found[letter]
        value = decimal(text, path, number, column(letter))
        if "." not in text:
            value = value.scaleb(-LEAST[_known(path, number, unit, text)])
        return Number(value, at, at + len(text))

    mill = length is not None and not found.keys() & {"X", "Z"}
    return ToolRow(
        tool=tool,
        kind=kind,
        line=number,
        line_end=start + len(content.rstrip(" ;")),
        x=None if mill else of("X"),
        z=None if mill else of("Z"),
        nose=None if mill else of("R"),
        tip=whole(found["Q"][1], path, number, column("Q")) if "Q" in found else None,
        others={f"L{length}": found["R"][1]} if mill and "R" in found else {},
    )


def _known(path: Path, line: int, unit: Unit | None, text: str) -> Unit:
    if unit is None:
        raise Code.OFS_UNIT.refusal(
            f"{text!r} has no decimal point: it counts 0.001 mm or 0.0001 inch, and the unit is not stated",
            hint="state it: `--unit mm` or `--unit inch`; in a job, `tool.table_unit`",
            place=Place(str(path), line),
        )
    return unit


def _refused(path: Path, line: int, message: str) -> TrueloopError:
    return Code.OFS_FILE.refusal(
        message, hint=f"punch the offsets out at the control; {HINT}", place=Place(str(path), line)
    )
