"""Cutter locations moved so that they cut the corrected surface as they cut the nominal one."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.compensation.cutter import Contacts, Cutter, contacts, edge_centres_mm
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_closest import closest
from trueloop.units import UM_PER_MM

CUTS_MM: Final = 0.05
"""A cutter farther than this off the nominal surface does not finish it: it leads in, leads out, or passes by."""
ROUNDS: Final = 12
SAME_MM: Final = 1e-8
AROUND: Final = 12
"""Places around a cutter's edge that are searched for gouges."""


@dataclass(frozen=True, eq=False)
class MovedLocations:
    """Cutter locations (n, 3) after correction, and which of them cut the surface at all; the others stay."""

    tips_mm: Array
    cutting: np.ndarray
    gap_mm: Array


def moved_locations(
    nominal: Surface, corrected: Surface, cutter: Cutter, tips_mm: Array, axes: Array, *, cuts_mm: float = CUTS_MM
) -> MovedLocations:
    """Every location whose gap to the nominal surface is at most `cuts_mm`, moved along the nominal normal until its
    gap to the corrected surface is the same.

    The gap is kept, not made zero: what a roughing allowance, a chord or the programmer's rounding left stays left.
    """
    before = contacts(nominal, cutter, tips_mm, axes)
    cutting = (np.abs(before.gap_mm) <= cuts_mm) & (before.feet.beyond_mm <= cuts_mm)
    moved = tips_mm.copy()
    if np.any(cutting):
        moved[cutting] = _moved(before, corrected, cutter, tips_mm, axes, cutting)
    return MovedLocations(moved, cutting, before.gap_mm)


def check_gouges(corrected: Surface, cutter: Cutter, tips_mm: Array, axes: Array, allowed_mm: float) -> None:
    """Refuses locations (n, 3) that cut into the corrected surface by more than `allowed_mm` anywhere.

    The nearest point of the surface is looked for afresh for each, wherever on the patch it is: a ball in a hollow
    narrower than itself is nearest to a rim it was not meant to touch. So it is for places all around the edge of a
    bull-nose or flat cutter, which in a hollow cuts where it does not lean. Raises SRF-GOUGE.
    """
    found = contacts(corrected, cutter, tips_mm, axes)
    feet, gap = [found.feet], [found.gap_mm]
    for centres in edge_centres_mm(cutter, tips_mm, axes, AROUND):
        feet.append(closest(corrected, centres))
        gap.append(feet[-1].distance_mm - cutter.corner_mm)
    inside = np.concatenate([some.beyond_mm for some in feet]) <= SAME_MM
    points = np.concatenate([some.point_mm for some in feet])
    deep = np.where(inside, -np.concatenate(gap), -np.inf)
    worst = int(np.argmax(deep))
    if deep[worst] > allowed_mm:
        x, y, z = points[worst]
        raise TrueloopError(
            Code.SRF_GOUGE,
            f"the cutter would cut {deep[worst] * UM_PER_MM:.1f} µm into the corrected surface at x {x:.3f}, "
            f"y {y:.3f}, z {z:.3f} mm; {allowed_mm * UM_PER_MM:.1f} µm is allowed, exceeded at "
            f"{np.count_nonzero(deep > allowed_mm)} places",
            hint="the cutter is too large for a hollow there, or the program belongs to another surface or tool",
        )


def _moved(
    before: Contacts, corrected: Surface, cutter: Cutter, tips: Array, axes: Array, cutting: np.ndarray
) -> Array:
    (u0, u1), (v0, v1) = corrected.domain
    normal, wanted = before.feet.normal[cutting], before.gap_mm[cutting]
    tips, axes = tips[cutting], axes[cutting]
    start = closest(corrected, before.feet.point_mm[cutting])
    near = (np.clip(start.u, u0, u1), np.clip(start.v, v0, v1))
    along = np.zeros(len(tips))
    for _ in range(ROUNDS):
        now = contacts(corrected, cutter, tips + along[:, None] * normal, axes, near)
        step = wanted - now.gap_mm
        along += step
        near = (now.feet.u, now.feet.v)
        if np.max(np.abs(step)) < SAME_MM:
            break
    return np.asarray(tips + along[:, None] * normal)
