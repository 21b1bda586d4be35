"""From fits to curves with their uncertainty: the scatter of the touches, and what is handed from chain to chain."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.turned.error_curve.likeness import likeness_of
from trueloop.turned.fit.chain_fit import ChainFit, ConditionSource
from trueloop.turned.fit.fit_chains import conditions_covariance
from trueloop.turned.fit.spline import EndConditions, LinearForm, Spline, least_squares_spline
from trueloop.turned.touches.error_vectors import ErrorVectors


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
