"""Rows of an offset table that tools share, for controls where each tool has edges of its own."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from trueloop.errors import Severity
from trueloop.nc.translate.statements import LengthOffset, Lost, Statement, ToolChange

MOST_IN_T: Final = 99
MOST_EDGES: Final = 9


def rows_of_tools(said: Iterable[Statement | Lost]) -> Mapping[int, tuple[int, ...]]:
    """The rows that each tool is used with: its own first, then as they come. Tool 0 is that before any."""
    tool, rows = 0, dict[int, dict[int, None]]()
    for statement in said:
        row: int | None = None
        if isinstance(statement, ToolChange):
            tool, row = statement.number, statement.offset
        elif isinstance(statement, LengthOffset) and statement.on:
            row = tool if statement.number is None else statement.number
        if row:
            rows.setdefault(tool, {})[row] = None
    return {tool: tuple(sorted(found, key=lambda row: row != tool)) for tool, found in rows.items()}


def edge(rows: tuple[int, ...], tool: int, row: int) -> Iterator[str | Lost]:
    """D of a Sinumerik for a row, 0 for none. Two rows of one tool never become one edge."""
    number = rows.index(row) + 1 if row else 0
    if number > MOST_EDGES:
        yield Lost(Severity.ERROR, f"tool {tool} with more than {MOST_EDGES} rows of the offset table", refuses=True)
    yield f"D{number}"
    if row not in (0, tool):
        what = f"row {row} of the offset table becomes edge D{number} of tool {tool}, where it has to be entered"
        yield Lost(Severity.WARNING, what)


def two_digits(tool: int, row: int) -> Iterator[str | Lost]:
    """T of a lathe, of two digits each for the tool and the row."""
    if max(tool, row) > MOST_IN_T:
        what = f"tool {tool} with row {row} of the offset table, in a T of two digits each"
        yield Lost(Severity.ERROR, what, refuses=True)
    yield f"T{tool:02d}{row:02d}"
