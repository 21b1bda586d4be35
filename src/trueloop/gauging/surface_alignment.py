"""Location and orientation: kept with the datums, or taken out by a best fit of six degrees of freedom."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_closest import Feet, closest

ROUNDS: Final = 20
STILL_MM: Final = 1e-9
LOOSE: Final = 1e-4
"""A motion that moves the points along their normals by less than this share of itself is not determined by them."""


@dataclass(frozen=True, eq=False)
class Alignment:
    """How measured points were brought onto the nominal surface.

    `kind` is "datum" (left where the datums put them) or "best fit". Points fitted are `rotation` @ (p − centre) +
    centre + `shift_mm`; `free` counts motions that the surface does not determine (a sphere has three), left at zero.
    """

    kind: str
    rotation: Array
    shift_mm: Array
    centre_mm: Array
    free: int = 0

    def apply(self, points_mm: Array) -> Array:
        """Points moved as this alignment moves them."""
        return np.asarray((points_mm - self.centre_mm) @ self.rotation.T + self.centre_mm + self.shift_mm)


DATUM: Final = Alignment("datum", np.eye(3), np.zeros(3), np.zeros(3))


def best_fit(surface: Surface, points_mm: Array, ball_radius_mm: float, feet: Feet) -> tuple[Alignment, Feet]:
    """The rigid motion of the points that makes the sum of their squared normal deviations least, and their feet then.

    Gauss–Newton: a small turn ω and shift t change a deviation by n·t + ((p − c) × n)·ω. The scale of the turn is the
    points' spread, so that what is determined and what is not is judged in millimetres.
    """
    centre = np.mean(points_mm, axis=0)
    spread = float(np.sqrt(np.mean(np.sum((points_mm - centre) ** 2, axis=1)))) or 1.0
    alignment = Alignment("best fit", np.eye(3), np.zeros(3), centre)
    for _ in range(ROUNDS):
        moved = alignment.apply(points_mm)
        turns = np.cross((moved - centre) / spread, feet.normal)
        motion, free = _least(np.concatenate([feet.normal, turns], axis=1), ball_radius_mm - feet.distance_mm)
        alignment = _moved(alignment, motion[:3], motion[3:] / spread, free)
        feet = closest(surface, alignment.apply(points_mm), (feet.u, feet.v))
        if np.max(np.abs(motion)) < STILL_MM:
            break
    return alignment, feet


def _least(design: Array, wanted: Array) -> tuple[Array, int]:
    """The smallest motion of least squares, and how many motions are not determined."""
    u, sizes, vt = np.linalg.svd(design, full_matrices=False)
    loose = sizes < LOOSE * np.sqrt(len(wanted))
    share = np.where(loose, 0.0, (u.T @ wanted) / np.where(loose, 1.0, sizes))
    return vt.T @ share, int(np.count_nonzero(loose))


def _moved(alignment: Alignment, shift: Array, turn: Array, free: int) -> Alignment:
    from scipy.spatial.transform import Rotation  # slow to import

    further = Rotation.from_rotvec(turn).as_matrix()
    return Alignment(
        "best fit", further @ alignment.rotation, further @ alignment.shift_mm + shift, alignment.centre_mm, free
    )
