"""Tool tables of Heidenhain controls: TOOL.T of mills, TOOLTURN.TRN of turning tools; columns by the heading's places.

`BEGIN TOOL.T MM` or INCH, a heading, a row a tool, `[END]`. L, R, R2, DL, DR are lengths and radii, deltas are added.
A turning tool has ZL and XL, the deltas DZL and DXL that are added to them, RS the nose's radius, TO the tip.
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
    whole,
    words_of,
)

HEIDENHAIN: Final = Convention("Heidenhain tool table", "radius", "radius", (4, 5))
BEGIN: Final = re.compile(rb"\A\s*BEGIN\s+\S+\s+(MM|INCH)\b", re.IGNORECASE)
TURNED: Final[dict[Kind, tuple[str, str]]] = {"geometry": ("XL", "ZL"), "wear": ("DXL", "DZL")}
"""The columns of x and z."""
SHOWN: Final[dict[Kind, tuple[str, ...]]] = {"geometry": ("L", "R", "R2"), "wear": ("DL", "DR", "DR2")}

Columns = dict[str, tuple[int, int]]
"""Beginning and end of each column, by name."""


def recognises(path: Path, source: bytes) -> bool:
    """Returns whether the file begins with a BEGIN line and has headings `T NAME`."""
    return BEGIN.match(source) is not None and re.search(rb"^T\s+NAME\s", source, re.MULTILINE) is not None


def read(path: Path, text: str, unit: Unit | None) -> ToolTable:
    """Raises OFS-NUMBER and OFS-FILE with the line."""
    begins = BEGIN.match(text.encode("latin-1"))
    own: Unit = "inch" if begins is not None and begins[1].upper() == b"INCH" else "mm"
    columns: Columns = {}
    rows: list[ToolRow] = []
    for line in list(lines_of(text))[1:]:
        if line[2].strip().upper() == "[END]":
            return ToolTable(path, HEIDENHAIN, text, own, tuple(rows))
        if not columns:
            columns = _columns(line[2]) if re.match(r"T\s+NAME\s", line[2]) else {}
        elif line[2].strip():
            rows += _rows(path, line, columns)
    hint = f"copy it from the control anew; {HINT}"
    raise Code.OFS_FILE.refusal(
        f"{len(rows)} rows and no [END]: the table is cut off", hint=hint, place=Place(str(path))
    )


def _columns(heading: str) -> Columns:
    names = [(match[0], match.start()) for match in re.finditer(r"\S+", heading)]
    ends = [start for _, start in names[1:]] + [10**6]
    return {name: (start, end) for (name, start), end in zip(names, ends, strict=True)}


def _rows(path: Path, line: Line, columns: Columns) -> list[ToolRow]:
    number, start, content = line

    def cell(name: str) -> str:
        low, high = columns.get(name, (0, 0))
        return content[low:high].strip()

    def of(name: str) -> Number | None:
        if not cell(name):
            return None
        low, high = columns[name]
        value = decimal(cell(name), path, number, low + 1)
        return Number(value, start + low, start + min(high, len(content)), width=min(high, len(content)) - low)

    tool_text = cell("T")
    tool = whole(tool_text.split(".")[0], path, number, 1)
    return [
        ToolRow(
            tool=tool,
            kind=kind,
            line=number,
            line_end=start + len(content),
            x=of(places[0]),
            z=of(places[1]),
            nose=of("RS") if kind == "geometry" else None,
            tip=whole(cell("TO"), path, number, columns["TO"][0] + 1) if cell("TO") else None,
            edge=1 + int(tool_text.split(".")[1]) if "." in tool_text else 1,
            name=words_of(cell("NAME")),
            others={name: cell(name) for name in SHOWN[kind] if cell(name)},
        )
        for kind, places in TURNED.items()
    ]
