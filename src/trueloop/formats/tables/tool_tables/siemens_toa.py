"""Tool data of a Sinumerik: an archive `_TOA` or `.INI` of assignments to $TC_ variables.

`$TC_DP3..5[t,d]` lengths 1 to 3, DP6 the radius, DP12 to DP14 wear of the lengths, DP15 of the radius, DP1 the type
(500 to 599: turning), DP2 the position of the tip; `$TC_TP2[t]` the name. Of a turning tool in G18 length 1 lies along
X, as a radius, length 2 along Z. METRIC or INCH says the unit. A line that begins with `;` is information. Frames
($P_UIFR), magazine places and all else stay as they are.
"""

import re
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place
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
    words_of,
)

SIEMENS: Final = Convention("Sinumerik tool data", "radius", "radius", (4, 5))
VALUE: Final = re.compile(r"\s*\$TC_DP(\d+)\s*\[\s*(\d+)\s*,\s*(\d+)\s*\]\s*=\s*([^;\s]+)", re.IGNORECASE)
NAME: Final = re.compile(r'\s*\$TC_TP2\s*\[\s*(\d+)\s*\]\s*=\s*"([^"]*)"', re.IGNORECASE)
PLACES: Final[dict[Kind, tuple[int, int, int]]] = {"geometry": (3, 4, 6), "wear": (12, 13, 15)}
"""Parameter numbers of x, z and nose."""
SHOWN: Final[dict[Kind, tuple[int, ...]]] = {"geometry": (1, 3, 4, 5, 6), "wear": (12, 13, 14, 15)}
TURNING: Final = range(500, 600)

Found = dict[int, tuple[int, Number]]
"""Line and number of each variable, by the variable's number."""


def recognises(path: Path, source: bytes) -> bool:
    """Returns whether the file has an assignment to $TC_DP."""
    return re.search(rb"^\s*\$TC_DP\d+\s*\[", source, re.MULTILINE | re.IGNORECASE) is not None


def read(path: Path, text: str, unit: Unit | None) -> ToolTable:
    """Raises OFS-NUMBER, OFS-ROWS (an edge given twice) and OFS-FILE with the line."""
    own: Unit | None = None
    names: dict[int, str] = {}
    edges: dict[tuple[int, int], Found] = {}
    for line in lines_of(text):
        content = line[2].strip().upper()
        if content in ("METRIC", "INCH"):
            own = "inch" if content == "INCH" else "mm"
        elif name := NAME.match(line[2]):
            names[int(name[1])] = words_of(name[2])
        elif value := VALUE.match(line[2]):
            _add(path, edges, line, value)
    rows = [row for key, found in edges.items() for row in _rows(text, key, found, names)]
    return ToolTable(path, SIEMENS, text, own, tuple(rows))


def _add(path: Path, edges: dict[tuple[int, int], Found], line: Line, value: re.Match[str]) -> None:
    number, tool, edge = int(value[1]), int(value[2]), int(value[3])
    found = edges.setdefault((tool, edge), {})
    if number in found:
        lines = [found[number][0], line[0]]
        raise Code.OFS_ROWS.refusal(
            f"$TC_DP{number}[{tool},{edge}] is set in lines {lines[0]} and {lines[1]}: of two channels, or by hand",
            hint=f"take the tool data of one channel alone; {HINT}",
            place=Place(str(path), line[0]),
            values={"tool": float(tool), "lines": [str(one) for one in lines]},
        )
    start, end = (line[1] + at for at in value.span(4))
    found[number] = (line[0], Number(decimal(value[4], path, line[0], value.start(4) + 1), start, end))


def _rows(text: str, key: tuple[int, int], numbers: Found, names: dict[int, str]) -> list[ToolRow]:
    tool, edge = key
    kind_of_tool = numbers[1][1].value if 1 in numbers else None
    turning = kind_of_tool is not None and int(kind_of_tool) in TURNING
    rows = []
    for kind, places in PLACES.items():
        x, z, nose = (numbers[place][1] if place in numbers else None for place in places)
        first = min(line for line, _ in numbers.values())
        line = min((numbers[place][0] for place in places if place in numbers), default=first)
        others = {f"DP{n}": text[number.start : number.end] for n, (_, number) in numbers.items() if n in SHOWN[kind]}
        rows.append(
            ToolRow(
                tool=tool,
                kind=kind,
                line=line,
                line_end=0,
                x=x if turning else None,
                z=z if turning else None,
                nose=nose if turning else None,
                tip=int(numbers[2][1].value) if turning and 2 in numbers else None,
                edge=edge,
                name=names.get(tool, ""),
                others=others,
            )
        )
    return rows
