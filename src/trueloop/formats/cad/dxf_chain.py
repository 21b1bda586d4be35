"""Loose lines and arcs to chains, by their ends."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial import KDTree

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Feature, Point

SLIP: Final = 100.0
"""Free ends that lie apart by more than the tolerance but less than this many times it were meant to meet."""


@dataclass(frozen=True, slots=True)
class Segment:
    """One drawn line or arc and the layer it is on."""

    feature: Feature
    layer: str

    def reversed(self) -> "Segment":
        """Returns the segment run from its end to its start."""
        return replace(self, feature=self.feature.reversed())

    @property
    def ends(self) -> tuple[Point, Point]:
        """Returns its start and end."""
        return self.feature.start_mm, self.feature.end_mm


def chains_of(segments: Sequence[Segment], within_mm: float, path: Path) -> list[list[Segment]]:
    """Segments put head to tail where ends lie within the tolerance; each chain in either direction.

    Raises GEO-DXF-CHOICE where three ends meet or a chain is closed, GEO-GAP where two free ends nearly meet.
    """
    if not segments:
        return []
    ends = np.array([value for segment in segments for end in segment.ends for value in end]).reshape(-1, 2)
    tree = KDTree(ends)
    meets = [[other for other in near if other != end] for end, near in enumerate(_nearest(tree, ends, within_mm))]
    for end, others in enumerate(meets):
        if len(others) > 1:
            count = tree.query_ball_point(ends[end], within_mm, return_length=True)
            raise _choice(path, f"{count} ends meet at {_at(ends[end])}", "leave one way on at every point")
    free = [end for end, others in enumerate(meets) if not others]
    _refuse_slip(ends, free, within_mm, path)
    chains = _walk(segments, meets, free)
    if (left := len(segments) - sum(map(len, chains))) > 0:
        raise _choice(
            path, f"{left} segments form closed outlines off the axis", "draw the turned side as an open chain"
        )
    return chains


def _walk(segments: Sequence[Segment], meets: Sequence[Sequence[int]], free: Sequence[int]) -> list[list[Segment]]:
    """From each free end on to the other; end 2i is the start of segment i, end 2i + 1 its end."""
    chains, done = [], set[int]()
    for end in free:
        if end in done:
            continue
        chain, at = [], end
        while True:
            segment = segments[at // 2]
            chain.append(segment if at % 2 == 0 else segment.reversed())
            far = at ^ 1
            if not meets[far]:
                break
            at = meets[far][0]
        done |= {end, far}
        chains.append(chain)
    return chains


def _nearest(tree: KDTree, points: Array, within_mm: float) -> list[list[int]]:
    """By point, the three nearest of the tree's within a distance, itself among them."""
    _, found = tree.query(points, k=3, distance_upper_bound=within_mm * (1 + 1e-12))
    return [[int(other) for other in row if other < tree.n] for row in np.asarray(found)]


def _refuse_slip(ends: Array, free: Sequence[int], within_mm: float, path: Path) -> None:
    """Refuses free ends, not of one segment, that nearly meet."""
    if not free:
        return
    for i, near in enumerate(_nearest(KDTree(ends[free]), ends[free], SLIP * within_mm)):
        for first, second in ((free[i], free[j]) for j in near if j != i and free[j] != free[i] ^ 1):
            gap_mm = math.dist(ends[first], ends[second])
            raise Code.GEO_GAP.refusal(
                f"two ends lie {gap_mm:.4f} mm apart, at {_at(ends[first])} and {_at(ends[second])}",
                hint=f"join them in the drawing: ends within {within_mm:g} mm count as one point",
                place=Place(str(path)),
                values={"gap_mm": gap_mm},
            )


def _at(point: Sequence[float]) -> str:
    return f"x = {point[0]:.4f} mm, z = {point[1]:.4f} mm"


def _choice(path: Path, message: str, hint: str) -> TrueloopError:
    return Code.GEO_DXF_CHOICE.refusal(message, hint=hint, place=Place(str(path)))
