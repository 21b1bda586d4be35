"""Shafts of a forward model of its own: cylinders, a cone, faces and arcs with errors by powers and cosines."""

from dataclasses import dataclass

import numpy as np

from tests.support.cut_places import CYLINDER, FACE, places
from trueloop.arrays import Array
from trueloop.estimate.places import Places

NOISE_UM = 1.2
CONE = np.arctan2(25.0, 3.0)
FEATURES = (
    (CYLINDER, CYLINDER, 23.0, (-80.0, -64.0), 4),
    (FACE, FACE, 21.0, (-64.0, -64.0), 3),
    (0.04, 1.53, 17.0, (-64.0, -60.0), 8),
    (CYLINDER, CYLINDER, 15.0, (-60.0, -50.0), 6),
    (CYLINDER, CYLINDER, 15.0, (-50.0, -45.0), 3),
    (CONE, CONE, 13.5, (-45.0, -20.0), 6),
    (CYLINDER, CYLINDER, 12.0, (-20.0, -3.0), 4),
    (CYLINDER, FACE, 10.5, (-3.0, 0.0), 6),
    (FACE, FACE, 4.5, (0.0, 0.0), 3),
)
"""Contact angles from and to, a radius, z from and to, touches."""


@dataclass(frozen=True)
class Shaft:
    """Where a shaft is touched, what touches of the semi-finish and of the uncorrected finish cut read, µm."""

    contact_angle_rad: Array
    z_mm: Array
    share: Array
    group: np.ndarray
    semifinish_um: Array
    finish_um: Array

    @classmethod
    def drawn(cls, seed: int) -> "Shaft":
        """One of them."""
        rng = np.random.default_rng(seed)
        angle, radius, z, share, group = (np.concatenate(column) for column in zip(*_columns(), strict=True))
        n_x, n_z, middle = np.sin(angle), np.cos(angle), z + 40
        worn = sum(size * rng.normal() * np.cos((2 + 2 * j) * angle) for j, size in enumerate((3, 2, 1.5, 1)))
        error = rng.normal(0, 15) * n_x + rng.normal(0, 10) * n_z + worn
        error += (rng.normal(0, 0.08) * middle + rng.normal(0, 3) * (middle / 40) ** 2) * n_x
        error += rng.normal(0, 0.15) * (radius - 12) * np.abs(n_z) + rng.normal(0, 1, len(FEATURES))[group]
        finish = error + rng.normal(0, 1.5) * n_x + rng.normal() * (n_z + np.cos(3 * angle + rng.uniform(0, 6)))
        read = [one + rng.normal(0, NOISE_UM, len(angle)) for one in (error, finish)]
        return cls(angle, z, share, group, *read)

    def places(self, finish: bool) -> Places:
        """All places that are touched."""
        return places(self.contact_angle_rad, self.z_mm + 40, self.share, self.group, finish=finish)

    @property
    def diameters(self) -> np.ndarray:
        """Places on cylinders that a micrometer reaches."""
        return np.array([0, 3, 15, 21, 30, 33])


def _columns() -> list[tuple[np.ndarray, ...]]:
    found = list[tuple[np.ndarray, ...]]()
    for k, (start, end, radius, (z_from, z_to), count) in enumerate(FEATURES):
        u = (np.arange(count) + 0.5) / count
        angle = start + (end - start) * u
        found.append((angle, np.full(count, radius), z_from + (z_to - z_from) * u, u, np.full(count, k)))
    return found
