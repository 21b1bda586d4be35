"""Loose lines and arcs to chains, by their ends."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Feature, Point

SLIP: Final = 100.0
"""Free ends that lie apart by more than the tolerance but less than this many times it were meant to meet."""


@dataclass(frozen=True)
class Segment:
    """One drawn line or arc and the layer it is on."""

    feature: Feature
    layer: str

    def reversed(self) -> "Segment":
        """The same segment run from its end to its start."""
        return replace(self, feature=self.feature.reversed())

    @property
    def ends(self) -> tuple[Point, Point]:
        """Where it starts and ends."""
        return self.feature.start_mm, self.feature.end_mm


def chains_of(segments: Sequence[Segment], within_mm: float, path: Path) -> list[list[Segment]]:
    """Segments put head to tail where ends lie within the tolerance; each chain in either direction.

    Raises GEO-DXF-CHOICE where three ends meet or a chain is closed, GEO-GAP where two free ends nearly meet.
    """
    if not segments:
        return []
    ends = np.array([end for segment in segments for end in segment.ends])
    apart = np.linalg.norm(ends[:, None] - ends[None], axis=-1)
    np.fill_diagonal(apart, np.inf)
    meets = [[int(other) for other in np.flatnonzero(row <= within_mm)] for row in apart]
    for end, others in enumerate(meets):
        if len(others) > 1:
            raise _choice(path, f"{len(others) + 1} ends meet at {_at(ends[end])}", "leave one way on at every point")
    free = [end for end, others in enumerate(meets) if not others]
    _refuse_slip(ends, apart, free, within_mm, path)
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


def _refuse_slip(
    ends: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    apart: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    free: Sequence[int],
    within_mm: float,
    path: Path,
) -> None:
    for i, first in enumerate(free):
        for second in free[i + 1 :]:
            if second != first ^ 1 and apart[first, second] <= SLIP * within_mm:
                raise TrueloopError(
                    Code.GEO_GAP,
                    f"two ends lie {apart[first, second]:.4f} mm apart, at {_at(ends[first])} and {_at(ends[second])}",
                    hint=f"join them in the drawing: ends within {within_mm:g} mm count as one point",
                    place=Place(str(path)),
                    values={"gap_mm": float(apart[first, second])},
                )


def _at(point: Sequence[float]) -> str:
    return f"x = {point[0]:.4f} mm, z = {point[1]:.4f} mm"


def _choice(path: Path, message: str, hint: str) -> TrueloopError:
    return TrueloopError(Code.GEO_DXF_CHOICE, message, hint=hint, place=Place(str(path)))
