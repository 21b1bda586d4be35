"""What the cutting process does to the nose: it springs away, and it does not repeat."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.simulator.path import CentrePath
from trueloop.simulator.stock import Stock

STATION_MM: Final = 0.5
"""Forces are reckoned this far apart along the path and run straight between."""

DEEPEST_CUT_MM: Final = 5.0


@dataclass(frozen=True)
class Repeatability:
    """Random errors of the process, standard deviations in mm.

    `along_mm` varies along the cut like a Gaussian process of correlation length `correlation_mm` (correlation
    exp(−d²/2ℓ²)), normal to the path; `cut_to_cut_mm` moves a whole cut, on x and z each. No chatter: nothing here
    is of a wavelength that the nose would fill.
    """

    along_mm: float = 0.0
    correlation_mm: float = 2.0
    cut_to_cut_mm: float = 0.0

    def displacement_mm(self, path: CentrePath, cut_mm: Array, rng: np.random.Generator) -> Array:
        """One cut's displacement of the nose centre, (n, 2); `cut_mm` (2,) is what moves the whole cut."""
        moved: Array = np.broadcast_to(cut_mm, path.centre_mm.shape)
        if self.along_mm > 0.0:
            moved = (
                moved
                + self.along_mm * _gaussian_process(path.along_mm, self.correlation_mm, rng)[:, None] * path.normal
            )
        return moved

    def draw_cut_mm(self, rng: np.random.Generator) -> Array:
        """What moves one whole cut, (2,)."""
        return self.cut_to_cut_mm * rng.standard_normal(2)


@dataclass(frozen=True)
class Deflection:
    """How tool and part give way.

    The force normal to the contour is `specific_force_n_per_mm2` × depth of cut × feed (the radial part of the specific
    cutting force). It moves the tool by `tool_mm_per_n` along the normal, and the part by its compliance along x:
    `chuck_mm_per_n` + `part_mm_per_n_mm3` · (z − z_chuck)³ (a cantilever: 1/(3EI)). Valid for small deflections of a
    part of one diameter; the depth of cut is that which remains when all has given way.
    """

    specific_force_n_per_mm2: float = 0.0
    tool_mm_per_n: float = 0.0
    chuck_mm_per_n: float = 0.0
    part_mm_per_n_mm3: float = 0.0
    chuck_z_mm: float = 0.0
    feed_mm_per_rev: float = 0.127

    @property
    def rigid(self) -> bool:
        """Whether nothing gives way."""
        return self.specific_force_n_per_mm2 == 0.0

    def displacement_mm(self, path: CentrePath, contact_mm: Array, stock: Stock) -> Array:
        """Displacement of the nose relative to the part, (n, 2), cutting what `stock` has above the contact line.

        `contact_mm` (n, 2) is where the nose would cut if nothing gave way.
        """
        count = max(2, math.ceil(path.along_mm[-1] / STATION_MM))
        at = np.linspace(0.0, path.along_mm[-1], count)
        nearest = np.unique(np.minimum(np.searchsorted(path.along_mm, at), len(path.along_mm) - 1))
        contact, normal = contact_mm[nearest], path.normal[nearest]
        depth = np.clip(stock.height_mm(contact, normal, DEEPEST_CUT_MM), 0.0, None)
        depth = np.where(depth >= DEEPEST_CUT_MM, 0.0, depth)
        feed = np.where(np.isnan(path.feed_mm_per_rev), self.feed_mm_per_rev, path.feed_mm_per_rev)[nearest]
        stiffness = self.specific_force_n_per_mm2 * feed
        on_x = self.chuck_mm_per_n + self.part_mm_per_n_mm3 * np.clip(contact[:, 1] - self.chuck_z_mm, 0.0, None) ** 3
        yielding = self.tool_mm_per_n + on_x * normal[:, 0] ** 2
        force = stiffness * depth / (1.0 + stiffness * yielding)
        part = np.column_stack([on_x * normal[:, 0], np.zeros(len(nearest))])
        away = force[:, None] * (self.tool_mm_per_n * normal + part)
        return np.column_stack([np.interp(path.along_mm, path.along_mm[nearest], away[:, k]) for k in range(2)])


@dataclass(frozen=True)
class Backlash:
    """Play of each axis in mm: the slide follows its drive within ± half of it, and stays where it was pushed to."""

    x_mm: float = 0.0
    z_mm: float = 0.0

    def follow(self, commanded_mm: Array) -> Array:
        """Where the slide is, (n, 2), when it is driven through these positions from the first on."""
        actual = np.array(commanded_mm, dtype=np.float64)
        for axis, play in enumerate((self.x_mm, self.z_mm)):
            if play > 0.0:
                actual[:, axis] = _follow(commanded_mm[:, axis], play / 2)
        return actual


def _follow(driven: Array, half: float) -> Array:
    at, found = float(driven[0]), np.empty_like(driven)
    for k, position in enumerate(driven.tolist()):
        at = min(max(at, position - half), position + half)
        found[k] = at
    return found


def _gaussian_process(along: Array, correlation: float, rng: np.random.Generator) -> Array:
    """Unit variance, correlation exp(−d²/2ℓ²): white noise on a grid of ℓ/4, weighted by a Gaussian of width ℓ/√2."""
    step = correlation / 4
    margin = 16
    count = math.ceil(along[-1] / step) + 2 * margin + 2
    offsets = np.arange(-margin, margin + 1) * step
    weights = np.exp(-((offsets / correlation) ** 2))
    weights /= np.linalg.norm(weights)
    smooth = np.convolve(rng.standard_normal(count), weights, mode="same")
    from scipy.interpolate import CubicSpline  # only a process that does not repeat needs it

    values: Array = CubicSpline(step * (np.arange(count) - margin), smooth)(along)
    return values
