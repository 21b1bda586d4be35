"""The response of the curves to the touch that the part's z is taken from.

Its own error ε is in every error along z: e_i − (n_z,i/n_z,r)·ε. That is one error common to all, no scatter: a fit
cannot average it away. The fits are linear in the errors, so the coefficients follow ε as the same fits to the shares
do.
"""

from collections.abc import Mapping

import numpy as np

from trueloop.arrays import Array
from trueloop.turned.fit.chain_fit import ChainFit, ConditionSource
from trueloop.turned.fit.spline import EndConditions, LinearForm, Spline, least_squares_spline
from trueloop.turned.touches.error_vectors import ErrorVectors


def reference_responses(fits: Mapping[int, ChainFit], vectors: ErrorVectors) -> dict[int, Array]:
    """Returns by how much the coefficients of each chain fall for an error of 1 of the reference touch, (coefficients,)
    each.

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


def _response(fit: ChainFit, fits: Mapping[int, ChainFit], found: dict[int, Array], vectors: ErrorVectors) -> Array:
    """Returns the chain's own fit made again, with the shares in place of the errors."""
    estimated = fit.scatter_mm is not None or not len(fit.touches)
    if estimated and all(source.neighbour is None for source in fit.sources):
        return np.zeros_like(fit.fit.spline.coefficients_mm)
    given = _conditions(fit, fits, found)
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


def _conditions(fit: ChainFit, fits: Mapping[int, ChainFit], found: dict[int, Array]) -> EndConditions:
    """Returns the ends' values and slopes by the reference: those of the neighbours, zero where prescribed."""
    numbers, given = [], fit.fit.conditions.numbers
    for source, value, slope in zip(fit.sources, given[::2], given[1::2], strict=True):
        numbers += [_number(source, value, fits, found, slope=False), _number(source, slope, fits, found, slope=True)]
    return EndConditions(*numbers)


def _number(
    source: ConditionSource, given: float | None, fits: Mapping[int, ChainFit], found: dict[int, Array], *, slope: bool
) -> float | None:
    if given is None:
        return None
    if source.neighbour is None or (slope and not source.gives_slope):
        return 0.0
    spline: Spline = fits[source.neighbour.chain].fit.spline
    at = spline.length_mm if source.neighbour.at_end else 0.0
    form: LinearForm = spline.slope_form(at) if slope else spline.value_form(at)
    return float(form.of(found[source.neighbour.chain])[0])
