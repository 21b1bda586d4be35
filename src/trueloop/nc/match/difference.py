"""The distance of two tool paths: the largest distance from a point of one to the nearest point of the other.

That is the Hausdorff distance of the two curves: order, direction, feed and how the cuts are split into blocks play no
part. Points are taken at the ends of moves and between them no further apart than `spacing_mm`; arcs are chords whose
sagitta is at most `SAGITTA_MM`. The largest distance is thereby known to half the spacing, and much better where the
paths run nearly parallel, as those of a program and its correction do.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Place
from trueloop.nc.program.along import lengths_mm, points_along
from trueloop.nc.program.tool_path import Motion, ToolPath

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

SAGITTA_MM: Final = 1e-6
_FINEST_MM: Final = 0.01
_MOST_POINTS: Final = 200_000
_NEIGHBOURS: Final = 4
_AT_ONCE: Final = 20_000
_STRIDES: Final = (256, 16, 1)
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class PathDifference:
    """The place where two paths lie furthest apart.

    `first` is whether the point at `position_mm` (x a radius, y, z) is of the first path; `move` is the index of its
    move there. `nearest_mm` and `nearest_move` are of the other path.
    """

    distance_mm: float
    first: bool
    move: int
    position_mm: tuple[float, float, float]
    nearest_move: int
    nearest_mm: tuple[float, float, float]
    spacing_mm: float


@dataclass(frozen=True)
class _Pieces:
    """Straight pieces of a path: ends (n, 3) and the move of each (n,)."""

    start_mm: Array
    end_mm: Array
    move: Integers


def path_difference(first: ToolPath, second: ToolPath, *, rapids: bool = False) -> PathDifference:
    """Returns the largest distance between the cuts of two paths; with `rapids` between all their moves.

    Raises NC-NO-CONTOUR where a path has none, NC-EXPRESSION where a position is not known.

    >>> semifinish = trueloop.read_program(trueloop.example("modbas2/semifinish.nc"), "ge2000t")
    >>> finish = trueloop.read_program(trueloop.example("modbas2/finish.nc"), "ge2000t")
    >>> given = {"P42": 8.0, "P46": 3.52, "P47": 0.0}
    >>> found = trueloop.path_difference(semifinish.run(given), finish.run(given))
    >>> round(found.distance_mm, 3)
    0.359
    """
    chosen = [compared_moves(path, rapids) for path in (first, second)]
    length_mm = max(float(lengths_mm(path, moves).sum()) for path, moves in zip((first, second), chosen, strict=True))
    spacing_mm = max(_FINEST_MM, length_mm / _MOST_POINTS)
    one, other = (_pieces(path, moves, spacing_mm) for path, moves in zip((first, second), chosen, strict=True))
    there, back = _furthest(one, other, True, spacing_mm), _furthest(other, one, False, spacing_mm)
    return there if there.distance_mm >= back.distance_mm else back


def compared_moves(path: ToolPath, rapids: bool) -> NDArray[np.intp]:
    """Returns the cuts of a path, with `rapids` all its moves. Raises as `path_difference`."""
    moves = np.flatnonzero(np.ones(len(path), dtype=np.bool_) if rapids else ~path.rapid)
    if not moves.size:
        raise Code.NC_NO_CONTOUR.refusal(
            f"none of the program's {len(path)} moves is a cut: nothing to compare",
            hint="check the dialect, or compare rapid moves too",
        )
    known = np.isfinite(path.start_mm[moves]).all(axis=1) & np.isfinite(path.end_mm[moves]).all(axis=1)
    if not known.all():
        line = int(path.line[moves[~known][0]])
        raise Code.NC_EXPRESSION.refusal(
            f"line {line} begins or ends at a position that is not known",
            hint="give the parameters it needs: --set",
            place=Place(line=line),
        )
    return moves


def _pieces(path: ToolPath, moves: NDArray[np.intp], spacing_mm: float) -> _Pieces:
    """Every move in equal pieces, in order."""
    counts = _piece_counts(path, moves, spacing_mm)
    last = np.cumsum(counts) - 1
    first = last - counts + 1
    move = np.repeat(moves, counts)
    shares = (np.arange(len(move)) - np.repeat(first, counts) + 1) / np.repeat(counts, counts)
    end_mm = points_along(path, move, shares)
    end_mm[last] = path.end_mm[moves]
    start_mm = np.roll(end_mm, 1, axis=0)
    start_mm[first] = path.start_mm[moves]
    return _Pieces(start_mm, end_mm, move)


def _piece_counts(path: ToolPath, moves: NDArray[np.intp], spacing_mm: float) -> NDArray[np.intp]:
    """How many pieces each move has: none is longer than the spacing, and none of an arc further off it than stated."""
    counts = np.maximum(np.ceil(lengths_mm(path, moves) / spacing_mm), 1)
    arcs = path.motion[moves] == Motion.ARC
    turning = moves[arcs]
    radius_mm = np.linalg.norm(path.start_mm[turning] - path.centre_mm[turning], axis=1)
    chords = np.ceil(np.abs(path.sweep_rad[turning]) * np.sqrt(radius_mm / (8 * SAGITTA_MM)))
    counts[arcs] = np.maximum(counts[arcs], np.minimum(chords, _MOST_POINTS))
    return counts.astype(np.intp)


def _furthest(here: _Pieces, there: _Pieces, first: bool, spacing_mm: float) -> PathDifference:
    """The point of `here` that lies furthest from `there`."""
    points, move = _points(here)
    others = _Others.of(there)
    at_most_mm = _at_most_mm(points, others)
    known, size = np.zeros(len(points), dtype=np.bool_), 1
    # Many short pieces may hide a longer one that is nearer: only what is furthest has to be known exactly.
    while not known[at := int(at_most_mm.argmax())]:
        top = np.append(np.argpartition(at_most_mm, -size)[-size:], at)
        top = np.unique(top[~known[top]])
        at_most_mm[top] = others.distance_mm(points[top])
        known[top] = True
        size = min(2 * size, _AT_ONCE // 20, len(points))
    around, foot_mm, distance_mm = others.around(points[[at]], at_most_mm[[at]])[1:]
    best = int(distance_mm.argmin())
    return PathDifference(
        distance_mm=float(distance_mm[best]),
        first=first,
        move=int(move[at]),
        position_mm=_triple(points[at]),
        nearest_move=int(there.move[around[best]]),
        nearest_mm=_triple(foot_mm[best]),
        spacing_mm=spacing_mm,
    )


def _points(pieces: _Pieces) -> tuple[Array, Integers]:
    """The starts of pieces, then the ends from which the next one does not start: (n, 3), and the move of each."""
    left = np.append((pieces.start_mm[1:] != pieces.end_mm[:-1]).any(axis=1), True)
    return np.concatenate([pieces.start_mm, pieces.end_mm[left]]), np.append(pieces.move, pieces.move[left])


def _at_most_mm(points: Array, others: "_Others") -> Array:
    """Distances (n,) of points (n, 3) that the real ones do not exceed; the largest of them is near the real one.

    From one point to the next the distance changes by no more than the way between them: of most points that says
    enough, once a few are known. Far from the other path, where many pieces are nearly as near, looking is slow.
    """
    at_most_mm, least_mm, known = np.full(len(points), np.inf), 0.0, np.zeros(0, dtype=np.intp)
    for stride in _STRIDES:
        asked = np.arange(0, len(points), stride)
        if known.size:
            before = known[np.searchsorted(known, asked, side="right") - 1]
            way_mm = np.linalg.norm(points[asked] - points[before], axis=1)
            at_most_mm[asked] = np.minimum(at_most_mm[asked], at_most_mm[before] + way_mm)
            asked = asked[(at_most_mm[asked] > least_mm) & (asked != before)]
        for part in np.split(asked, range(_AT_ONCE, len(asked), _AT_ONCE)) if asked.size else ():
            at_most_mm[part], at_least_mm = others.bounds_mm(points[part])
            least_mm = max(least_mm, at_least_mm)
        known = np.union1d(known, asked)
    return at_most_mm


@dataclass(frozen=True)
class _Others:
    """The pieces from which distances are measured, in a tree of their middles; `half_mm` of the longest."""

    pieces: _Pieces
    tree: "cKDTree"
    half_mm: float

    @classmethod
    def of(cls, pieces: _Pieces) -> "_Others":
        from scipy.spatial import cKDTree  # heavy, and only this command needs it

        tree = cKDTree((pieces.start_mm + pieces.end_mm) / 2)
        return cls(pieces, tree, float(np.linalg.norm(pieces.end_mm - pieces.start_mm, axis=1).max()) / 2)

    def bounds_mm(self, points: Array) -> tuple[Array, float]:
        """Distances (n,) of points (n, 3) from the pieces whose middles are nearest, and what the largest of the real
        distances is at least: no piece whose middle is further away is nearer than that less half its length.
        """
        middle_mm, near = self.tree.query(points, k=min(_NEIGHBOURS, len(self.pieces.move)))
        near, nearest_middle_mm = near.reshape(len(points), -1), np.reshape(middle_mm, (len(points), -1))[:, 0]
        foot_mm = _foot(points[:, None], self.pieces.start_mm[near], self.pieces.end_mm[near])
        nearest_mm: Array = np.linalg.norm(points[:, None] - foot_mm, axis=2).min(axis=1)
        return nearest_mm, float(nearest_middle_mm.max(initial=0.0)) - self.half_mm

    def distance_mm(self, points: Array) -> Array:
        """Distances (n,) of points (n, 3)."""
        count, _, _, distance_mm = self.around(points, self.bounds_mm(points)[0])
        nearest_mm: Array = np.minimum.reduceat(distance_mm, np.cumsum(count) - count)
        return nearest_mm

    def around(self, points: Array, at_most_mm: Array) -> tuple[Integers, Integers, Array, Array]:
        """Of points (n, 3) every piece that may be as near: how many each (n,), their index, foot (k, 3) and distance.

        The middle of the nearest piece is at most half its length further away than its nearest point.
        """
        found = self.tree.query_ball_point(points, (at_most_mm + self.half_mm) * (1 + _ROUNDING))
        count, index = np.array([len(of_point) for of_point in found]), np.concatenate(found).astype(np.intp)
        point = np.repeat(points, count, axis=0)
        foot_mm = _foot(point, self.pieces.start_mm[index], self.pieces.end_mm[index])
        return count, index, foot_mm, np.linalg.norm(point - foot_mm, axis=1)


def _foot(point: Array, start: Array, end: Array) -> Array:
    """The nearest point of each piece."""
    along = end - start
    square = np.maximum((along * along).sum(axis=-1, keepdims=True), np.finfo(float).tiny)
    share = np.clip(((point - start) * along).sum(axis=-1, keepdims=True) / square, 0.0, 1.0)
    foot: Array = start + share * along
    return foot


def _triple(point: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in point)
    return x, y, z
