"""From fits to curves with their uncertainty: the scatter of the touches, and what is handed from chain to chain.

Touches that lie close: how far along a cut its scatter is alike, and what that does to the curve through them.

A process that varies along the cut over a millimetre or two displaces neighbouring touches alike. Taken for
independent, they scatter too little about a curve that follows them too well: with touches 1.5 mm apart, of a process
alike over 1 mm, bands of 95 % hold 91 %. Nobody knows the length beforehand, so the residuals of all curves say how
probable each is (`process_scatter`). What is alike over several millimetres looks like the feature's own error: no
touch of one part tells it, and `fit.between_cuts` holds it.

The scatter of the next cut by itself: the scatter of the touches less that of the probe.

Touches scatter about their curve by process and probe together, the next cut by the process alone. Touches that lie
close have the process's scatter partly in common, and show less of it than there is; over which length it is alike,
they show as well (`likeness`). With the probe's variance u² known, and for a length ℓ, the residuals of a curve with ν
spare touches are ν independent sums, of variance λ v + u² each: v the process's variance, λ its share in the sum, 1
for touches far apart. That is the restricted likelihood of v and ℓ. An estimate of v alone is none to build a band on:
it is uncertain by more than either, may be negative, and says nothing of that. So v and ℓ are given the distribution
that the touches leave them (Jeffreys' prior of v ≥ 0, all lengths as probable as each other), and the next cut is a
normal scatter of unknown variance v. Far apart and without a probe's share that is Student's distribution, to which the
result is referred. With few touches, or a process finer than its probe, the bands hold more than they promise.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from scipy.special import erf

from trueloop.arrays import Array
from trueloop.estimate.weights import probabilities
from trueloop.statistics import root_of
from trueloop.turned.error_curve.curve import COVERAGE, coverage_factor
from trueloop.turned.fit.chain_fit import ChainFit, ConditionSource
from trueloop.turned.fit.fit_chains import conditions_covariance
from trueloop.turned.fit.spline import EndConditions, LinearForm, Spline, SplineFit, least_squares_spline
from trueloop.turned.touches.error_vectors import ErrorVectors

STEPS: Final = 400
"""Steps of the integral over the process's variance, whose result is right to 1e-4 of it."""

ROUNDING_MM2: Final = 1e-30
"""A residual sum of squares below this is rounding of touches that have no scatter."""


@dataclass(frozen=True, eq=False)
class Spread:
    """The evidence of one curve on the scatter: independent sums of its residuals, as many as it has touches to spare.

    `squares_mm2` are theirs, `shares` the part of the process's variance that each has beside the probe's `probe_mm2`;
    both (lengths, spare), a row for each length over which the process may be alike, or one row for all.
    """

    squares_mm2: Array
    shares: Array
    probe_mm2: float

    @property
    def spare(self) -> int:
        """Touches to spare."""
        return int(self.shares.shape[1])

    @property
    def total_mm2(self) -> float:
        """Returns the residual sum of squares."""
        return float(np.sum(self.squares_mm2[0]))


def far_apart(spare: int, squares_mm2: float, probe_mm2: float) -> Spread:
    """Returns the spread of touches that have nothing of the process in common."""
    return Spread(np.full((1, spare), squares_mm2 / spare), np.ones((1, spare)), probe_mm2)


@dataclass(frozen=True, eq=False)
class ProcessScatter:
    """`standard_mm` times Student's k (of all spare touches) holds 95 % of what the next cut scatters.

    `length_weights` (lengths,): how probable each length is over which the process may be alike.
    """

    standard_mm: float
    length_weights: Array


def process_scatter(spreads: Sequence[Spread]) -> ProcessScatter:
    """Estimates the scatter of the process from all curves together.

    At most what the touches scatter by or the probe should, so that telling the two apart never widens a band; above
    zero even where the touches scatter less than the probe. Needs at least one spare touch. Valid where the probe's
    repeatability is as stated and touches scatter as cuts do.
    """
    spare = sum(spread.spare for spread in spreads)
    squares = math.fsum(spread.total_mm2 for spread in spreads)
    probe = math.fsum(spread.spare * spread.probe_mm2 for spread in spreads) / spare
    lengths = max(len(spread.shares) for spread in spreads)
    k = coverage_factor(spare)
    independent = squares < ROUNDING_MM2 or all(np.all(spread.shares == 1.0) for spread in spreads)
    whole_mm = math.sqrt(squares / spare)
    if not independent:
        whole_mm = _half_width(*_posterior(spreads, squares, 0.0, spare)) / k
    if independent and probe == 0.0:
        return ProcessScatter(whole_mm, np.full(lengths, 1.0 / lengths))
    variance, weight = _posterior(spreads, max(squares, 1e-9 * spare * probe), probe, spare)
    standard_mm = min(_half_width(variance, weight) / k, max(whole_mm, math.sqrt(probe)))
    return ProcessScatter(standard_mm, np.sum(weight, axis=1))


def _posterior(spreads: Sequence[Spread], squares: float, probe: float, spare: int) -> tuple[Array, Array]:
    """Process variances (steps,), and the weights of each with each length, (lengths, steps).

    At steps of x = S/(v + u²), which is χ² far apart where all curves have the same u². The variance v is above zero up
    to x = S/u². `probe` 0: the curves' own probe shares do not count.
    """
    largest = spare + 12.0 * math.sqrt(2.0 * spare) + 40.0
    largest = min(squares / probe, largest) if probe > 0.0 else largest
    root = (np.arange(STEPS) + 0.5) / STEPS
    x = largest * root**3  # small x, large variances: what few touches cannot exclude
    v = squares / x - probe
    log_weight: Array = -4.0 * np.log(root)[None, :]
    information: Array = np.zeros((1, STEPS))
    for spread in spreads:
        shares, squared = spread.shares[:, None, :], spread.squares_mm2[:, None, :]
        total = v[:, None] * shares + (spread.probe_mm2 if probe > 0.0 else 0.0)
        log_weight = log_weight - 0.5 * np.sum(np.log(total) + squared / total, axis=-1)
        information = information + np.sum((shares / total) ** 2, axis=-1)
    log_weight = log_weight + 0.5 * np.log(information)
    return v, probabilities(log_weight, axis=None)


def _half_width(variance: Array, weight: Array) -> float:
    """Returns the half width that holds `COVERAGE` of a normal scatter of these variances, by halving."""
    reach, weight = np.sqrt(2.0 * variance), np.sum(weight, axis=0)
    low, high = 0.0, 40.0 * float(np.max(reach))
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(weight @ erf(middle / reach)) < COVERAGE else (low, middle)
    return high


LENGTHS_MM: Final = (0.25, 0.75, 1.25, 1.75)
"""ℓ of the correlation exp(−d²/2ℓ²) of the process's scatter at two places d apart: any up to 2 mm is as probable as
any other, of which these are the middles of four parts. Mixed, they follow other shapes of correlation as well."""

SEEN: Final = 0.01
"""Touches are far apart where no two of a curve have more than this in common at the largest length."""

LEAST_SHARE: Final = 1e-6
"""The least share of the process's variance in residuals: two touches in one place differ by rounding still."""

MOST: Final = 500
"""Touches of one curve; more know it so well that what they have in common no longer matters to its band."""


@dataclass(frozen=True, eq=False)
class Likeness:
    """`process_mm` as `ProcessScatter.standard_mm`, None without a touch to spare.

    `roots_mm`: of chains fitted to their touches, by index, a square root of their coefficients' covariance from the
    touches' scatter, (coefficients, touches). `touches_mm2`: of chains whose touches lie close, the covariance of their
    scatter, (touches, touches).
    """

    process_mm: float | None
    roots_mm: Mapping[int, Array] = field(default_factory=dict)
    touches_mm2: Mapping[int, Array] = field(default_factory=dict)


def likeness_of(
    fits: Mapping[int, ChainFit], scatter_mm: Mapping[int, float], vectors: ErrorVectors, stated_mm: float | None = None
) -> Likeness:
    """Estimates the likeness from the touches of all chains; `scatter_mm` is the standard deviation of a touch, by
    chain.

    `stated_mm`: the length over which the process is alike, where it is known.
    """
    lengths_mm = LENGTHS_MM if stated_mm is None else (stated_mm,)
    solved = {i: _solved(fit, vectors) for i, fit in fits.items()}
    near = {i: one for i, one in solved.items() if one is not None and _near(one.apart_mm, lengths_mm[-1])}
    spreads = [_spread(fit, near.get(i), vectors, lengths_mm) for i, fit in fits.items() if fit.spare > 0]
    if not spreads:
        return Likeness(None)
    process = process_scatter(spreads)
    weights = process.length_weights
    if len(weights) < len(lengths_mm):  # no touches to spare lie close
        weights = np.full(len(lengths_mm), 1.0 / len(lengths_mm))
    scattered = {}
    for i, one in near.items():
        alike = sum(w * _alike(one.apart_mm, length) for w, length in zip(weights, lengths_mm, strict=True))
        own_mm2 = max(scatter_mm[i] ** 2 - process.standard_mm**2, _probe_mm2(fits[i], vectors))
        scattered[i] = process.standard_mm**2 * alike + own_mm2 * np.eye(len(one.apart_mm))
    roots = {i: near[i].response @ root_of(one) for i, one in scattered.items() if fits[i].scattered is None}
    return Likeness(process.standard_mm, roots, scattered)


@dataclass(frozen=True, eq=False)
class _Solved:
    """A least-squares fit as what it does to the touches' errors.

    Its coefficients follow them by `response` (coefficients, n); `spare` (n, ν) are orthonormal sums of them that no
    curve of its shape can have; `apart_mm` (n, n) distances along the chain.
    """

    response: Array
    spare: Array
    apart_mm: Array


def _solved(fit: ChainFit, vectors: ErrorVectors) -> _Solved | None:
    """None where the curve was not fitted to its touches, or to too many of them."""
    through = fit.through_touches
    if through is None or not 0 < len(fit.touches) <= MOST:
        return None
    spline, s = through.spline, fit.places_mm(vectors)
    free = _free(through)
    rows = spline.value_form(s).dense(len(spline.coefficients_mm)) @ free
    q, r = np.linalg.qr(rows, mode="complete")
    unknowns = rows.shape[1]
    response = free @ np.linalg.solve(r[:unknowns], q[:, :unknowns].T)
    return _Solved(response, q[:, unknowns:], np.abs(np.subtract.outer(s, s)))


def _free(through: SplineFit) -> Array:
    """Directions in which the coefficients may go under the end conditions, (coefficients, unknowns), orthonormal."""
    spline, count = through.spline, len(through.spline.coefficients_mm)
    ends = (0.0, 0.0, spline.length_mm, spline.length_mm)
    forms = (spline.value_form, spline.slope_form) * 2
    held = [
        form(at).dense(count)[0]
        for form, at, number in zip(forms, ends, through.conditions.numbers, strict=True)
        if number is not None
    ]
    if not held:
        return np.eye(count)
    return np.linalg.qr(np.array(held).T, mode="complete")[0][:, len(held) :]


def _spread(fit: ChainFit, near: _Solved | None, vectors: ErrorVectors, lengths_mm: Sequence[float]) -> Spread:
    """Returns the spread of one chain; `near` None: touches lie far apart, or its curve does not go through them."""
    residual, probe = fit.scattered_mm, _probe_mm2(fit, vectors)
    if near is None:
        return far_apart(fit.spare, float(np.sum(residual**2)), probe)
    sums = near.spare.T @ residual
    found = [np.linalg.eigh(near.spare.T @ _alike(near.apart_mm, length) @ near.spare) for length in lengths_mm]
    squares = np.array([(directions.T @ sums) ** 2 for _, directions in found])
    return Spread(squares, np.array([np.maximum(shares, LEAST_SHARE) for shares, _ in found]), probe)


def _probe_mm2(fit: ChainFit, vectors: ErrorVectors) -> float:
    return float(np.mean(vectors.own_u_mm[fit.touches] ** 2))


def _near(apart_mm: Array, longest_mm: float) -> bool:
    apart = apart_mm[~np.eye(len(apart_mm), dtype=bool)]
    return bool(np.any(_alike(apart, longest_mm) > SEEN))


def _alike(apart_mm: Array, length_mm: float) -> Array:
    """Returns the correlation of the process's scatter at places this far apart."""
    if length_mm == 0.0:
        return np.where(apart_mm == 0.0, 1.0, 0.0)
    return np.exp(-0.5 * (apart_mm / length_mm) ** 2)


@dataclass(frozen=True)
class FittedChains:
    """The chains' fits and finished splines, each by the chain's index, in the profile's order.

    `scatter_mm` is the standard deviation of a touch about each chain's curve: the residuals of all chains with touches
    to spare, pooled over `degrees_of_freedom` of them, and never less than the touches' type B uncertainty. Pooling
    assumes that lines and arcs of one cut scatter alike; a curve too stiff for its feature makes all bands wider.
    `reference` (None: z has no reference): what each chain's coefficients follow the reference touch by, per unit of
    its own error, one and the same in all chains. `residual_mm`: the scatter of the residuals alone. `process_mm` is
    the process's part of the scatter, which the next cut scatters by again (None: not looked for, or no touch to
    spare). `touches_mm2`: by chain whose touches lie close, the covariance of their scatter.
    """

    fits: Mapping[int, ChainFit]
    splines: Mapping[int, Spline]
    scatter_mm: Mapping[int, float]
    degrees_of_freedom: int
    reference: Mapping[int, Array] | None
    residual_mm: float = 0.0
    process_mm: float | None = None
    touches_mm2: Mapping[int, Array] = field(default_factory=dict)


def finish(fits: Mapping[int, ChainFit], vectors: ErrorVectors) -> FittedChains:
    """Puts numbers to the covariances: σ² of the touches, and that of the end values taken from neighbours."""
    reference = reference_responses(fits, vectors) if np.any(vectors.at_reference) else None
    to_spare = [fit for fit in fits.values() if fit.spare > 0]
    spare = sum(fit.spare for fit in to_spare)
    pooled = sum(float(np.sum(fit.scattered_mm**2)) for fit in to_spare) / spare if spare else 0.0
    scatter = {i: _at_least_type_b(fit, vectors, pooled) for i, fit in fits.items()}
    splines = _splines(fits, scatter, reference, vectors, {})
    return FittedChains(
        fits=fits,
        splines=splines,
        scatter_mm=scatter,
        degrees_of_freedom=spare,
        reference=reference,
        residual_mm=float(np.sqrt(pooled)),
    )


def with_likeness(fitted: FittedChains, vectors: ErrorVectors, stated_mm: float | None) -> FittedChains:
    """Returns the fitted chains with the common part of touches that lie close, and with the process's part of the
    scatter.

    `stated_mm`: the length over which the process is alike (None: estimated from the touches).
    """
    found = likeness_of(fitted.fits, fitted.scatter_mm, vectors, stated_mm)
    splines = fitted.splines
    if found.roots_mm:
        splines = _splines(fitted.fits, fitted.scatter_mm, fitted.reference, vectors, found.roots_mm)
    return replace(fitted, splines=splines, process_mm=found.process_mm, touches_mm2=found.touches_mm2)


def _splines(
    fits: Mapping[int, ChainFit],
    scatter_mm: Mapping[int, float],
    reference: Mapping[int, Array] | None,
    vectors: ErrorVectors,
    roots_mm: Mapping[int, Array],
) -> dict[int, Spline]:
    """Returns the chains' splines; `roots_mm` of the covariances of those whose touches are not independent."""
    splines: dict[int, Spline] = {}
    while len(splines) < len(fits):
        for i, fit in fits.items():
            givers = {source.neighbour.chain for source in fit.sources if source.neighbour is not None}
            if i not in splines and givers <= splines.keys():
                splines[i] = _finished(fit, scatter_mm[i], splines, roots_mm.get(i, fit.from_model_mm))
    if reference is not None:
        # The standard deviation of the reference touch: that of its chain's touches
        (k,) = np.flatnonzero(vectors.at_reference)
        own_mm = next(scatter_mm[i] for i, fit in fits.items() if k in fit.touches)
        splines = {i: spline.with_common(own_mm * reference[i]) for i, spline in splines.items()}
    return {i: splines[i] for i in fits}


def _at_least_type_b(fit: ChainFit, vectors: ErrorVectors, pooled_mm2: float) -> float:
    """Returns the scatter of a chain; without a touch, the other touches' uncertainty, unless it is stated."""
    if fit.scatter_mm is not None:
        return fit.scatter_mm
    u = vectors.standard_u_mm[fit.touches] if len(fit.touches) else vectors.standard_u_mm
    return float(np.sqrt(max(pooled_mm2, float(np.mean(u**2)))))


def _finished(fit: ChainFit, scatter_mm: float, splines: dict[int, Spline], root_mm: Array | None) -> Spline:
    from_ends = conditions_covariance(fit, splines)
    if root_mm is None:
        return fit.fit.scaled(scatter_mm**2, from_ends)
    spline = fit.fit.scaled(0.0, from_ends)
    return replace(spline, prescribed_mm=np.hstack([root_mm, spline.prescribed_mm]))


def reference_responses(fits: Mapping[int, ChainFit], vectors: ErrorVectors) -> dict[int, Array]:
    """Returns by how much the coefficients of each chain fall for an error of 1 of the reference touch, (coefficients,)
    each.

    Its own error ε is in every error along z: e_i − (n_z,i/n_z,r)·ε. That is one error common to all, no scatter: a fit
    cannot average it away. The fits are linear in the errors, so the coefficients follow ε as fits to the shares do.

    What the user prescribes, and features that are estimated without a touch or from readings, do not follow it, nor do
    curves that earlier parts make: what their references did is in what is known of how parts differ. A
    curve from a nose model is taken to follow it as one through its touches would: exact for the offset along z that
    the model finds.
    """
    found: dict[int, Array] = {}
    while len(found) < len(fits):
        for i, fit in fits.items():
            givers = {source.neighbour.chain for source in fit.sources if source.neighbour is not None}
            if i not in found and givers <= found.keys():
                found[i] = _response(fit, fits, found, vectors)
    return {i: found[i] for i in fits}


def _response(fit: ChainFit, fits: Mapping[int, ChainFit], responses: dict[int, Array], vectors: ErrorVectors) -> Array:
    """Returns the chain's own fit made again, with the shares in place of the errors."""
    estimated = fit.scatter_mm is not None or not len(fit.touches)
    if estimated and all(source.neighbour is None for source in fit.sources):
        return np.zeros_like(fit.fit.spline.coefficients_mm)
    # The ends' values and slopes by the reference: those of the neighbours, zero where prescribed
    numbers, of_ends = [], fit.fit.conditions.numbers
    for source, value, slope in zip(fit.sources, of_ends[::2], of_ends[1::2], strict=True):
        numbers += [
            _number(source, value, fits, responses, slope=False),
            _number(source, slope, fits, responses, slope=True),
        ]
    given = EndConditions(*numbers)
    spline = fit.fit.spline
    s = fit.places_mm(vectors)
    share = vectors.z_share[fit.touches]
    if fit.scattered is not None or (fit.from_model_mm is not None and not len(s)):
        s, share = (every := np.linspace(0.0, spline.length_mm, 8 * len(spline.coefficients_mm))), np.zeros_like(every)
    elif fit.from_model_mm is not None:
        every = np.linspace(0.0, spline.length_mm, 8 * len(spline.coefficients_mm))
        s, share = every, np.interp(every, s, share)
    knots, degree = spline.interior_knots_mm, spline.degree
    return least_squares_spline(s, share, knots, spline.length_mm, degree, given).spline.coefficients_mm


def _number(
    source: ConditionSource,
    number: float | None,
    fits: Mapping[int, ChainFit],
    responses: dict[int, Array],
    *,
    slope: bool,
) -> float | None:
    if number is None:
        return None
    if source.neighbour is None or (slope and not source.gives_slope):
        return 0.0
    spline: Spline = fits[source.neighbour.chain].fit.spline
    at = spline.length_mm if source.neighbour.at_end else 0.0
    form: LinearForm = spline.slope_form(at) if slope else spline.value_form(at)
    return float(form.of(responses[source.neighbour.chain])[0])
