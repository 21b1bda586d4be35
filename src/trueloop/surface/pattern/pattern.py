"""The machining pattern model: what a process leaves on every part, and how surely that is known.

The mean of the parts' deterministic models [MPM §6], all of one size. Models of one size at the same places average to
the model of the mean deviations, so it is the mean that says which size the pattern needs: it scatters less than any
part by √s, and shows what no single part shows. The largest of the parts' own sizes would be one too large by chance in
many a pattern, and splines of a larger size cannot follow those of a smaller one exactly.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Finding, Severity
from trueloop.statistics import rms
from trueloop.surface.pattern.field import FaceField
from trueloop.surface.pattern.support import Support, between, faded
from trueloop.surface.separation.separate import COVERAGE, MANY, Separation, of_size, separate, student
from trueloop.surface.separation.spline_surface import Places, Size, SplineSurface, projector
from trueloop.units import UM_PER_MM

LEAST_OTHERS = 3
"""Fewer do not determine how much parts differ."""
PLACES = 31
"""Places a side that parts are compared at: closer together than control points, of which a pattern has hardly 25."""


@dataclass(frozen=True)
class Outlier:
    """A part with its root mean square distance from the mean of the others, how many times that of the others it is,
    and the probability of so much by chance, among so many parts.
    """

    name: str
    off_mm: float
    times: float
    p_value: float


def on_square(models: Sequence[SplineSurface]) -> Array:
    """Values of splines on a square of places, (s, n)."""
    at = np.linspace(0.0, 1.0, PLACES)
    return np.stack([model.grid_mm(at, at).ravel() for model in models])


def outliers(stack: Array, names: Sequence[str], confidence: float = 0.99) -> tuple[Outlier, ...]:
    """Parts that stand out, each judged against the others.

    The squared distance of a part from the mean of the others, over the variance among those, follows F with ν and
    (s − 2) ν degrees of freedom, where ν counts the independent shapes in which parts differ (Satterthwaite, from the
    eigenvalues of their differences). The limit is shared among the s parts (Bonferroni). `stack`: (s, n), as
    `on_square` has it.
    """
    found = [_judged(stack, k, names[k], len(stack)) for k in range(len(stack))] if len(stack) > LEAST_OTHERS else []
    return tuple(odd for odd in found if odd.p_value < 1.0 - confidence)


def last_judged(stack: Array, name: str) -> Outlier | None:
    """The last part against those before it, by the same test, of one part; None where fewer than three are before."""
    return _judged(stack, len(stack) - 1, name, 1) if len(stack) > LEAST_OTHERS else None


def _judged(stack: Array, k: int, name: str, tests: int) -> Outlier:
    from scipy.special import fdtrc  # slow to import

    others = np.delete(stack, k, axis=0)
    s = len(others)
    differences = others - np.mean(others, axis=0)
    gram = differences @ differences.T / stack.shape[1]
    variance = float(np.trace(gram)) / (s - 1)
    off = float(np.mean((stack[k] - np.mean(others, axis=0)) ** 2))
    if variance <= 0.0:
        return Outlier(name, off**0.5, float("inf") if off else 1.0, 0.0 if off else 1.0)
    shapes = shapes_of(gram, s - 1)
    ratio = off / (variance * (1 + 1 / s))
    return Outlier(name, off**0.5, ratio**0.5, min(1.0, tests * float(fdtrc(shapes, (s - 1) * shapes, ratio))))


def shapes_of(gram: Array, freedom: int) -> float:
    """ν = (tr Σ)²/tr Σ², with the bias of tr S² from few parts taken off: E tr S² = (1 + 1/f) tr Σ² + (tr Σ)²/f.

    Few parts tell ν badly, and too large a ν cries wolf: it is lowered by 1 + 4/f, which keeps false alarms at one to
    two in a hundred patterns of 5 to 10 parts, for differences of few shapes or many (simulated in the tests).
    """
    trace, square = float(np.trace(gram)) / freedom, float(np.sum(gram**2)) / freedom**2
    unbiased = freedom**2 / ((freedom - 1) * (freedom + 2)) * (square - trace**2 / freedom)
    many = trace**2 / unbiased if unbiased > 1e-4 * trace**2 else 1e4
    return float(max(1.0, many / (1 + 4 / freedom)))


DRIFT_LEAST_PARTS = 5
"""Fewer do not distinguish a trend from how parts differ."""


@dataclass(frozen=True)
class Drift:
    """How much the pattern changes a part, root mean square over the surface, and the probability of that by chance."""

    per_part_mm: float
    p_value: float


def drift_of(models: Sequence[SplineSurface]) -> Drift | None:
    """The trend b of s parts' models m_k in cutting order, m_k = m̄ + b·(k − k̄); None for fewer than five parts.

    By least squares b = Σ(k − k̄) m_k / Σ(k − k̄)². Its mean square times Σ(k − k̄)², over the variance of what it
    leaves, follows F with ν and (s − 2) ν degrees of freedom where nothing changes; ν counts the shapes in which parts
    differ, as for outlying parts (`outlier`). A single outlying part near either end looks like a trend: leave it out
    first.
    """
    from scipy.special import fdtrc  # slow to import

    s = len(models)
    if s < DRIFT_LEAST_PARTS:
        return None
    stack = on_square(models)
    off = stack - np.mean(stack, axis=0)
    order = np.arange(s) - (s - 1) / 2
    squares = float(order @ order)
    trend = order @ off / squares
    left = off - np.outer(order, trend)
    gram = left @ left.T / stack.shape[1]
    variance, changed = float(np.trace(gram)) / (s - 2), float(np.mean(trend**2)) * squares
    if variance <= 0.0:
        return Drift(float(np.sqrt(np.mean(trend**2))), 0.0 if changed > 0.0 else 1.0)
    shapes = shapes_of(gram, s - 2)
    p_value = float(fdtrc(shapes, (s - 2) * shapes, changed / variance))
    return Drift(float(np.sqrt(np.mean(trend**2))), p_value)


def by_chance(models: Sequence[SplineSurface], inside: Flags) -> float:
    """Returns the probability that s parts without a pattern, which differ as these do, have as large a mean as theirs.

    s times the mean square of the mean, over the variance between parts, follows F with ν and (s − 1) ν degrees of
    freedom; ν counts the shapes in which parts differ, as for outlying parts: few where set-ups make them differ.
    `inside`: which places of `on_square` are on the face.
    """
    from scipy.special import fdtrc  # slow to import

    stack = on_square(models)
    stack = stack[:, inside] if np.any(inside) else stack
    s, mean = len(stack), np.mean(stack, axis=0)
    off = stack - mean
    gram = off @ off.T / stack.shape[1]
    variance, square = float(np.trace(gram)) / (s - 1), float(np.mean(mean**2))
    if variance <= 0.0:
        return 0.0 if square > 0.0 else 1.0
    shapes = shapes_of(gram, s - 1)
    return float(fdtrc(shapes, (s - 1) * shapes, s * square / variance))


LEAST_PARTS: Final = 3
"""Two parts do not show which of them is odd, nor how much parts differ: that is then assumed."""
ABOVE_ZERO: Final = 1 / np.sqrt(2 * np.pi)
"""Mean of max(x, 0) for a standard normal x: what a variance that is none seems to be, in standard deviations."""
SIDE: Final = 41
"""Places a side that figures of the whole surface are made of."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """A machining pattern model. `mean` is the pattern; `models` (one a part) are what it was averaged from. `size` is
    that of the parts' splines; where points do not support these, `support` says how far the pattern is known, and
    `mean` and `models` fade to none there, as splines of a finer size.

    `own_mm` is how much a part's form differs from the pattern, one standard deviation, where too few parts show it:
    then it is assumed, `mean` and `models` are shrunk by it, and `support` alone says how far the pattern is known.

    `names` tells the parts; `sigma_mm` is the scatter of the random part of one touch, pooled; `missed_mm` is the root
    mean square of what all parts have alike and this size does not follow (0 where the parts were not measured at the
    same places: then it is not known); `outlying` are parts that do not belong to the process: named, not left out.
    """

    size: Size
    names: tuple[str, ...]
    models: tuple[SplineSurface, ...]
    mean: SplineSurface
    sigma_mm: float
    missed_mm: float
    outlying: tuple[Outlier, ...]
    findings: tuple[Finding, ...]
    support: Support | None = None
    own_mm: float | None = None

    @property
    def parts(self) -> int:
        """Returns the number of parts."""
        return len(self.models)

    @property
    def of_parts(self) -> str:
        """Returns the number of parts with its noun."""
        return "1 part" if self.parts == 1 else f"{self.parts} parts"

    def scatter_grid_mm(self, u: Array, v: Array) -> Array:
        """Standard deviation of the parts' models at every u with every v: that of the parts and that of the fits."""
        if self.own_mm is not None:
            return np.full((len(u), len(v)), self.own_mm)
        stack = np.stack([model.grid_mm(u, v) for model in self.models])
        return np.asarray(np.std(stack, axis=0, ddof=1))

    def uncertainty_grid_mm(self, u: Array, v: Array, coverage: float = COVERAGE) -> Array:
        """Half-width of the interval that holds the true pattern with that probability, at every u with every v."""
        wide = np.repeat(u, len(v)), np.tile(v, len(u))
        return self.uncertainty_mm(self.scatter_grid_mm(u, v).ravel(), *wide, coverage).reshape(len(u), len(v))

    def uncertainty_mm(self, scatter_mm: Array, u: Array, v: Array, coverage: float = COVERAGE) -> Array:
        """Returns the uncertainty at pairs of parameters (n,) where the parts' models scatter by `scatter_mm` (n,).

        t₍ₛ₋₁₎ · scatter/√s for what scatters, and in squares the normal law's share of `missed_mm` and of what no point
        supports. A part without points at a place counts there as one that scatters as parts do on the whole.
        """
        if self.support is not None and self.own_mm is not None:
            return np.asarray(student(coverage, MANY) * between(self.support.deviation_mm, u, v))
        known, beyond = np.full(len(u), float(self.parts)), np.zeros(len(u))
        if self.support is not None:
            known, beyond = between(self.support.parts, u, v), between(self.support.deviation_mm, u, v)
        unseen = (self.parts - known) / (self.parts - 1) * self._pooled_mm**2
        scattered = np.sqrt((scatter_mm**2 + unseen) / known) * student(coverage, self.parts - 1)
        return np.asarray(np.hypot(scattered, student(coverage, MANY) * np.hypot(self.missed_mm, beyond)))

    def next_part_grid_mm(self, u: Array, v: Array, coverage: float = COVERAGE) -> Array:
        """Half-width for the deterministic deviation that a next part keeps after correction by the pattern."""
        seen = self.own_mm is None
        factor = student(coverage, self.parts - 1) * np.sqrt(1 + 1 / self.parts) if seen else student(coverage, MANY)
        kept = self.scatter_grid_mm(u, v) * factor
        if self.support is None:
            return np.asarray(kept)
        wide = np.repeat(u, len(v)), np.tile(v, len(u))
        beyond = between(self.support.deviation_mm, *wide).reshape(kept.shape)
        return np.asarray(np.hypot(kept, student(coverage, MANY) * beyond))

    @cached_property
    def _pooled_mm(self) -> float:
        """Scatter of the parts' models on the whole."""
        at = np.linspace(0.0, 1.0, SIDE)
        return rms(self.scatter_grid_mm(at, at))


def pattern_of(
    parts: Sequence[Separation],
    names: Sequence[str],
    *,
    size: Size | None = None,
    confidence: float = 0.99,
    field: FaceField | None = None,
) -> Pattern:
    """The pattern of s parts measured at corresponding places.

    Every part is modelled anew with the likeliest size of the mean of all parts; where they were measured at different
    places, with the largest that any part needs; or with `size`. With a `field` the models are those of the field, as
    it takes for fewer than `LEAST_PARTS` parts.
    """
    size = size or common_size(_mean_part(parts) or parts)
    again = [
        part if part.chosen.size == size else of_size(part.places, part.measured_mm, size, part.near) for part in parts
    ]
    models, support = tuple(part.deterministic for part in again), None
    if field is not None:
        models, support = field.models, field.support
    elif (supported := faded(again)) is not None:
        models, support = supported
    mean = SplineSurface(models[0].size, np.mean([model.coefficients_mm for model in models], axis=0))
    sigma = rms(np.array([part.sigma_mm for part in again]))
    odd = outliers(on_square(models), names, confidence)
    findings = tuple(_finding(o) for o in odd)
    return Pattern(
        size=size,
        names=tuple(names),
        models=models,
        mean=mean,
        sigma_mm=sigma,
        missed_mm=_missed_mm(again),
        outlying=odd,
        findings=findings,
        support=support,
        own_mm=None if field is None else field.own_mm,
    )


def common_size(parts: Sequence[Separation]) -> Size:
    """The smallest size that is at least as large as every part needs, along both directions."""
    chosen = [part.chosen.size for part in parts]
    return Size(*(max(getattr(size, name) for size in chosen) for name in ("rows", "columns", "degree")))


def _mean_part(parts: Sequence[Separation]) -> list[Separation]:
    """The mean of all parts as a part of its own, where they were measured at the same places.

    Its size is the likeliest: tests that are right 99 times in 100 would refuse one good series of a hundred.
    """
    if not _comparable(parts):
        return []
    mean = np.mean([part.measured_mm for part in parts], axis=0)
    return [separate(parts[0].places, mean, near=parts[0].near, name="mean of all parts")]


def _missed_mm(parts: Sequence[Separation]) -> float:
    """Returns the residuals' common part: the mean square of their mean, less what their scatter gives it."""
    if len(parts) < LEAST_PARTS or not _comparable(parts):
        return 0.0
    residuals = np.stack([part.random_mm for part in parts])
    by_chance = float(np.mean(np.var(residuals, axis=0, ddof=1))) / len(parts)
    by_chance *= 1 + ABOVE_ZERO * np.sqrt(2 / residuals.shape[1])
    return float(np.sqrt(max(0.0, float(np.mean(np.mean(residuals, axis=0) ** 2)) - by_chance)))


def _comparable(parts: Sequence[Separation]) -> bool:
    """Returns whether all parts were measured at the same places."""
    return all(part.near is parts[0].near for part in parts)


def parts_needed(pattern: Pattern, target_mm: float, coverage: float = COVERAGE) -> int:
    """How many parts make the pattern's uncertainty at most `target_mm` on average over the surface.

    From the scatter seen so far: the smallest s with t₍ₛ₋₁₎ · scatter/√s ≤ target. Raises SRF-PARTS for a target that
    is not positive or needs more than 100 000 parts.
    """
    at = np.linspace(0.0, 1.0, SIDE)
    scatter = rms(pattern.scatter_grid_mm(at, at))
    few, many = 2, MANY
    if not target_mm > 0 or student(coverage, many - 1) * scatter / np.sqrt(many) > target_mm:
        raise Code.SRF_PARTS.refusal(
            f"an uncertainty of {target_mm * UM_PER_MM:g} µm cannot be had from parts that scatter by "
            f"{scatter * UM_PER_MM:.2f} µm",
            hint="aim at an uncertainty that is not far below the scatter between parts",
        )
    while few < many:
        middle = (few + many) // 2
        enough = student(coverage, middle - 1) * scatter / np.sqrt(middle) <= target_mm
        few, many = (few, middle) if enough else (middle + 1, many)
    return few


def _finding(odd: Outlier) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.SRF_OUTLIER,
        f"part {odd.name!r} differs from the mean of the others by {odd.off_mm * UM_PER_MM:.2f} µm rms, "
        f"{odd.times:.1f} times as much as parts do (p {odd.p_value:.2g})",
        "look at its clamping, tool and measurement, and which program cut it: a part of a corrected one does not "
        f"belong here; it counts: if there is a cause, model.exclude = [{odd.name!r}] in the job leaves it out",
        values={"p_value": odd.p_value},
    )


@dataclass(frozen=True, eq=False)
class PartMaps:
    """Values in mm at the places of one part, each (n,).

    `predicted_mm` is what this part would have kept, corrected by the pattern of the *other* parts: a part that is
    among those averaged would look better than a next one will; with a single part there is no other, and the pattern
    is its own. `variability_mm` is the standard deviation between
    parts, the fits' own taken off; `uncertainty_mm` the half-width of the pattern's 95 % interval.
    """

    name: str
    places: Places
    measured_mm: Array
    deterministic_mm: Array
    random_mm: Array
    pattern_mm: Array
    predicted_mm: Array
    variability_mm: Array
    uncertainty_mm: Array


def part_maps(pattern: Pattern, apart: Separation, name: str, weight: float) -> PartMaps:
    """The maps of one of the pattern's parts, corrected by `weight` times a pattern."""
    u, v = apart.places.u, apart.places.v
    stack = np.stack([own.value_mm(u, v) for own in pattern.models])
    others = np.mean(np.delete(stack, pattern.names.index(name), axis=0), axis=0) if len(stack) > 1 else stack[0]
    scatter = np.std(stack, axis=0, ddof=1) if pattern.own_mm is None else np.full(len(u), pattern.own_mm)
    fits_own = pattern.sigma_mm**2 * projector(apart.places, pattern.size).leverages
    return PartMaps(
        name=name,
        places=apart.places,
        measured_mm=apart.measured_mm,
        deterministic_mm=apart.measured_mm - apart.random_mm,
        random_mm=apart.random_mm,
        pattern_mm=pattern.mean.value_mm(u, v),
        predicted_mm=apart.measured_mm - weight * others,
        variability_mm=np.sqrt(np.maximum(scatter**2 - fits_own, 0.0)) if pattern.own_mm is None else scatter,
        uncertainty_mm=pattern.uncertainty_mm(scatter, u, v),
    )
