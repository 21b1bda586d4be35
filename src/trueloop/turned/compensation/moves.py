"""A smooth centre path as moves that a control knows: chords, or pairs of arcs that keep the tangent.

Every sample of the path lies within its own tolerance of the moves; the fewest moves are found by letting each reach
as far as it can.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.geometry.feature import Point

STRAIGHT_SAGITTA_MM = 1e-6
"""An arc that bulges less than a nanometre is written as a line: its radius would be a number without meaning."""

SLIVER_MM = 0.01
"""An arc is not cut into pieces shorter than this: rounded to the control's step they would have no direction."""


SHORT_MM = 0.1
"""The last move is not left shorter: where a path ends tangentially on its neighbour, a program's rounding to 0.1 µm
moves their common end by some 20 µm along both, and a shorter arc would be turned round."""


@dataclass(frozen=True)
class Move:
    """One feed move in the (x, z) plane, x a radius. An arc has a centre and a sweep, positive clockwise (G02)."""

    start_mm: Point
    end_mm: Point
    centre_mm: Point | None = None
    sweep_rad: float = 0.0

    def distance_mm(self, points: Array) -> Array:
        """Returns the distance of points (n, 2) from the line or circle that carries the move."""
        start, end = np.asarray(self.start_mm), np.asarray(self.end_mm)
        if self.centre_mm is not None:
            centre = np.asarray(self.centre_mm)
            off_circle: Array = np.linalg.norm(points - centre, axis=1) - float(np.linalg.norm(start - centre))
            return np.abs(off_circle)
        chord = (end - start) / np.linalg.norm(end - start)
        offset = points - start
        off_chord: Array = offset[:, 0] * chord[1] - offset[:, 1] * chord[0]
        return np.abs(off_chord)

    def gap_mm(self, points: Array) -> Array:
        """Returns the distance of points (n, 2) from the move itself, which ends at its ends."""
        start, end = np.asarray(self.start_mm), np.asarray(self.end_mm)
        to_ends: Array = np.minimum(*(np.linalg.norm(points - point, axis=1) for point in (start, end)))
        if self.centre_mm is None and self.start_mm == self.end_mm:
            return to_ends
        return np.where(self._beside(points), self.distance_mm(points), to_ends)

    def _beside(self, points: Array) -> Flags:
        """Returns whether the nearest point of the line or circle belongs to the move."""
        if self.centre_mm is None:
            chord = np.asarray(self.end_mm) - np.asarray(self.start_mm)
            along = (points - np.asarray(self.start_mm)) @ chord
            return np.asarray((along >= 0.0) & (along <= chord @ chord))
        arms = np.vstack([np.asarray(self.start_mm), points]) - np.asarray(self.centre_mm)
        angle = np.arctan2(arms[:, 0], arms[:, 1])  # falls along a clockwise move
        turned = np.sign(self.sweep_rad) * (angle[0] - angle[1:]) % (2 * np.pi)
        return np.asarray(turned <= abs(self.sweep_rad))


@dataclass(frozen=True)
class SampledPath:
    """Samples of a path: points and unit tangents (n, 2), and how far the moves may stand off each (n,)."""

    point_mm: Array
    tangent: Array
    tolerance_mm: Array


def between(move: Move, start_mm: Point, end_mm: Point) -> Move:
    """Returns the move with other ends; an arc keeps radius and side, its centre follows. For small displacements."""
    if move.centre_mm is None:
        return Move(start_mm, end_mm)
    start, end = np.asarray(start_mm), np.asarray(end_mm)
    chord = end - start
    radius = float(np.linalg.norm(np.asarray(move.start_mm) - np.asarray(move.centre_mm)))
    half = float(np.linalg.norm(chord)) / 2
    arm = (abs(radius**2 - half**2)) ** 0.5
    right = np.array([-chord[1], chord[0]]) / (2 * half)
    side = 1.0 if (move.sweep_rad > 0) == (abs(move.sweep_rad) < np.pi) else -1.0
    sweep = float(np.copysign(2 * np.arcsin(min(half / radius, 1.0)), move.sweep_rad))
    if abs(move.sweep_rad) > np.pi:
        sweep = float(np.copysign(2 * np.pi, sweep)) - sweep
    return Move(start_mm, end_mm, _point((start + end) / 2 + side * arm * right), sweep)


def within_quadrants(move: Move) -> tuple[Move, ...]:
    """Cuts the move where its circle passes from one quadrant into the next; pieces under `SLIVER_MM` stay attached.

    A control in single-quadrant mode takes no arc that goes beyond one [6811 §A.1.1].
    """
    if move.centre_mm is None:
        return (move,)
    arm = np.asarray(move.start_mm) - np.asarray(move.centre_mm)
    radius, start = float(np.hypot(*arm)), float(np.arctan2(arm[0], arm[1]))
    sliver = SLIVER_MM / radius
    sign = float(np.sign(move.sweep_rad))
    turned = (sign * start) % (np.pi / 2)
    cuts = [t for t in np.arange(turned, abs(move.sweep_rad), np.pi / 2) if sliver < t < abs(move.sweep_rad) - sliver]
    angles = [start - sign * t for t in cuts]
    corners = [_point(np.asarray(move.centre_mm) + radius * np.array([np.sin(a), np.cos(a)])) for a in angles]
    sweeps = np.diff([0.0, *cuts, abs(move.sweep_rad)]) * sign
    ends = zip([move.start_mm, *corners], [*corners, move.end_mm], sweeps, strict=True)
    return tuple(Move(a, b, move.centre_mm, float(sweep)) for a, b, sweep in ends)


Fit: TypeAlias = Callable[[SampledPath, int, int], tuple[Move, ...]]


def as_lines(path: SampledPath) -> tuple[Move, ...]:
    """Chords between samples of the path."""
    return _greedy(path, _chord)


def as_arcs(path: SampledPath) -> tuple[Move, ...]:
    """Pairs of arcs, each tangent to the next and to the path where a pair ends."""
    return _greedy(path, _arc_pair)


def fewest_moves(path: SampledPath) -> tuple[Move, ...]:
    """Lines or tangent arcs, whichever are fewer; arcs when equal, because they leave no facets."""
    arcs = as_arcs(path)
    return _greedy(path, _chord, len(arcs)) or arcs


def _greedy(path: SampledPath, fit: Fit, fewer_than: int | None = None) -> tuple[Move, ...]:
    """None at all where they would not be fewer than that many."""
    moves: list[Move] = []
    first, last = 0, len(path.point_mm) - 1
    while first < last:
        # The furthest sample that one fit reaches within tolerance: doubling steps, then halving
        reach, step = first + 1, 1
        while reach < last and _holds(path, fit, first, min(reach + step, last)):
            reach = min(reach + step, last)
            step *= 2
        bad = min(reach + step, last + 1)
        while bad - reach > 1:
            middle = (reach + bad) // 2
            if _holds(path, fit, first, middle):
                reach = middle
            else:
                bad = middle
        if reach < last and np.linalg.norm(path.point_mm[last] - path.point_mm[reach]) < SHORT_MM:
            reach = max((first + last) // 2, first + 1)
        moves += fit(path, first, reach)
        if fewer_than is not None and len(moves) >= fewer_than:
            return ()
        first = reach
    return tuple(moves)


def _holds(path: SampledPath, fit: Fit, first: int, last: int) -> bool:
    inside = slice(first + 1, last)
    return bool(np.all(_distance(fit(path, first, last), path.point_mm[inside]) <= path.tolerance_mm[inside]))


def _distance(moves: Sequence[Move], points: Array) -> Array:
    """Returns the distance of points from a chord, or from that arc of a pair on whose side of the joint they lie."""
    if len(moves) == 1 or not len(points):
        return moves[0].distance_mm(points)
    first, second = moves
    joint = np.asarray(first.end_mm)
    along = np.asarray(second.end_mm) - np.asarray(first.start_mm)
    return np.where((points - joint) @ along < 0, first.distance_mm(points), second.distance_mm(points))


def _chord(path: SampledPath, first: int, last: int) -> tuple[Move, ...]:
    return (Move(_point(path.point_mm[first]), _point(path.point_mm[last])),)


def _arc_pair(path: SampledPath, first: int, last: int) -> tuple[Move, ...]:
    """Returns the biarc with legs of equal length d: |v|² − 2 d v·(t₀ + t₁) − 2 d² (1 − t₀·t₁) = 0, v the chord."""
    start, end = path.point_mm[first], path.point_mm[last]
    leaving, arriving = path.tangent[first], path.tangent[last]
    chord = end - start
    b = float(chord @ (leaving + arriving))
    a = 2.0 * (1.0 - float(leaving @ arriving))
    leg = float(chord @ chord) / (b + float(np.sqrt(b * b + a * float(chord @ chord))))
    joint = 0.5 * (start + end + leg * (leaving - arriving))
    return _arc(start, leaving, joint), _arc_back(joint, end, arriving)


def _arc(start: Array, leaving: Array, end: Array) -> Move:
    """Returns the arc from `start` in direction `leaving` to `end`; a line where it is as good as straight."""
    chord = end - start
    squared = float(chord @ chord)
    left = float(leaving[1] * chord[0] - leaving[0] * chord[1])
    if abs(left) / 4 < STRAIGHT_SAGITTA_MM:
        return Move(_point(start), _point(end))
    radius = squared / (2 * left)
    centre = start + radius * np.array([leaving[1], -leaving[0]])
    sweep = -2.0 * float(np.arctan2(left, leaving @ chord))
    return Move(_point(start), _point(end), _point(centre), sweep)


def _arc_back(start: Array, end: Array, arriving: Array) -> Move:
    """Returns the arc from `start` to `end` that arrives in direction `arriving`."""
    mirrored = _arc(end, -arriving, start)
    return Move(mirrored.end_mm, mirrored.start_mm, mirrored.centre_mm, -mirrored.sweep_rad)


def _point(vector: Array) -> Point:
    return float(vector[0]), float(vector[1])
