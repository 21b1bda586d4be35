"""How far two tool paths lie apart: the largest distance from a point of one to the nearest point of the other.

That is the Hausdorff distance of the two curves: order, direction, feed and how the cuts are split into blocks play no
part. Points are taken at the ends of moves and between them no further apart than `spacing_mm`; arcs are chords whose
sagitta is at most `SAGITTA_MM`. The largest distance is thereby known to half the spacing, and much better where the
paths run nearly parallel, as those of a program and its correction do.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.along import lengths_mm, points_along
from trueloop.nc.tool_path import Array, Integers, Motion, ToolPath

SAGITTA_MM: Final = 1e-6
_FINEST_MM: Final = 0.01
_MOST_POINTS: Final = 200_000
_NEIGHBOURS: Final = 8
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class PathDifference:
    """The place where two paths lie furthest apart.

    `first` says whether the point at `position_mm` (x a radius, y, z) is of the first path; `move` is the index of its
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
    """The largest distance between the cuts of two paths; with `rapids` between all their moves.

    Raises NC-NO-CONTOUR where a path has none, NC-EXPRESSION where a position is not known.
    """
    chosen = [compared_moves(path, rapids) for path in (first, second)]
    length_mm = max(float(lengths_mm(path, moves).sum()) for path, moves in zip((first, second), chosen, strict=True))
    spacing_mm = max(_FINEST_MM, length_mm / _MOST_POINTS)
    one, other = (_pieces(path, moves, spacing_mm) for path, moves in zip((first, second), chosen, strict=True))
    there, back = _furthest(one, other, True, spacing_mm), _furthest(other, one, False, spacing_mm)
    return there if there.distance_mm >= back.distance_mm else back


def compared_moves(path: ToolPath, rapids: bool) -> NDArray[np.intp]:
    """The cuts of a path, with `rapids` all its moves. Raises as `path_difference`."""
    moves = np.flatnonzero(np.ones(len(path), dtype=np.bool_) if rapids else ~path.rapid)
    if not moves.size:
        raise TrueloopError(
            Code.NC_NO_CONTOUR,
            f"none of the program's {len(path)} moves is a cut: nothing to compare",
            hint="check the dialect, or compare rapid moves too",
        )
    known = np.isfinite(path.start_mm[moves]).all(axis=1) & np.isfinite(path.end_mm[moves]).all(axis=1)
    if not known.all():
        line = int(path.line[moves[~known][0]])
        raise TrueloopError(
            Code.NC_EXPRESSION,
            f"line {line} begins or ends at a position that is not known",
            hint="give the parameters it needs: --set",
            place=Place(line=line),
        )
    return moves


def _pieces(path: ToolPath, moves: NDArray[np.intp], spacing_mm: float) -> _Pieces:
    points = [
        _points(path, int(move), length, spacing_mm)
        for move, length in zip(moves, lengths_mm(path, moves), strict=True)
    ]
    counts = [len(of_move) - 1 for of_move in points]
    return _Pieces(
        np.concatenate([of_move[:-1] for of_move in points]),
        np.concatenate([of_move[1:] for of_move in points]),
        np.repeat(moves, counts),
    )


def _points(path: ToolPath, move: int, length_mm: float, spacing_mm: float) -> Array:
    """Points along a move, its ends included: (n, 3), at least two."""
    count = max(int(np.ceil(length_mm / spacing_mm)), 1)
    if path.motion[move] == Motion.ARC:
        radius_mm = float(np.linalg.norm(path.start_mm[move] - path.centre_mm[move]))
        chords = abs(path.sweep_rad[move]) * np.sqrt(radius_mm / (8 * SAGITTA_MM))
        count = max(count, int(min(np.ceil(chords), _MOST_POINTS)))
    return points_along(path, np.intp(move), np.linspace(0.0, 1.0, count + 1))


def _furthest(here: _Pieces, there: _Pieces, first: bool, spacing_mm: float) -> PathDifference:
    """The point of `here` that lies furthest from `there`."""
    from scipy.spatial import cKDTree  # heavy, and only this command needs it

    points = np.concatenate([here.start_mm, here.end_mm])
    tree = cKDTree((there.start_mm + there.end_mm) / 2)
    _, near = tree.query(points, k=min(_NEIGHBOURS, len(there.move)))
    near = near.reshape(len(points), -1)
    foot = _foot(points[:, None], there.start_mm[near], there.end_mm[near])
    at_most_mm = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
    half_mm = float(np.linalg.norm(there.end_mm - there.start_mm, axis=1).max()) / 2
    while True:
        # Many short pieces may hide a longer one that is nearer: only what is furthest has to be known exactly.
        at = int(at_most_mm.argmax())
        around = np.array(tree.query_ball_point(points[at], (at_most_mm[at] + half_mm) * (1 + _ROUNDING)))
        foot = _foot(points[at], there.start_mm[around], there.end_mm[around])
        distance_mm = np.linalg.norm(points[at] - foot, axis=1)
        best = int(distance_mm.argmin())
        if distance_mm[best] >= at_most_mm[at] * (1 - _ROUNDING):
            break
        at_most_mm[at] = distance_mm[best]
    return PathDifference(
        float(distance_mm[best]),
        first,
        int(here.move[at % len(here.move)]),
        _triple(points[at]),
        int(there.move[around[best]]),
        _triple(foot[best]),
        spacing_mm,
    )


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
