"""The cutting process: deflection of tool and part, random errors, lost motion, and the surface that cuts leave."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.surface.separation.spline_surface import Size, SplineSurface
from trueloop_lab.simulator.nose import CentrePath, Nose

REACH_MM: Final = 1.0
"""The distance from a nominal point within which the surface is sought, either way: below a wall, above any error."""


def sweep(centre_mm: Array, nose: Nose) -> NoseSweep:
    """Returns the sweep of a nose along positions of its centre (n, 2)."""
    return NoseSweep(np.ascontiguousarray(centre_mm), nose.radius_mm, nose.first_rad, nose.step_rad, nose.pieces)


@dataclass(frozen=True)
class Stock:
    """An endless bar less the swept regions of all cuts so far. x is a radius."""

    sweeps: tuple[NoseSweep, ...] = ()

    def cut_by(self, sweeps: Iterable[NoseSweep]) -> "Stock":
        """Returns the stock after further cuts."""
        return Stock((*self.sweeps, *sweeps))

    def height_mm(self, points_mm: Array, direction: Array, reach_mm: float = REACH_MM) -> Array:
        """Returns where a line through each point (n, 2) along its unit direction (n, 2) leaves the material, (n,).

        Measured from the point, positive outside; +reach where nothing was cut away within reach. It is the true
        surface: no error terms are added up, no curvature is neglected.
        """
        height = np.full(len(points_mm), reach_mm)
        origins, directions = np.ascontiguousarray(points_mm), np.ascontiguousarray(direction)
        for swept in reversed(self.sweeps):  # the last cut is nearly everywhere the lowest: the others soon give up
            height = swept.entries(origins, directions, height, reach_mm)
        return height


EXTREME_OF_625: Final = 3.08
"""Expected largest of 625 standard normal values: what a published ± of 625 residuals means in standard deviations."""

LEAST_MM: Final = 0.0024
MOST_MM: Final = 0.0043
EXTREME_MM: Final = 0.0065
"""Published limits [MPM §8]: of the variability between parts, and of the random part."""

FREQUENCIES: Final = (1.0, 2.5, 4.0)
"""Frequencies of the waves by which parts differ, in radians over a side."""
WAVES: Final = 2 * len(FREQUENCIES)


@dataclass(frozen=True, eq=False)
class SurfaceProcess:
    """`pattern` is what every part gets. Parts differ from it by smooth surfaces, whose standard deviation over parts
    grows from `least_mm` in the middle to `most_mm` at the edges; `noise_mm` is that of one touch.
    """

    pattern: SplineSurface
    least_mm: float
    most_mm: float
    noise_mm: float

    def variation(self, rng: np.random.Generator) -> "Variation":
        """Draws a part's difference from the pattern: normal weights for every wave along u times every one along v."""
        return Variation(self.least_mm, self.most_mm, rng.normal(size=(WAVES, WAVES)))


@dataclass(frozen=True, eq=False)
class Variation:
    """A smooth surface over [0, 1] × [0, 1] in mm: waves whose size grows from the middle to the edges.

    `weights` (6, 6): of each wave along u with each along v. The squares of either direction's waves add up to one
    everywhere: weights that are drawn independently with unit variance make that size the standard deviation.
    """

    least_mm: float
    most_mm: float
    weights: Array

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""
        return self._scaled(u, v, np.sum((_harmonics(u) @ self.weights) * _harmonics(v), axis=1))

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""
        return self._scaled(u[:, None], v[None, :], _harmonics(u) @ self.weights @ _harmonics(v).T)

    def _scaled(self, u: Array, v: Array, field: Array) -> Array:
        edge = np.maximum(np.abs(2 * u - 1), np.abs(2 * v - 1))
        return np.asarray((self.least_mm + (self.most_mm - self.least_mm) * edge) * field)


def published_process(rng: np.random.Generator, pattern_mm: float = 0.008, controls: int = 9) -> SurfaceProcess:
    """Returns a process of the size of [MPM §8]: variability between parts ±2.4 to ±4.3 µm, random part within ±6.5 µm.

    The extremes are read as three standard deviations for the few parts' models, and as the largest of 625 values for
    the random part. The pattern itself is drawn, its control values with the given standard deviation.
    """
    pattern = SplineSurface(Size(controls, controls), rng.normal(0.0, pattern_mm, (controls, controls)))
    return SurfaceProcess(pattern, LEAST_MM / 3, MOST_MM / 3, EXTREME_MM / EXTREME_OF_625)


def _harmonics(at: Array) -> Array:
    """Six smooth functions whose squares add up to one everywhere: a field of them varies alike in all places."""
    waves = [wave(w * at) for w in FREQUENCIES for wave in (np.cos, np.sin)]
    return np.asarray(np.stack(waves, axis=1) / np.sqrt(len(FREQUENCIES)))


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
        """Draws one cut's displacement of the nose centre, (n, 2); `cut_mm` (2,) is that of the whole cut."""
        moved: Array = np.broadcast_to(cut_mm, path.centre_mm.shape)
        if self.along_mm > 0.0:
            moved = (
                moved
                + self.along_mm * _gaussian_process(path.along_mm, self.correlation_mm, rng)[:, None] * path.normal
            )
        return moved

    def draw_cut_mm(self, rng: np.random.Generator) -> Array:
        """Draws the displacement of one whole cut, (2,)."""
        return self.cut_to_cut_mm * rng.standard_normal(2)


@dataclass(frozen=True)
class Deflection:
    """The deflection of tool and part under the cutting force.

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
        """Returns whether nothing gives way."""
        return self.specific_force_n_per_mm2 == 0.0

    def displacement_mm(self, path: CentrePath, contact_mm: Array, stock: Stock) -> Array:
        """Returns the displacement of the nose relative to the part, (n, 2), cutting the stock above the contact line.

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
        """Returns the slide's positions, (n, 2), when it is driven through these positions from the first on."""
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
