"""Separates the deterministic and the random deviations of a part.

A least-squares spline surface follows what machining repeats; what it leaves should be normal and spatially random
[MPM §§4–6]. Its size is the one under which the deviations are most likely, or, as published, the first that leaves
residuals so: fewest control points first.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache, partial
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.separation.moran import Normality, Null, normality
from trueloop.surface.separation.neighbourhood import (
    Neighbourhood,
    expected_geary_c,
    permutation_p_value,
    residual_null,
)
from trueloop.surface.separation.spline_surface import (
    DEGREES,
    FULLEST,
    Places,
    Size,
    SplineSurface,
    climbed,
    most_likely,
    projector,
    regress,
    sizes,
    thinner,
)

FORM: Final = Size(3, 3, 2)
"""The polynomials that every size contains."""
LOG_RATIOS: Final = np.linspace(0.0, 18.0, 19)
"""Of the variance that c gives a mean shape to σ². Never below 1: a shape with less is better not followed at all by
least squares, which does not shrink. Up to e¹⁸, shapes of 8 mm over noise of 1 µm; steps of e, between which a
parabola finds the top.
"""
ROUNDING: Final = 1e-15
"""Rounding residual of values that a surface follows exactly, as a share of their squares."""


def log_likelihood(places: Places, values: Array, size: Size) -> float:
    """Restricted log likelihood of values (n,) at the places, up to a constant that all sizes share."""
    span = projector(places, size)
    both = span.coordinates(np.column_stack([_form(places), values]))
    form, inside = both[:, :-1], both[:, -1]
    whole = float(values @ values)
    outside = max(whole - float(inside @ inside), ROUNDING * whole, np.finfo(float).tiny)
    spread = span.spread / np.mean(span.spread)
    found = [_of_ratio(float(np.exp(log)), form, inside, outside, spread, len(values)) for log in LOG_RATIOS]
    return _top(np.array(found))


@lru_cache(maxsize=4)
def _form(places: Places) -> Array:
    return projector(places, FORM).columns


def _of_ratio(ratio: float, form: Array, inside: Array, outside: float, spread: Array, count: int) -> float:
    """The likelihood at one τ²/σ², with the best σ² for it."""
    swollen = 1.0 + ratio * spread
    weighted = form / swollen[:, None]
    normal = form.T @ weighted
    beta = np.linalg.solve(normal, weighted.T @ inside)
    left = outside + float(np.sum((inside - form @ beta) ** 2 / swollen))
    free = count - form.shape[1]
    return -0.5 * float(free * np.log(left / free) + np.sum(np.log(swollen)) + np.linalg.slogdet(normal)[1])


def _top(values: Array) -> float:
    """The top of a parabola through the largest of evenly spaced values and its neighbours."""
    k = int(np.clip(np.argmax(values), 1, len(values) - 2))
    before, middle, after = values[k - 1 : k + 2]
    bend = before - 2 * middle + after
    return float(max(values[k], middle - (after - before) ** 2 / (8 * bend)) if bend < 0 else np.max(values))


def averaged_over_cells(
    surface: Surface, deviations: SurfaceDeviations, cells: tuple[int, int]
) -> tuple[Places, Array]:
    """Mean errors over cells of equal parameters, at the cells' centres; empty cells are left out.

    A full grid stays a grid. The scatter of a cell's mean is that of its points over the root of their number, where
    those are independent; waves shorter than two cells are lost. Raises SRF-HOLES when a quarter of the cells is empty.
    """
    (u0, u1), (v0, v1) = surface.domain
    there = deviations.measured
    u, v = (deviations.u[there] - u0) / (u1 - u0), (deviations.v[there] - v0) / (v1 - v0)
    rows, columns = cells
    cell = np.minimum((u * rows).astype(int), rows - 1) * columns + np.minimum((v * columns).astype(int), columns - 1)
    count = np.bincount(cell, minlength=rows * columns)
    total = np.bincount(cell, deviations.error_mm[there], minlength=rows * columns)
    filled = count > 0
    if np.mean(filled) < 0.75:
        raise Code.SRF_HOLES.refusal(
            f"{np.count_nonzero(~filled)} of {rows} × {columns} cells hold no point of {deviations.name!r}",
            hint="take fewer cells: model.cells in the job",
            values={"part": deviations.name, "missing": int(np.count_nonzero(~filled))},
        )
    at_u, at_v = (np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns
    points = surface.grid_mm(u0 + (u1 - u0) * at_u, v0 + (v1 - v0) * at_v).reshape(-1, 3)
    everywhere = Places(points, np.repeat(at_u, columns), np.tile(at_v, rows), at_u, at_v)
    if np.all(filled):
        return everywhere, total / count
    return Places(points[filled], everywhere.u[filled], everywhere.v[filled]), total[filled] / count[filled]


CONFIDENCE: Final = 0.99
"""P of [MPM §8.2], for every test."""


@dataclass(frozen=True)
class Trial:
    """One size and what the tests say of its residuals."""

    size: Size
    moran_i: float
    null: Null
    moran_p: float
    normality: Normality

    def random(self, confidence: float) -> bool:
        """Returns whether the residuals are spatially random."""
        return self.moran_p > 1.0 - confidence

    def normal(self, confidence: float) -> bool:
        """Returns whether the residuals are normal, judged by Lilliefors."""
        return self.normality.lilliefors_p > 1.0 - confidence

    def adequate(self, confidence: float) -> bool:
        """Returns whether the residuals are both random and normal."""
        return self.random(confidence) and self.normal(confidence)


@dataclass(frozen=True, eq=False)
class Separation:
    """A part's deviations taken apart: `deterministic` as a surface, `random_mm` (n,) as values at the places.

    `chosen` is the size taken and what the tests say of it. `sigma_mm` is the scatter of the random part, with the
    degrees of freedom counted that the fit took.
    """

    near: Neighbourhood
    measured_mm: Array
    deterministic: SplineSurface
    random_mm: Array
    chosen: Trial
    sigma_mm: float
    criterion: str
    findings: tuple[Finding, ...]

    @property
    def places(self) -> Places:
        """Where the deviations are known."""
        return self.near.places

    @cached_property
    def geary_c(self) -> float:
        """Returns Geary's C of the random part: of differences between neighbours, where Moran's I takes products."""
        return self.near.geary_c(self.random_mm)

    @cached_property
    def expected_geary_c(self) -> float:
        """The expected C of a random part without order in space."""
        return expected_geary_c(self.near, self.chosen.size)

    @cached_property
    def permutation_p(self) -> float:
        """The test for spatial randomness by shuffling the random part."""
        return permutation_p_value(self.near, self.random_mm, self.chosen.size)


def separate(
    places: Places,
    errors_mm: Array,
    *,
    near: Neighbourhood | None = None,
    confidence: float = CONFIDENCE,
    degrees: Sequence[int] = DEGREES,
    criterion: str = "likelihood",
    name: str = "",
) -> Separation:
    """Takes deviations apart; `name` tells whose they are, in refusals and findings.

    criterion: "likelihood": the size under which the deviations are most likely. "randomness", the published one:
    fewest control points, then lowest degree, whose residuals are normal (Lilliefors) and spatially random (Moran's I
    against the moments of residuals); raises SRF-MODEL when no size leaves spatially random ones. Either way both tests
    stand in the trial that is chosen, and what they reject is among the findings.
    """
    near = near or Neighbourhood(places)
    candidates, likely = _sizes(places, degrees, name), cache(partial(log_likelihood, places, errors_mm))
    if criterion == "likelihood":
        chosen = _trial(near, errors_mm, most_likely(candidates, likely))
    else:
        chosen = _until_random(near, errors_mm, candidates, likely, confidence, name)
    return _taken_apart(near, errors_mm, chosen, criterion, tuple(_findings(chosen, confidence, name)))


def _sizes(places: Places, degrees: Sequence[int], name: str) -> list[Size]:
    if found := list(sizes(places, degrees)):
        return found
    given = f"{len(places.u)} points"
    if places.rows is not None and places.columns is not None:
        given = f"{len(places.rows)} rows and {len(places.columns)} columns"
    least = math.ceil((min(degrees) + 1) / FULLEST)
    raise Code.SRF_POINTS.refusal(
        f"{name!r} was measured in {given}: too few for any surface",
        hint=f"{least} rows and {least} columns are the least",
        values={"part": name},
    )


def of_size(places: Places, errors_mm: Array, size: Size, near: Neighbourhood | None = None) -> Separation:
    """Deviations taken apart by a surface of a given size."""
    near = near or Neighbourhood(places)
    trial = _trial(near, errors_mm, size)
    return _taken_apart(near, errors_mm, trial, "given", ())


def _until_random(
    near: Neighbourhood,
    errors: Array,
    candidates: Sequence[Size],
    likely: Callable[[Size], float],
    confidence: float,
    name: str,
) -> Trial:
    """The first adequate size; then with fewer control points along one direction alone.

    Going down, a size has to be adequate and more likely: a test that has said no many times says yes once by chance.
    Where no size leaves normal residuals, the smallest that leaves spatially random ones.
    """
    tried = cache(partial(_trial, near, errors))
    for size in candidates:
        if tried(size).adequate(confidence):
            return tried(climbed(size, likely, thinner, lambda size: tried(size).adequate(confidence)))
    random = [size for size in candidates if tried(size).random(confidence)]
    if not random:
        raise _never_random(tried(candidates[-1]), confidence, name)
    return tried(random[0])


def _never_random(last: Trial, confidence: float, name: str) -> TrueloopError:
    return Code.SRF_MODEL.refusal(
        f"{name!r}: up to {last.size} control points the residuals are not spatially random: Moran's I "
        f"{last.moran_i:.4f}, p {last.moran_p:.2g}, wanted above {1 - confidence:.2g}",
        hint="measure more densely if the pattern has waves shorter than two steps of the grid; or choose the size by "
        'likelihood (model.criterion = "likelihood" in the job)',
    )


def _trial(near: Neighbourhood, errors: Array, size: Size) -> Trial:
    span = projector(near.places, size)
    residuals = span.residuals(errors)
    free = np.maximum(1.0 - span.leverages, 1e-9)
    law = normality(residuals / np.sqrt(free))
    null = residual_null(near, size)
    moran_i = float(near.moran_i(residuals[:, None])[0])
    return Trial(size, moran_i, null, null.p_value(moran_i), law)


def _taken_apart(
    near: Neighbourhood, errors: Array, chosen: Trial, criterion: str, findings: tuple[Finding, ...]
) -> Separation:
    span = projector(near.places, chosen.size)
    residuals = span.residuals(errors)
    return Separation(
        near=near,
        measured_mm=errors,
        deterministic=regress(near.places, errors, chosen.size),
        random_mm=residuals,
        chosen=chosen,
        sigma_mm=float(np.sqrt(np.sum(residuals**2) / (len(errors) - span.rank))),
        criterion=criterion,
        findings=findings,
    )


def _findings(chosen: Trial, confidence: float, name: str) -> Iterator[Finding]:
    wanted = f"wanted above {1 - confidence:.2g}"
    if not chosen.random(confidence):
        yield Finding(
            Severity.NOTE,
            Code.SRF_MODEL,
            f"{name!r}: what {chosen.size} control points leave is not spatially random: Moran's I "
            f"{chosen.moran_i:.4f}, p {chosen.moran_p:.2g}, {wanted}",
            "some of the pattern is left, less than the random part: more control points would follow that sooner",
        )
    if not chosen.normal(confidence):
        yield Finding(
            Severity.WARNING,
            Code.SRF_MODEL,
            f"{name!r}: what {chosen.size} control points leave is not normal: Lilliefors p "
            f"{chosen.normality.lilliefors_p:.2g} (Kolmogorov–Smirnov {chosen.normality.ks_p:.2g}), {wanted}",
            "look for single bad touches: they make the tails too heavy",
        )


COVERAGE: Final = 0.95
MANY: Final = 100_000
"""Degrees of freedom with which Student's law is the normal one; more parts than anybody measures."""


def student(coverage: float, freedom: float) -> float:
    """Two-sided factor of Student's t."""
    from scipy.special import stdtrit  # slow to import

    return float(stdtrit(freedom, 0.5 + coverage / 2))


@dataclass(frozen=True)
class OutlyingPoint:
    """The place of a part, from 0, that its surface fits worst: by how much, and the probability of that by chance."""

    index: int
    off_mm: float
    p_value: float


@dataclass(frozen=True)
class ScatteringPart:
    """The part, from 0, whose random part is largest, that of the others, and the probability of that by chance."""

    index: int
    sigma_mm: float
    others_mm: float
    p_value: float


def outlying_point(apart: Separation) -> OutlyingPoint:
    """The touch with the largest studentised residual.

    What the fit without the touch would leave at it, r/(1 − h), over its standard deviation from all other touches,
    follows Student's t (Cook & Weisberg 1982, §2.2.2); the probability is shared among the touches (Bonferroni). Valid
    for one bad touch: two beside each other hide behind each other.
    """
    from scipy.special import stdtr  # slow to import

    span = projector(apart.places, apart.chosen.size)
    left, free = apart.random_mm, np.maximum(1.0 - span.leverages, 1e-9)
    freedom = len(left) - span.rank - 1
    others = np.maximum(np.sum(left**2) - left**2 / free, 0.0) / freedom
    t = np.abs(left) / np.sqrt(np.maximum(others * free, np.finfo(float).tiny))
    k = int(np.argmax(t))
    return OutlyingPoint(k, float(left[k] / free[k]), min(1.0, 2 * len(left) * float(stdtr(freedom, -t[k]))))


def scattering_part(parts: Sequence[Separation]) -> ScatteringPart:
    """The part whose touches scatter most, by an F test against the others, shared among the parts (Bonferroni); a
    single part scatters by chance.
    """
    from scipy.special import fdtrc  # slow to import

    freedom = np.array([len(part.random_mm) - projector(part.places, part.chosen.size).rank for part in parts])
    squares = np.array([part.sigma_mm**2 for part in parts]) * freedom
    k = int(np.argmax(squares / freedom))
    if len(parts) == 1:
        return ScatteringPart(k, parts[k].sigma_mm, parts[k].sigma_mm, 1.0)
    rest = np.delete(np.arange(len(parts)), k)
    others = float(np.sum(squares[rest]) / np.sum(freedom[rest]))
    ratio = float(squares[k] / freedom[k]) / max(others, np.finfo(float).tiny)
    p = min(1.0, len(parts) * float(fdtrc(freedom[k], np.sum(freedom[rest]), ratio)))
    return ScatteringPart(k, parts[k].sigma_mm, others**0.5, p)
