"""The tool offset in force, as a program calls it: by it a control knows which edge cuts."""

from dataclasses import dataclass
from typing import Final

from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import ToolPath

EDGES: Final = 1000
"""A Sinumerik's T3 D2 is 3002 of a path's `tool_offset`."""


@dataclass(frozen=True, order=True)
class Called:
    """A tool offset: its `number` (12 of T0312, H12), else that of the tool; `edge` is D of a Sinumerik, 1 elsewhere.

    Two corners of one insert are two of them: T0303 and T0313, or T3 D1 and T3 D2.
    """

    number: int
    edge: int = 1

    @property
    def words(self) -> str:
        """Returns `T3`, and `T3 D2` of a second edge."""
        return f"T{self.number}" if self.edge == 1 else f"T{self.number} D{self.edge}"


def called(dialect: Dialect, path: ToolPath, move: int) -> Called | None:
    """Returns the tool offset called when that move is made; None before any T word."""
    word, offset = int(path.tool[move]), int(path.tool_offset[move])
    if word <= 0:
        return None
    if dialect.offset_in_t and word >= 100:
        return Called(word % 100 or word // 100)
    if dialect.edge_by_d:
        return Called(word, offset % EDGES if offset > 0 else 1)
    return Called(offset if offset > 0 else word)
