"""Offsets of a Haas control saved as a file .ofs: elements like those of XML, one a number, closed by a checksum.

It is read, never written: the checksum is the control's own. The element's name says whether a number is a diameter.
"""

import re
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.tables.tool_tables.text import decimal
from trueloop.formats.tables.tool_tables.tool_table import HINT, Convention, Kind, Number, ToolRow, ToolTable, Unit

WHY: Final = "the control closes the file with a checksum of its own: send the change as G10 instead"
HAAS: Final = Convention("Haas .ofs", "diameter", "radius", (3, 4), None, WHY)
TOOL: Final = re.compile(r"<TOOL(\d+)>(.*?)</TOOL\1>", re.DOTALL)
ELEMENT: Final = re.compile(r"<(\w+)>\s*([-+]?[\d.]+)\s*</\1>")
AXES: Final = {"X": ("X_OFFSET", "X_GEOMETRY", "X_WEAR"), "Z": ("Z_OFFSET", "Z_GEOMETRY", "Z_WEAR")}


def recognises(path: Path, source: bytes) -> bool:
    """By an element TOOL with its number."""
    return re.search(rb"<TOOL\d+>", source) is not None


def read(path: Path, text: str, unit: Unit | None) -> ToolTable:
    """Raises OFS-NUMBER and OFS-FILE with the line."""
    rows: list[ToolRow] = []
    for tool in TOOL.finditer(text):
        found = {one[1].upper(): (tool.start(2) + one.start(2), one[2]) for one in ELEMENT.finditer(tool[2])}
        rows += [_row(path, text, int(tool[1]), tool.start(), found, kind) for kind in ("geometry", "wear")]
    if not rows:
        hint = f"save the offsets anew at the control; {HINT}"
        raise TrueloopError(Code.OFS_FILE, "0 tools: no element TOOL is closed", hint=hint, place=Place(str(path)))
    return ToolTable(path, HAAS, text, None, tuple(rows))


def _row(path: Path, text: str, tool: int, at: int, found: dict[str, tuple[int, str]], kind: Kind) -> ToolRow:
    def number(axis: str) -> Number | None:
        for name in AXES[axis][2:] if kind == "wear" else AXES[axis][:2]:
            if name in found:
                place, value = found[name]
                line = text.count("\n", 0, place) + 1
                return Number(decimal(value, path, line, 1), place, place + len(value))
        return None

    own = {name: value for name, (_, value) in found.items() if name.endswith("WEAR") == (kind == "wear")}
    line = text.count("\n", 0, at) + 1
    return ToolRow(tool, kind, line, at, number("X"), number("Z"), others=own)
