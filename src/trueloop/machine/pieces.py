"""Moves whose corrected path the control can run: straight pieces and arcs within a tolerance of the displaced path.

The displaced path is p − E(p) for every programmed p. A straight move becomes one or more straight pieces between
displaced points, an arc one or more arcs through three displaced points each.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array

MOST: Final = 4096
"""Pieces of one move: more would mean that the model jumps there."""

PROBES: Final = 4
"""Checks within a piece: at quarters."""

Displace = Callable[[Array], Array]
"""Shares of the move in [0, 1], (m,), to displaced points, (m, 3)."""


@dataclass(frozen=True)
class Piece:
    """One block to write: where it ends, and for an arc its centre; (3,) mm in program coordinates, corrected."""

    end_mm: Array
    centre_mm: Array | None = None


def straight_pieces(displace: Displace, tolerance_mm: float, count: int = 1) -> list[Piece]:
    """Equal pieces, doubled in number until every chord lies within the tolerance of the displaced path."""
    while count <= MOST:
        points = displace(np.linspace(0.0, 1.0, PROBES * count + 1)).reshape(-1, 3)
        if _chord_error_mm(points).max() <= tolerance_mm:
            return [Piece(points[PROBES * (k + 1)]) for k in range(count)]
        count *= 2
    raise _jump()


def arc_pieces(displace: Displace, plane: tuple[int, int], tolerance_mm: float, cuts: Array) -> list[Piece]:
    """Arcs in `plane` (two axis numbers; the third changes linearly), from cut to cut, halved until within tolerance.

    `cuts` are shares of the move, 0 and 1 among them: one arc where it may be one.
    """
    pieces: list[Piece] = []
    waiting = [(float(a), float(b)) for a, b in pairwise(cuts)][::-1]
    while waiting:
        start, end = waiting.pop()
        points = displace(np.linspace(start, end, 2 * PROBES + 1))
        # on a full circle first and last point coincide: two others determine it
        centre = _centre(points[[0, 3, 5] if _closed(points) else [0, PROBES, -1]], plane)
        if centre is not None and _arc_error_mm(points, centre, plane) <= tolerance_mm:
            if pieces and np.linalg.norm(points[0] - pieces[-1].end_mm) > tolerance_mm:
                pieces.append(Piece(points[0]))  # an axis turns round here: its backlash is taken up
            pieces.append(Piece(points[-1], centre))
        elif end - start < 1.0 / MOST:
            raise _jump()
        else:
            middle = 0.5 * (start + end)
            waiting += [(middle, end), (start, middle)]
    return pieces


def _closed(points: Array) -> bool:
    return bool(np.linalg.norm(points[-1] - points[0]) < 0.1 * np.linalg.norm(points[PROBES] - points[0]))


def _chord_error_mm(points: Array) -> Array:
    """Distances of the quarter points from their piece's chord, (pieces, 3)."""
    ends = points[::PROBES]
    share = np.arange(1, PROBES)[None, :, None] / PROBES
    inner = np.stack([points[k::PROBES][: len(ends) - 1] for k in range(1, PROBES)], axis=1)
    distance: Array = np.linalg.norm(inner - (ends[:-1, None] * (1 - share) + ends[1:, None] * share), axis=2)
    return distance


def _centre(three: Array, plane: tuple[int, int]) -> Array | None:
    """Centre of the circle through three points in the plane, the third coordinate that of the first point."""
    a, b, c = three[:, list(plane)]
    matrix = 2 * np.array([b - a, c - a])
    if abs(np.linalg.det(matrix)) < 1e-12:
        return None
    centre: Array = three[0].copy()
    centre[list(plane)] = a + np.linalg.solve(matrix, [(b - a) @ (b - a), (c - a) @ (c - a)])
    return centre


def _arc_error_mm(points: Array, centre: Array, plane: tuple[int, int]) -> float:
    """Largest distance of the points from the helix that the control runs: round in the plane, straight across it."""
    across = 3 - plane[0] - plane[1]
    spoke = points[:, list(plane)] - centre[list(plane)]
    radial = np.linalg.norm(spoke, axis=1) - np.linalg.norm(spoke[0])
    angle = np.unwrap(np.arctan2(spoke[:, 1], spoke[:, 0]))
    share = (angle - angle[0]) / (angle[-1] - angle[0])
    straight = points[:, across] - (points[0, across] + share * (points[-1, across] - points[0, across]))
    return float(np.hypot(radial, straight).max())


def _jump() -> TrueloopError:
    return TrueloopError(
        Code.MCH_PROGRAM,
        f"a move would need more than {MOST} pieces to follow the model",
        hint="the model jumps along it, or the tolerance is below the control's resolution",
    )
