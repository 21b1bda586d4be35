"""Points of a surface as they were measured."""

from dataclasses import dataclass

from trueloop.arrays import Array, Integers
from trueloop.errors import Place


@dataclass(frozen=True, eq=False)
class MeasuredPoints:
    """Points as a measuring machine gave them, in the part's frame: `points_mm` (n, 3), ball centres where
    `ball_radius_mm` is above zero, else points of the surface. `shape` (rows, columns) when they form a grid, row by
    row; a hole in it is a row of nan. `name` tells the part; `file` and `lines` (n,), 0 for a hole, where it was read.
    """

    points_mm: Array
    ball_radius_mm: float = 0.0
    shape: tuple[int, int] | None = None
    name: str = ""
    file: str | None = None
    lines: Integers | None = None

    def place(self, number: int) -> Place:
        """Where a point, counted from 1, was read."""
        return Place(self.file, None if self.lines is None else int(self.lines[number - 1]))
