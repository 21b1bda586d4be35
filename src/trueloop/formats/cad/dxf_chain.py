"""Loose lines and arcs to chains, by their ends."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
from scipy.spatial import KDTree

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cad.dxf_edges import Edges, Numbers

SLIP: Final = 100.0
"""Free ends that lie apart by more than the tolerance but less than this many times it were meant to meet."""

Chain: TypeAlias = list[tuple[int, bool]]
"""Numbers of edges, and whether each is run from its end to its start."""


def chains_of(edges: Edges, within_mm: float, path: Path) -> list[Chain]:
    """Returns edges put head to tail where ends lie within the tolerance; each chain in either direction.

    Raises GEO-DXF-CHOICE where three ends meet or a chain is closed, GEO-GAP where two free ends nearly meet.
    """
    if not len(edges):
        return []
    ends = np.stack([edges.start_mm, edges.end_mm], axis=1).reshape(-1, 2)
    tree = KDTree(ends)
    near = _nearest(tree, ends, within_mm)
    others = (near < tree.n) & (near != np.arange(tree.n)[:, None])
    for end in np.flatnonzero(others.sum(axis=1) > 1):
        count = tree.query_ball_point(ends[end], within_mm, return_length=True)
        raise _choice(path, f"{count} ends meet at {_at(ends[end])}", "leave one way on at every point")
    free = np.flatnonzero(~others.any(axis=1))
    _refuse_slip(ends, free, within_mm, path)
    chains = _walk(np.where(others, near, -1).max(axis=1).tolist(), free.tolist())
    if (left := len(edges) - sum(map(len, chains))) > 0:
        raise _choice(
            path, f"{left} segments form closed outlines off the axis", "draw the turned side as an open chain"
        )
    return chains


def _walk(meets: Sequence[int], free: Sequence[int]) -> list[Chain]:
    """From each free end on to the other; end 2i is the start of edge i, end 2i + 1 its end; −1 meets none."""
    chains, done = list[Chain](), set[int]()
    for end in free:
        if end in done:
            continue
        chain, at = Chain(), end
        while at >= 0:
            chain.append((at // 2, bool(at % 2)))
            far = at ^ 1
            at = meets[far]
        done |= {end, far}
        chains.append(chain)
    return chains


def _nearest(tree: KDTree, points: Array, within_mm: float) -> Numbers:
    """By point, the three nearest of the tree's within a distance, itself among them; the tree's number of none."""
    return np.asarray(tree.query(points, k=3, distance_upper_bound=within_mm * (1 + 1e-12))[1])


def _refuse_slip(ends: Array, free: Numbers, within_mm: float, path: Path) -> None:
    """Refuses free ends, not of one edge, that nearly meet."""
    if not len(free):
        return
    near = np.append(free, -1)[_nearest(KDTree(ends[free]), ends[free], SLIP * within_mm)]
    slips = (near >= 0) & (near != free[:, None]) & (near != free[:, None] ^ 1)
    for i, j in np.argwhere(slips):
        first, second = ends[free[i]], ends[near[i, j]]
        gap_mm = math.dist(first, second)
        raise Code.GEO_GAP.refusal(
            f"two ends lie {gap_mm:.4f} mm apart, at {_at(first)} and {_at(second)}",
            hint=f"join them in the drawing: ends within {within_mm:g} mm count as one point",
            place=Place(str(path)),
            values={"gap_mm": gap_mm},
        )


def _at(point: Array) -> str:
    return f"x = {point[0]:.4f} mm, z = {point[1]:.4f} mm"


def _choice(path: Path, message: str, hint: str) -> TrueloopError:
    return Code.GEO_DXF_CHOICE.refusal(message, hint=hint, place=Place(str(path)))
