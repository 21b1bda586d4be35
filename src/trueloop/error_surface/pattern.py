"""The machining pattern model: what a process leaves on every part, and how surely that is known.

The mean of the parts' deterministic models [MPM §6], all of one size: one that is adequate for every part, and for the
mean of all parts' deviations too. That mean scatters less than any part by √s, and shows what no single part shows.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.error_surface.outlier import Outlier, outliers
from trueloop.error_surface.separate import Separation, of_size, separate
from trueloop.error_surface.spline_surface import Size, SplineSurface, basis
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.units import UM_PER_MM

LEAST_PARTS: Final = 3
"""Two parts do not tell which of them is odd, nor how much parts differ."""
COVERAGE: Final = 0.95


@dataclass(frozen=True, eq=False)
class Pattern:
    """A machining pattern model. `mean` is the pattern; `models` (one a part) are what it was averaged from.

    `names` tells the parts; `sigma_mm` is the scatter of the random part of one touch, pooled; `outlying` are parts
    that do not belong to the process: they are named, not left out.
    """

    size: Size
    names: tuple[str, ...]
    models: tuple[SplineSurface, ...]
    mean: SplineSurface
    sigma_mm: float
    outlying: tuple[Outlier, ...]
    findings: tuple[Finding, ...]

    @property
    def parts(self) -> int:
        """Number of parts."""
        return len(self.models)

    def scatter_grid_mm(self, u: Array, v: Array) -> Array:
        """Standard deviation of the parts' models at every u with every v: that of the parts and that of the fits."""
        stack = np.stack([model.grid_mm(u, v) for model in self.models])
        return np.asarray(np.std(stack, axis=0, ddof=1))

    def uncertainty_grid_mm(self, u: Array, v: Array, coverage: float = COVERAGE) -> Array:
        """Half-width of the interval that holds the true pattern with that probability: t₍ₛ₋₁₎ · scatter/√s."""
        return np.asarray(self.scatter_grid_mm(u, v) * student(coverage, self.parts - 1) / np.sqrt(self.parts))

    def next_part_grid_mm(self, u: Array, v: Array, coverage: float = COVERAGE) -> Array:
        """Half-width for the deterministic deviation that a next part keeps after correction by the pattern."""
        return np.asarray(self.scatter_grid_mm(u, v) * student(coverage, self.parts - 1) * np.sqrt(1 + 1 / self.parts))

    def variability_grid_mm(self, u: Array, v: Array, fit_variance_mm2: Array | float = 0.0) -> Array:
        """Standard deviation between parts, the variance of the fits taken off: the process's own variability."""
        return np.asarray(np.sqrt(np.maximum(self.scatter_grid_mm(u, v) ** 2 - fit_variance_mm2, 0.0)))


def pattern_of(
    parts: Sequence[Separation], names: Sequence[str], *, size: Size | None = None, confidence: float = 0.99
) -> Pattern:
    """The pattern of s parts measured at corresponding places.

    Every part is modelled anew with the largest size that any part, or the mean of parts measured at the same places,
    needs (or with `size`), so that the mean of control values is the mean of the surfaces. Raises SRF-PARTS for fewer
    than three parts.
    """
    if len(parts) < LEAST_PARTS:
        raise TrueloopError(
            Code.SRF_PARTS,
            f"{len(parts)} parts ({', '.join(map(repr, names)) or 'none'}) make no pattern; {LEAST_PARTS} are the "
            f"least, 10 were used in the published experiment",
            hint="measure more parts, or correct by one part's model and know that the next part differs from it",
        )
    size = size or common_size([*parts, *_mean_part(parts, confidence)])
    again = [part if part.chosen.size == size else of_size(part.places, part.measured_mm, size) for part in parts]
    models = tuple(part.deterministic for part in again)
    mean = SplineSurface(size, np.mean([model.coefficients_mm for model in models], axis=0))
    sigma = float(np.sqrt(np.mean([part.sigma_mm**2 for part in again])))
    odd = outliers(models, names, confidence)
    return Pattern(size, tuple(names), models, mean, sigma, odd, tuple(_told(o) for o in odd))


def common_size(parts: Sequence[Separation]) -> Size:
    """The smallest size that is at least as large as every part needs, along both directions."""
    chosen = [part.chosen.size for part in parts]
    return Size(*(max(getattr(size, name) for size in chosen) for name in ("rows", "columns", "degree")))


def _mean_part(parts: Sequence[Separation], confidence: float) -> list[Separation]:
    """The mean of all parts as a part of its own, where they were measured at the same places."""
    first = parts[0]
    if first.places.rows is None or any(part.near is not first.near for part in parts):
        return []
    degrees = (max(part.chosen.size.degree for part in parts),)
    mean = np.mean([part.measured_mm for part in parts], axis=0)
    return [separate(first.places, mean, near=first.near, confidence=confidence, degrees=degrees)]


def fit_variance_mm2(part: Separation, u: Array, v: Array) -> Array:
    """Variance that the random part gives a part's model at every u with every v, on a full grid of touches."""
    rows, columns, size = part.places.rows, part.places.columns, part.deterministic.size
    if rows is None or columns is None:
        raise TrueloopError(
            Code.SRF_GRID, f"the {len(part.places.u)} places are scattered, not a grid", hint="measure along a grid"
        )
    along, across = (
        np.einsum("ai,ij,aj->a", b, np.linalg.inv(d.T @ d), b)
        for b, d in ((basis(size, 0, u), basis(size, 0, rows)), (basis(size, 1, v), basis(size, 1, columns)))
    )
    return np.asarray(part.sigma_mm**2 * np.outer(along, across))


def parts_needed(pattern: Pattern, target_mm: float, coverage: float = COVERAGE) -> int:
    """How many parts make the pattern's uncertainty at most `target_mm` on average over the surface.

    From the scatter seen so far: the smallest s with t₍ₛ₋₁₎ · scatter/√s ≤ target. Raises SRF-PARTS for a target that
    is not positive or needs more than 100 000 parts.
    """
    at = np.linspace(0.0, 1.0, 41)
    scatter = float(np.sqrt(np.mean(pattern.scatter_grid_mm(at, at) ** 2)))
    few, many = 2, 100_000
    if not target_mm > 0 or student(coverage, many - 1) * scatter / np.sqrt(many) > target_mm:
        raise TrueloopError(
            Code.SRF_PARTS,
            f"an uncertainty of {target_mm * UM_PER_MM:g} µm cannot be had from parts that scatter by "
            f"{scatter * UM_PER_MM:.2f} µm",
            hint="aim at an uncertainty that is not far below the scatter between parts",
        )
    while few < many:
        middle = (few + many) // 2
        enough = student(coverage, middle - 1) * scatter / np.sqrt(middle) <= target_mm
        few, many = (few, middle) if enough else (middle + 1, many)
    return few


def student(coverage: float, freedom: int) -> float:
    """Two-sided factor of Student's t."""
    from scipy.special import stdtrit  # slow to import

    return float(stdtrit(freedom, 0.5 + coverage / 2))


def _told(odd: Outlier) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.SRF_OUTLIER,
        f"part {odd.name!r} differs from the mean of the others by {odd.off_mm * UM_PER_MM:.2f} µm rms, "
        f"{odd.times:.1f} times as much as parts do (p {odd.p_value:.2g})",
        "look at its clamping, tool and measurement; leave it out of the pattern if there is a cause",
    )
