"""What turning removes, slowly: the stock as columns, each as deep as the tool has been there.

Points are (along, deep), mm: along the straight cuts, and below the height of the cycle's start. A tool that is at a
depth has removed what stood above it.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import pytest

from tests.support.roughing_reference import Piece
from trueloop.arrays import Array, Integers
from trueloop.nc.program.along import points_along
from trueloop.nc.program.tool_path import Motion, ToolPath

PITCH_MM: Final = 0.05
"""From column to column."""
TINY_MM: Final = 1e-6
STEP_MM: Final = 0.01
"""Between the points of a move that are looked at."""
NEAR_MM: Final = 0.12
"""What two columns may hide."""
WIDE_MM: Final = 0.4
"""Cuts narrower than this may fall between columns."""

Move = tuple[str, Array]
"""Kind, and points (n, 2) along it."""
Run = tuple[int, float, float]
"""Number of a level, and where the contour below it begins and ends."""


class Columns:
    """Columns from 0 to the contour's end. The pieces are in (deep, along), and begin at the cycle's start."""

    def __init__(self, contour: Sequence[Piece]) -> None:
        deep, along = np.array([piece.at(share) for piece in contour for share in np.linspace(0, 1, 2001)]).T
        self.along = np.arange(0.0, along[-1] + PITCH_MM, PITCH_MM)
        self.ground = np.interp(self.along, along, deep)
        self.lowest, self.highest = near(self.ground), self.ground.copy()
        np.maximum.at(self.lowest, self._at(along), deep)  # what is steeper than the columns are wide
        np.minimum.at(self.highest, self._at(along), deep)
        self.cut = np.zeros_like(self.along)

    def _at(self, along: Array) -> Integers:
        column: Integers = np.clip(np.rint(along / PITCH_MM).astype(np.int32), 0, len(self.along) - 1)
        return column

    def room_mm(self, points: Array) -> float:
        """How far points (n, 2) stand above what is left of the stock; negative in it."""
        return float((near(self.cut)[self._at(points[:, 0])] - points[:, 1]).min())

    def allowed_mm(self, points: Array) -> float:
        """How far they stand above the contour; negative below it."""
        return float((near(self.lowest)[self._at(points[:, 0])] - points[:, 1]).min())

    def remove(self, points: Array) -> None:
        """What stands above them is gone."""
        np.maximum.at(self.cut, self._at(points[:, 0]), points[:, 1])

    def left_mm(self) -> float:
        """The most that stands above the contour."""
        return float((self.ground - near(self.cut)).max())

    def runs(self, depth: float) -> list[Run]:
        """Every straight cut, in order: that of a level, then all below it, then the next beside it."""
        return list(self._below(depth, 1, 0, len(self.along)))

    def _below(self, depth: float, level: int, first: int, last: int) -> Iterator[Run]:
        deep = np.concatenate([[False], self.highest[first:last] > level * depth + TINY_MM, [False]])
        starts, ends = np.flatnonzero(~deep[:-1] & deep[1:]) + first, np.flatnonzero(deep[:-1] & ~deep[1:]) + first
        for start, end in zip(starts, ends, strict=True):
            yield level, float(self.along[start]), float(self.along[end - 1])
            yield from self._below(depth, level + 1, int(start), int(end))


def near(values: Array) -> Array:
    """The deepest of each column and its neighbours: a wall may stand between two."""
    padded = np.pad(values, 1, mode="edge")
    return np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])


def sampled(path: ToolPath, moves: Sequence[int]) -> list[tuple[str, Array]]:
    """Kind of the moves and positions (n, 3) along each, to the nanometre."""
    found = []
    for k in moves:
        count = max(2, int(np.linalg.norm(path.end_mm[k] - path.start_mm[k]) * 1.6 / STEP_MM))
        found.append(
            (Motion(path.motion[k]).name.lower(), points_along(path, np.intp(k), np.linspace(0, 1, count)).round(9))
        )
    return found


def assert_cleared(
    moves: Sequence[Move], shape: Sequence[Piece], depth: float, *, stock_first: bool, ordered: bool = True
) -> None:
    """Holds the moves of a roughing cycle to a stock of columns.

    No cut goes below the contour, none takes more than one depth of cut, no rapid move runs into what is left, what the
    levels leave is less than one depth of cut, and the last pass leaves nothing. With `ordered`, every level is cut,
    each pocket down to its ground before the next. Where the first piece is gone along at rapid, there is no stock,
    unless `stock_first`. The first move has come to the start, and the last one that leads back to it, or the first
    of all, comes before the last pass.
    """
    columns = Columns(shape)
    if not stock_first:
        columns.remove(np.array([shape[0].at(share)[::-1] for share in np.linspace(0, 1, 501)]))
    back = [k for k, (kind, points) in enumerate(moves) if kind == "rapid" and abs(points[-1]).max() < TINY_MM]
    count = max(back, default=-1) + 1
    for move in moves[:count]:
        _look(columns, *move, depth)
    assert columns.left_mm() <= depth + NEAR_MM
    if ordered:
        _same_runs([found for move in moves[:count] if (found := _level(move, depth))], columns.runs(depth))
    for kind, points in moves[count:]:
        _look(columns, kind, points, depth, along_contour=True)
    assert columns.left_mm() <= NEAR_MM


def _look(columns: Columns, kind: str, points: Array, depth: float, *, along_contour: bool = False) -> None:
    assert columns.allowed_mm(points) >= -NEAR_MM
    room = columns.room_mm(points)
    if kind == "rapid":
        assert room >= -NEAR_MM or along_contour
    else:
        assert room >= -depth - NEAR_MM
        columns.remove(points)


def _level(move: Move, depth: float) -> Run | None:
    """A straight cut at a level."""
    kind, points = move
    (first, deep), (last, also) = points[0], points[-1]
    number = round(deep / depth)
    if kind != "line" or abs(deep - also) > TINY_MM or abs(deep - number * depth) > TINY_MM:
        return None
    return number, float(first), float(last)


def _same_runs(found: list[Run], expected: list[Run]) -> None:
    """The same cuts in the same order, where they are wide enough to be seen in columns."""
    for some, others in ((found, expected), (expected, found)):
        rest = iter(others)
        for run in some:
            if run[2] - run[1] > WIDE_MM:
                assert any(run[0] == other[0] and run[1:] == pytest.approx(other[1:], abs=NEAR_MM) for other in rest)
