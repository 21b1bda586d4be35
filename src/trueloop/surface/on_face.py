"""Which places of a surface are on the face that exists: what its trimming curves cut away counts nowhere."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, Protocol, TypeAlias

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.geometry.surface import Surface

Trim: TypeAlias = Callable[[Array, Array], np.ndarray]
"""Which places (u, v) of a surface, in its own parameters, are cut away: asked of the CAD kernel, and never stored."""


class NextFace(Protocol):
    """Another face of the same CAD model."""

    @property
    def number(self) -> int:
        """Returns its number from 1, in the order of the file."""

    @property
    def surface(self) -> Surface:
        """Returns its surface. Raises SRF-CAD where the kernel cannot make one of it."""

    def trimmed_away(self, u: Array, v: Array) -> np.ndarray:
        """Returns which places of its surface are cut away, as `Trim`."""


MAPS: Final = 50
LIMITS: Final = 60
FIGURES: Final = 61
SUPPORT: Final = 121
"""Places a side of the grids on which maps are drawn, limits judged, figures made, and the support is known."""


@by_content
@dataclass(frozen=True)
class OnFace:
    """The face on square grids of parameters in [0, 1]: (n, n) by the grid's n. Without grids, nothing is cut away."""

    grids: Mapping[str, Flags] = field(default_factory=dict)

    def square(self, count: int) -> Flags:
        """Which places of a grid of this many a side are on the face, (count, count)."""
        return self.grids[str(count)] if self.grids else np.ones((count, count), dtype=np.bool_)


WHOLE: Final = OnFace()


def on_face(surface: Surface, trim: Trim | None) -> OnFace:
    """The face of a surface that is cut away where `trim` says."""
    if trim is None:
        return OnFace()
    (u0, u1), (v0, v1) = surface.domain
    grids = {}
    for count in (MAPS, LIMITS, FIGURES, SUPPORT):
        _, u, v = square(count)
        grids[str(count)] = ~trim(u0 + (u1 - u0) * u, v0 + (v1 - v0) * v).astype(np.bool_).reshape(count, count)
    return OnFace(grids)


def square(count: int) -> tuple[Array, Array, Array]:
    """Parameters of a square grid: one direction, and those of all pairs, a row after the other."""
    at = np.linspace(0.0, 1.0, count)
    return at, np.repeat(at, count), np.tile(at, count)
