"""Rapid moves through material, on a lathe: judged by what the program itself cuts, for the blank is not known."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.nc.match.cutters import SidesOfCuts
from trueloop.nc.program.along import points_along
from trueloop.nc.program.tool_path import Motion, ToolPath

CLEARANCE_MM: Final = 0.01
"""A rapid move may come this much below what was cut: along a surface it has just cut it may run."""

_CELLS: Final = 4096
_SAMPLES: Final = 65
_X, _Y, _Z = 0, 1, 2


def cutting_rapids(path: ToolPath, *, goes_on: bool = False) -> Iterator[tuple[int, float]]:
    """Yields rapid moves that cut: index and greatest depth in mm on the radius, 0 for one in the place of a cut.

    Each run of moves with one tool in one frame is judged by itself. A single rapid move between two cuts, where no
    other move cuts, takes the place of a cut, unless it leads straight outwards or back along the cut before it. After
    a cut has reached the spindle axis all in front of it is free; behind it a rapid move must not go deeper, at any z,
    than the cuts before it, or, where none was made yet, than any cut ever made. Runs that bore (their cuts retract
    towards the axis) are not judged by depth, runs that mill (Y moves) not at all.
    goes_on: more moves follow, and the last run is not judged before it is known whole.
    """
    runs = _runs(path)
    for run in runs[:-1] if goes_on else runs:
        feed = run[path.motion[run] != Motion.RAPID]
        if 0 < len(feed) < len(run) and not np.ptp(path.end_mm[run, _Y]) > 0:
            yield from _of_run(path, run, feed)


def open_run(path: ToolPath) -> Integers:
    """Indices of the moves of the last run, by which it is judged once more moves follow: all of them, or, where it
    mills, as many of the last ones as show that.
    """
    run = (_runs(path) or [np.empty(0, dtype=np.intp)])[-1]
    elsewhere = np.flatnonzero(path.end_mm[run, _Y] != path.end_mm[run[-1:], _Y])
    return run[elsewhere[-1] :] if elsewhere.size else run


def sides_of_cuts(path: ToolPath) -> SidesOfCuts:
    """Returns on which side the tool is, as far as each run's rapid moves show it."""
    boring: set[int] = set()
    turning: set[int] = set()
    for run in _runs(path):
        feed = run[path.motion[run] != Motion.RAPID]
        if 0 < len(feed) < len(run):
            grid = _Grid(path, feed)
            outwards, nearer = _retracts(path, run, grid, grid.of(path, feed))
            if outwards < 0 and nearer > 0.5:
                boring.update(feed.tolist())
            elif outwards > 0 and nearer < 0.5:
                turning.update(feed.tolist())
    return SidesOfCuts(frozenset(boring), frozenset(turning))


def _runs(path: ToolPath) -> list[Integers]:
    """Indices of moves that follow each other without a jump, with one tool; moves that are not known left out."""
    known = np.flatnonzero(np.isfinite(path.start_mm).all(axis=1) & np.isfinite(path.end_mm).all(axis=1))
    if not len(known):
        return []
    breaks_here = np.diff(path.tool[known]) != 0
    for axis in (_X, _Y, _Z):  # one at a time: a third of the memory
        breaks_here |= np.abs(path.start_mm[known[1:], axis] - path.end_mm[known[:-1], axis]) > 1e-9
    breaks = np.flatnonzero(breaks_here) + 1
    return np.split(known, breaks)


def _of_run(path: ToolPath, run: Integers, feed: Integers) -> Iterator[tuple[int, float]]:
    grid = _Grid(path, feed)
    final = grid.of(path, feed)
    external = not _is_internal(path, run, grid, final)
    so_far, front = grid.empty(), np.inf
    for position, move in enumerate(run.tolist()):
        points = _points(path, move)
        if path.motion[move] != Motion.RAPID:
            grid.cut(so_far, points)
            on_axis = points[points[:, 0] <= CLEARANCE_MM, 1]
            front = min(front, on_axis.min(initial=np.inf))
            continue
        limit = np.where(np.isfinite(so_far), so_far, final)
        behind = points[points[:, 1] < front - CLEARANCE_MM]
        depth_mm = grid.depth(limit, behind) if external and np.isfinite(front) else 0.0
        if depth_mm > CLEARANCE_MM:
            yield move, depth_mm
        elif _bridges(path, run, position) and not np.isfinite(grid.between(final, points)).any():
            yield move, 0.0


def _bridges(path: ToolPath, run: Integers, position: int) -> bool:
    """Returns whether the rapid move stands alone between two cuts of other blocks and does not retract."""
    if not 0 < position < len(run) - 1:
        return False
    before, here, after = run[position - 1 : position + 2]
    cuts = path.motion[before] != Motion.RAPID and path.motion[after] != Motion.RAPID
    if not (cuts and path.block[before] < path.block[here] < path.block[after]):
        return False
    way, last = (path.end_mm[move] - path.start_mm[move] for move in (here, before))
    outwards = way[_X] > 0 and abs(way[_Z]) <= CLEARANCE_MM
    back = float(way @ last) < -0.999 * float(np.linalg.norm(way) * np.linalg.norm(last))
    return not (outwards or back)


def _is_internal(path: ToolPath, run: Integers, grid: "_Grid", final: Array) -> bool:
    """Returns whether cuts retract towards the axis, and rapid moves beside cuts are for the most part nearer to the
    axis.
    """
    outwards, nearer = _retracts(path, run, grid, final)
    return outwards < 0 and nearer > 0.5


def _retracts(path: ToolPath, run: Integers, grid: "_Grid", final: Array) -> tuple[float, float]:
    """By how many more of its cuts a run retracts outwards than inwards; which share of what its rapid moves pass
    beside cuts is nearer to the axis than these.
    """
    rapid = run[path.motion[run] == Motion.RAPID]
    after_cut = run[1:][(path.motion[run[1:]] == Motion.RAPID) & (path.motion[run[:-1]] != Motion.RAPID)]
    outwards = np.sign(np.round(path.end_mm[after_cut, _X] - path.start_mm[after_cut, _X], 6)).sum()
    points = np.concatenate([_points(path, int(move)) for move in rapid])
    limit = final[grid.cell(points[:, 1])]
    beside = np.isfinite(limit)
    nearer = points[beside, 0] < limit[beside] - CLEARANCE_MM
    return float(outwards), float(nearer.sum() / max(beside.sum(), 1))


def _points(path: ToolPath, move: int) -> Array:
    """Points (x, z) along a move, its ends included."""
    return points_along(path, np.intp(move), np.linspace(0.0, 1.0, _SAMPLES))[:, [_X, _Z]]


class _Grid:
    """Cells along z that hold the smallest radius cut, infinite where nothing was."""

    def __init__(self, path: ToolPath, feed: Integers) -> None:
        z = np.concatenate([path.start_mm[feed, _Z], path.end_mm[feed, _Z]])
        self._low, self._width = float(z.min()), max(float(np.ptp(z)), 1e-6) / (_CELLS - 3)

    def of(self, path: ToolPath, moves: Integers) -> Array:
        """Returns the radii that some moves cut together."""
        radius = self.empty()
        for move in moves:
            self.cut(radius, _points(path, int(move)))
        return radius

    def empty(self) -> Array:
        return np.full(_CELLS, np.inf)

    def cell(self, z: Array) -> Integers:
        """Returns the cell of each z; those outside the cuts go to the last one, which stays empty."""
        cell = np.floor((z - self._low) / self._width).astype(np.int64) + 1
        return np.where((cell >= 0) & (cell < _CELLS - 1), cell, _CELLS - 1)

    def cut(self, radii: Array, points: Array) -> None:
        """Lowers the cells a move passes, and their neighbours, to its smallest radius there: never too high."""
        lowest = np.minimum(points[:-1, 0], points[1:, 0])
        cell = self.cell(points[:, 1])
        first = np.maximum(np.minimum(cell[:-1], cell[1:]) - 1, 0)
        count = np.minimum(np.maximum(cell[:-1], cell[1:]) + 2, _CELLS - 1) - first
        before = np.cumsum(count) - count
        cells = np.arange(count.sum()) + np.repeat(first - before, count)
        np.minimum.at(radii, cells, np.repeat(lowest, count))

    def between(self, radii: Array, points: Array) -> Array:
        """Returns the radii of the cells strictly between the ends of a move."""
        first, last = sorted(self.cell(points[[0, -1], 1]).tolist())
        return radii[first + 2 : last - 1]

    def depth(self, limit: Array, points: Array) -> float:
        """Returns the depth of a rapid move below the limit."""
        below = limit[self.cell(points[:, 1])] - points[:, 0]
        return float(below[np.isfinite(below)].max(initial=0.0))
