"""Offsets of a Haas control saved as a file .ofs: elements like those of XML, one a number, closed by a checksum.

It is read, never written: the checksum is the control's own. The element's name says whether a number is a diameter.
"""

import re
from bisect import bisect_right
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place
from trueloop.formats.tables.tool_tables.tool_table import (
    HINT,
    Convention,
    Kind,
    Number,
    ToolRow,
    ToolTable,
    Unit,
    decimal,
    lines_of,
)

WHY: Final = "the control closes the file with a checksum of its own: send the change as G10 instead"
HAAS: Final = Convention(
    name="Haas .ofs", x_is="diameter", nose_is="radius", decimals=(3, 4), comment=None, read_only=WHY
)
TOOL: Final = re.compile(r"<TOOL(\d+)>([^<]*(?:<(?!/?TOOL\d)[^<]*)*)</TOOL\1>")
"""A tool with its elements; none goes beyond the next tool, so that a file that is cut off is read as fast."""
ELEMENT: Final = re.compile(r"<(\w+)>\s*([-+]?[\d.]+)\s*</\1>")
NAMES: Final[dict[tuple[Kind, str], tuple[str, ...]]] = {
    ("geometry", "X"): ("X_OFFSET", "X_GEOMETRY"),
    ("geometry", "Z"): ("Z_OFFSET", "Z_GEOMETRY"),
    ("wear", "X"): ("X_WEAR",),
    ("wear", "Z"): ("Z_WEAR",),
}


def recognises(path: Path, source: bytes) -> bool:
    """Returns whether the file has an element TOOL with its number."""
    return re.search(rb"<TOOL\d+>", source) is not None


def read(path: Path, text: str, unit: Unit | None) -> ToolTable:
    """Raises OFS-NUMBER and OFS-FILE with the line."""
    starts = [start for _, start, _ in lines_of(text)]

    def number(at: int, value: str) -> Number:
        return Number(decimal(value, path, bisect_right(starts, at), 1), at, at + len(value))

    rows: list[ToolRow] = []
    for tool in TOOL.finditer(text):
        elements = ((match[1].upper(), tool.start(2) + match.start(2), match[2]) for match in ELEMENT.finditer(tool[2]))
        found = {name: number(at, value) for name, at, value in elements}
        line = bisect_right(starts, tool.start())
        rows += [_row(int(tool[1]), line, text, found, kind) for kind in ("geometry", "wear")]
    if not rows:
        hint = f"save the offsets anew at the control; {HINT}"
        raise Code.OFS_FILE.refusal("0 tools: no element TOOL is closed", hint=hint, place=Place(str(path)))
    return ToolTable(path, HAAS, text, None, tuple(rows))


def _row(tool: int, line: int, text: str, found: dict[str, Number], kind: Kind) -> ToolRow:
    x, z = (next((found[name] for name in NAMES[kind, axis] if name in found), None) for axis in "XZ")
    own = {
        name: text[number.start : number.end]
        for name, number in found.items()
        if name.endswith("WEAR") == (kind == "wear")
    }
    return ToolRow(tool=tool, kind=kind, line=line, line_end=0, x=x, z=z, others=own)
