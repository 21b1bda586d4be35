"""LinuxCNC's tool.tbl: a row a tool, words in any order, a comment after `;`.

D is a diameter, of a nose too; X is a radius and counts in the machine's unit, which the file does not say. Row T10001
holds the wear of tool 1 where the machine is set up for it (sample configuration lathe-fanucy). Rows are in any order.
"""

import re
from decimal import Decimal
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place
from trueloop.formats.tables.tool_tables.tool_table import (
    HINT,
    MARKED,
    Convention,
    Number,
    ToolRow,
    ToolTable,
    Unit,
    decimal,
    lines_of,
    whole,
    words_of,
)

LINUXCNC: Final = Convention("LinuxCNC tool.tbl", "radius", "diameter", (5, 6), (";", ""))
WEAR_FROM: Final = 10_000
WORD: Final = re.compile(r"([A-Za-z])([^\s;]*)")
ROW: Final = re.compile(rb"^\s*[Tt]\d+\s+[A-Za-z]", re.MULTILINE)


def recognises(path: Path, source: bytes) -> bool:
    """Returns whether the file ends in `.tbl` and has a row that begins with T."""
    return path.suffix.lower() == ".tbl" and ROW.search(source) is not None


def read(path: Path, text: str, unit: Unit | None) -> ToolTable:
    """Raises OFS-NUMBER and OFS-FILE with the line."""
    rows, remarks = [], []
    for line, start, content in lines_of(text):
        data, _, comment = content.partition(";")
        if not data.strip():
            continue
        if not data.lstrip().upper().startswith("T"):
            remarks.append(f"line {line} is no tool, {words_of(data)[:40]!r}: left as it is")
            continue
        rows.append(_row(path, line, start, content, data, words_of(MARKED.sub("", f" {comment}"))))
    return ToolTable(path=path, convention=LINUXCNC, text=text, unit=unit, rows=tuple(rows), remarks=tuple(remarks))


def _row(path: Path, line: int, start: int, content: str, data: str, comment: str) -> ToolRow:
    found: dict[str, tuple[int, str]] = {}
    for word in WORD.finditer(data):
        letter = word[1].upper()
        if letter in found:
            raise Code.OFS_FILE.refusal(f"{letter} stands twice in the row", hint=HINT, place=Place(str(path), line))
        found[letter] = (word.start(2), word[2])

    def number(letter: str) -> Number:
        if letter not in found:
            end = start + len(data.rstrip())
            return Number(Decimal(0), end, end, f" {letter}")
        at, text = found[letter]
        return Number(decimal(text, path, line, at + 1), start + at, start + at + len(text))

    tool = whole(found["T"][1], path, line, 2)
    wear = WEAR_FROM < tool < 2 * WEAR_FROM
    return ToolRow(
        tool=tool - WEAR_FROM if wear else tool,
        kind="wear" if wear else "geometry",
        line=line,
        line_end=start + len(content.rstrip()),
        x=number("X"),
        z=number("Z"),
        nose=number("D") if "D" in found else None,
        tip=whole(found["Q"][1], path, line, found["Q"][0]) if "Q" in found else None,
        name=comment,
        others={letter: text for letter, (_, text) in found.items() if letter not in "TXZDQ"},
    )
