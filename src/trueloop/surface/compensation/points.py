"""Cutter locations moved so that they cut the corrected surface as they cut the nominal one."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_closest import closest
from trueloop.surface.compensation.cutter import Contacts, Cutter, contacts

CUTS_MM: Final = 0.05
"""A cutter farther than this off the nominal surface does not finish it: it leads in, leads out, or passes by."""
ROUNDS: Final = 12
SAME_MM: Final = 1e-8


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
    cutting = is_cutting(before, cuts_mm)
    moved = tips_mm.copy()
    if np.any(cutting):
        moved[cutting] = _moved(before, corrected, cutter, tips_mm, axes, cutting)
    return MovedLocations(moved, cutting, before.gap_mm)


def is_cutting(found: Contacts, cuts_mm: float = CUTS_MM) -> np.ndarray:
    """At which places (n,) the cutter finishes the surface."""
    return np.asarray((np.abs(found.gap_mm) <= cuts_mm) & (found.feet.beyond_mm <= cuts_mm))


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
