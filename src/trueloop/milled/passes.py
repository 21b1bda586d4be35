"""Passes of a program over walls and levels: circles, straight walls, plunges and level moves, each with its calls.

Places are of the work offset in force, with shifts of the program (G52, TRANS, a datum shift) added, mm. Moves with a
rotary axis away from zero, and moves that begin or end at a place which the program does not state, have no part.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Unseen
from trueloop.geometry.feature import Point
from trueloop.nc.program.along import said_ends
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import NO_COMPENSATION, Motion, ToolPath

SAME_MM: Final = 1e-3
"""Places nearer than this are the same."""
MATCH_MM: Final = 0.05
"""A path that lies further from where a wall is cut cuts another wall, or leaves material on."""
PROBING: Final = re.compile(r"CYCLE97[1-9]|CYCLE99[78]")
"""Sinumerik's cycles that measure; those of Klartext and Renishaw's macros are known as touches by the path."""
LEFT: Final = 41
XY: Final = 17


@dataclass(frozen=True)
class Called:
    """A pass's numbers: tool, registers of radius and length (0: none), work offset; `subtracted`: by G44."""

    tool: int
    radius: int
    length: int
    work_offset: int
    subtracted: bool = False


@dataclass(frozen=True)
class Touch:
    """One pass along a wall: `gap_mm` from the wall to its path, positive on the side of the air.

    `compensated`: the path is the contour, from which the control keeps the tool by what D holds. `climb`: with a
    spindle that turns clockwise; None of a plunge. `from_air`: the tool is on the side of the air, so that it cuts this
    wall and none behind it.
    """

    move: int
    line: int
    called: Called
    gap_mm: float
    compensated: bool
    climb: bool | None
    from_air: bool


@dataclass(frozen=True)
class Circle:
    """A full turn about `centre_mm` (x, y), or more; `low_mm` is its lowest z."""

    move: int
    centre_mm: Point
    radius_mm: float
    counterclockwise: bool
    low_mm: float


class Passes:
    """What a program cuts with, its moves sorted by what they can be."""

    def __init__(self, program: Program, path: ToolPath) -> None:
        """Sorts the moves of a path that was run without tools: under G41 and G42 it is the contour."""
        self.path = path
        shift = path.register_mm
        self.start_mm, self.end_mm = path.start_mm + shift, path.end_mm + shift
        before, after = said_ends(program, path)
        usable = before.all(axis=1) & after.all(axis=1) & (path.turned == 0)
        way = np.abs(self.end_mm - self.start_mm)
        level = np.hypot(way[:, 0], way[:, 1])
        line = usable & (path.motion == Motion.LINE)
        self.lines: Integers = np.flatnonzero(line & (level > SAME_MM))
        self.plunges: Integers = np.flatnonzero(
            line & (level <= SAME_MM) & (self.end_mm[:, 2] < self.start_mm[:, 2] - SAME_MM)
        )
        arcs = usable & (path.motion == Motion.ARC) & (path.plane == XY)
        self.arcs: Integers = np.flatnonzero(arcs)
        self.level: Integers = np.flatnonzero((line & (level > SAME_MM) | arcs) & (way[:, 2] <= SAME_MM))
        self.contour: Integers = np.flatnonzero((line | arcs) & (path.compensation != NO_COMPENSATION))
        self.circles = tuple(self._circles())
        self.unseen = tuple(_unseen_lines(program, path))

    def called(self, move: int) -> Called:
        """Returns the calls in force at a move."""
        path = self.path
        length, tool = int(path.tool_offset[move]), int(path.tool[move])
        subtracted = bool(path.tool_offset_subtracted[move])
        return Called(tool, self._radius(move), length, int(path.work_offset[move]), subtracted)

    def sets_work_offset(self, move: int) -> bool:
        """Returns whether the program itself has set the work offset in force at a move: G10 L2."""
        path = self.path
        set_mm = path.origin_mm[move] - path.register_mm[move]  # the path was run with work offsets of zero
        axes = [0, 1] if path.tool_offset[move] < 0 else [0, 1, 2]  # G43.1 states a length itself
        return bool(np.any(np.abs(set_mm[axes]) > 0.0))

    def _radius(self, move: int) -> int:
        path = self.path
        return 0 if path.compensation[move] == NO_COMPENSATION else int(path.radius_offset[move])

    def compensated(self, move: int) -> bool:
        """Returns whether the radius in a register of the control keeps the tool from the path there."""
        return self._radius(move) != 0

    def _circles(self) -> Iterator[Circle]:
        """Yields full circles and helices, of consecutive arcs about one centre that follow each other."""
        run = list[int]()
        for move in [*self.arcs.tolist(), None]:
            if move is not None and run and self._goes_on(run[-1], move):
                run.append(move)
                continue
            if run and abs(float(np.sum(self.path.sweep_rad[run]))) >= 2.0 * math.pi - SAME_MM:
                x, y, radius = self._circle(run[0])
                low = float(min(self.start_mm[run, 2].min(), self.end_mm[run, 2].min()))
                yield Circle(run[0], (x, y), radius, bool(self.path.sweep_rad[run[0]] < 0.0), low)
            run = [] if move is None else [move]

    def _circle(self, move: int) -> tuple[float, float, float]:
        x, y = (self.path.centre_mm[move] + self.path.register_mm[move])[:2].tolist()
        return x, y, math.hypot(self.start_mm[move, 0] - x, self.start_mm[move, 1] - y)

    def _goes_on(self, before: int, move: int) -> bool:
        near = np.allclose(self._circle(before), self._circle(move), rtol=0.0, atol=SAME_MM)
        turn = self.path.sweep_rad[before] * self.path.sweep_rad[move] > 0.0
        return move == before + 1 and near and bool(turn) and self.called(before) == self.called(move)

    def around(self, centre_mm: Point, radius_mm: float, bore: bool, half_way_mm: float) -> list[Touch]:
        """Returns the passes around a bore or boss, and the plunges on its axis, that reach down to `half_way_mm`."""
        found = list[Touch]()
        for circle in self.circles:
            if math.dist(circle.centre_mm, centre_mm) > MATCH_MM or circle.low_mm > half_way_mm + MATCH_MM:
                continue
            gap = (radius_mm - circle.radius_mm) * (1.0 if bore else -1.0)
            inside = (self.path.compensation[circle.move] == LEFT) == circle.counterclockwise
            from_air = inside == bore if self.compensated(circle.move) else gap > -MATCH_MM
            found.append(self._touch(circle.move, gap, circle.counterclockwise == bore, from_air))
        if bore:
            at = self.end_mm[self.plunges]
            near = np.hypot(at[:, 0] - centre_mm[0], at[:, 1] - centre_mm[1]) <= MATCH_MM
            deep = at[:, 2] <= half_way_mm + MATCH_MM
            found += [self._touch(int(move), radius_mm, None, True) for move in self.plunges[near & deep]]
        return found

    def along(self, wall_mm: Point, air: Point, half_way_mm: float) -> list[Touch]:
        """Returns the passes along a straight wall through a point; `air`: its normal (x, y) out of the material."""
        start, end = self.start_mm[self.lines], self.end_mm[self.lines]
        way = (end - start)[:, :2]
        length = np.hypot(way[:, 0], way[:, 1])
        normal, wall = np.array(air), np.array(wall_mm)
        parallel = np.abs(way @ normal) <= SAME_MM
        first, last = (((one[:, :2] - wall) * way).sum(axis=1) / length for one in (start, end))
        beside = (first < 0.0) & (last > 0.0)
        deep = np.maximum(start[:, 2], end[:, 2]) <= half_way_mm + MATCH_MM
        found = list[Touch]()
        for k in np.flatnonzero(parallel & beside & deep).tolist():
            move, (x, y) = int(self.lines[k]), way[k].tolist()
            gap = float((start[k, :2] - wall) @ normal)
            air_is_left = x * normal[1] - y * normal[0] > 0.0
            tool_is_left = self.path.compensation[move] == LEFT
            from_air = tool_is_left == air_is_left if self.compensated(move) else gap > -MATCH_MM
            found.append(self._touch(move, gap, bool(air_is_left), bool(from_air)))
        return found

    def at_level(self, z_mm: float) -> Integers:
        """Returns the level moves near a height."""
        near: Integers = self.level[np.abs(self.end_mm[self.level, 2] - z_mm) <= MATCH_MM]
        return near

    def distance_mm(self, move: int, point_mm: Point) -> float:
        """Returns how far a point (x, y) lies from a move, its arc taken as the whole circle."""
        point = np.array(point_mm)
        if self.path.motion[move] == Motion.ARC:
            x, y, radius = self._circle(move)
            return abs(math.dist((x, y), point_mm) - radius)
        start, end = self.start_mm[move, :2], self.end_mm[move, :2]
        way = end - start
        share = min(max(float((point - start) @ way) / float(way @ way), 0.0), 1.0)
        return float(np.linalg.norm(start + share * way - point))

    def _touch(self, move: int, gap_mm: float, climb: bool | None, from_air: bool) -> Touch:
        line = int(self.path.line[move])
        return Touch(
            move=move,
            line=line,
            called=self.called(move),
            gap_mm=gap_mm,
            compensated=self.compensated(move),
            climb=climb,
            from_air=from_air,
        )

    def hidden_after(self, move: int, point_mm: Array) -> int | None:
        """Returns the line of a run after a move, −1 for any, that the path does not show and that could cut at a point
        (3,): a milling cycle around it, or a macro or cycle that could cut anywhere; None without.
        """
        path, last = self.path, len(self.path) - 1
        for first, (low, high) in zip(path.milled_before.tolist(), path.milled_mm.reshape(-1, 2, 3), strict=True):
            shift = path.register_mm[min(first, last)]
            within = (low + shift - MATCH_MM <= point_mm) & (point_mm <= high + shift + MATCH_MM)
            if first > move and np.all(within):
                return int(path.line[min(first, last)])
        since = 0 if move < 0 or len(path.calls) else int(path.line[move])
        return next((line for line in self.unseen if line > since), None)

    def users(self, register: str) -> dict[int, set[int]]:
        """Returns the tools that cut with each register of radii (`radius`) or lengths (`length`), by its number."""
        found = dict[int, set[int]]()
        moves = np.flatnonzero((self.path.motion == Motion.LINE) | (self.path.motion == Motion.ARC))
        first = np.unique(np.asarray(self.path.state[moves]), return_index=True)[1]
        for move in moves[first].tolist():
            called = self.called(move)
            number = called.radius if register == "radius" else called.length
            if number > 0:
                found.setdefault(number, set()).add(called.tool)
        return found

    def tightest_corner_mm(self, tool: int) -> float | None:
        """Returns the smallest radius of an arc, not a full turn, along which the tool is inside; None without."""
        path, moves = self.path, self.arcs
        inside = (path.compensation[moves] == LEFT) == (path.sweep_rad[moves] < 0.0)
        turn = np.abs(path.sweep_rad[moves]) < math.pi - SAME_MM
        own = [m for m in moves[inside & turn].tolist() if self.compensated(m) and path.tool[m] == tool]
        return min((self._circle(move)[2] for move in own), default=None)


def _unseen_lines(program: Program, path: ToolPath) -> Iterator[int]:
    """Yields the lines of macros and cycles that are not in the path and could cut; probing macros do not."""
    for found in path.findings:
        line = found.place.line
        if line is not None and found.unseen in (Unseen.BLOCK, Unseen.MOVES):
            block = program.block(line - 1)
            if not PROBING.search(program.source[block.start : block.end].decode("latin-1")):
                yield line
