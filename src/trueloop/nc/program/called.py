"""Calls of a program: the tool offset in force, by which a control knows which edge cuts; tools as cutter compensation
(G41, G42) and length offsets (G43) need them; work offsets by the numbers that the tool path has for them.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, TypeAlias

from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import ToolPath

EDGES: Final = 1000
"""A Sinumerik's T3 D2 is 3002 of a path's `tool_offset`."""


@dataclass(frozen=True, order=True)
class CalledOffset:
    """A tool offset: its `number` (12 of T0312, H12), else that of the tool; `edge` is D of a Sinumerik, 1 elsewhere.

    Two corners of one insert are two of them: T0303 and T0313, or T3 D1 and T3 D2.
    """

    number: int
    edge: int = 1

    @property
    def words(self) -> str:
        """Returns `T3`, and `T3 D2` of a second edge."""
        return f"T{self.number}" if self.edge == 1 else f"T{self.number} D{self.edge}"


def called(dialect: Dialect, path: ToolPath, move: int) -> CalledOffset | None:
    """Returns the tool offset called when that move is made; None before any T word."""
    word, offset = int(path.tool[move]), int(path.tool_offset[move])
    if word <= 0:
        return None
    if dialect.offset_in_t and word >= 100:
        return CalledOffset(word % 100 or word // 100)
    if dialect.edge_by_d:
        return CalledOffset(word, edge_called(dialect, path, move) or 1)
    return CalledOffset(offset if offset > 0 else word)


def edge_called(dialect: Dialect, path: ToolPath, move: int) -> int | None:
    """Returns the edge called when that move is made, of a tool without a number too: 0 for none in force; None where
    the control counts no edges or the program calls none.
    """
    word, offset = int(path.tool[move]), int(path.tool_offset[move])
    if not dialect.edge_by_d or not offset or (dialect.offset_in_t and word >= 100):
        return None
    return offset % EDGES


def runs_without_offset(dialect: Dialect, path: ToolPath, move: int) -> bool:
    """Returns whether the tool's offset in the control's table is not in force: T0300, D0, T3 M6 without G43; G43.1
    states lengths itself.
    """
    word, offset = int(path.tool[move]), int(path.tool_offset[move])
    if dialect.offset_in_t and word >= 100:
        return word % 100 == 0
    if dialect.edge_by_d:
        return edge_called(dialect, path, move) == 0
    return dialect.wear_words == "linuxcnc" and word > 0 and offset <= 0


ToolRow: TypeAlias = tuple[int | None, float, int | None, float | None, tuple[float, float, float] | None, int | None]


@dataclass(frozen=True)
class CutterTool:
    """Radius of a nose or a cutter in mm, and how the control calls it.

    `tip` is the control's number of a lathe tool's orientation: where the controlled point lies from the nose's centre,
    0 and 9 being the centre itself. `number` is D, or that of the offset or the tool; None for whichever is called.
    `length_mm` is what G43 adds along Z, and a Sinumerik's D of a mill across the plane; `offset_mm` (x, y, z) what
    T0101 or D of a lathe adds, geometry and wear together, x a radius: machine = program + work offset + this. None
    where they are not known. `edge` is D of a Sinumerik, None for any.
    """

    radius_mm: float
    tip: int | None = None
    number: int | None = None
    length_mm: float | None = None
    offset_mm: tuple[float, float, float] | None = None
    edge: int | None = None


def tool_rows(tools: Iterable[CutterTool]) -> list[ToolRow]:
    """Tools as the Rust core takes them."""
    return [(tool.number, tool.radius_mm, tool.tip, tool.length_mm, tool.offset_mm, tool.edge) for tool in tools]


_NAME = re.compile(r"G\s*(?:(5[4-9])(?:\.([123]))?|(5\d\d))\s*", re.IGNORECASE)
_EXTENDED = re.compile(r"G\s*(?:54\.1|154)\s*P\s*(\d{1,3})\s*", re.IGNORECASE)
_FIRST, _LAST, _EXTENDED_FROM, _SETTABLE = 54, 59, 100, 4


def offset_number(name: str) -> int | None:
    """Returns 1 to 6 for G54 to G59, 7 to 9 for G59.1 to G59.3, 5 to 99 for G505 to G599, 101 … for G54.1 P1
    (G154 P1) …; None for anything that is not a name of a work offset.
    """
    if found := _EXTENDED.fullmatch(name):
        number = int(found[1])
        return _EXTENDED_FROM + number if number else None
    found = _NAME.fullmatch(name)
    if found is None or (found[2] and int(found[1]) != _LAST):
        return None
    if found[3]:
        return int(found[3]) - 500 or None
    return int(found[1]) - _FIRST + 1 + int(found[2] or 0)


def offset_name(number: int, dialect: str) -> str:
    """Returns the name of a work offset by its number, as that control calls it: of Heidenhain a preset."""
    if dialect == "heidenhain":
        return f"preset {number}"
    if number > _EXTENDED_FROM:
        return f"{'G154' if dialect.startswith('haas') else 'G54.1'} P{number - _EXTENDED_FROM}"
    if dialect == "siemens" and number > _SETTABLE:
        return f"G{500 + number}"
    last = _LAST - _FIRST + 1
    return f"G{_FIRST - 1 + number}" if number <= last else f"G{_LAST}.{number - last}"
