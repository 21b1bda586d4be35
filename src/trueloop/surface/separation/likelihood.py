"""How likely deviations are under a spline surface of some size, whatever its control values.

    y = X β + B c + ε,  c ~ N(0, τ²),  ε ~ N(0, σ²):  a large surface follows more, and is therefore less likely to give
just this. β are the coefficients of a polynomial surface, which every size follows: form errors, large and smooth, say
nothing of the size. They, σ² and τ² are taken out (restricted likelihood; Patterson & Thompson 1971). Valid where
residuals are independent and normal; the more alike the control values are in size, the sharper.
"""

from functools import lru_cache
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.separation.places import Places, projector
from trueloop.surface.separation.spline_surface import Size

FORM: Final = Size(3, 3, 2)
"""The polynomials that every size contains."""
LOG_RATIOS: Final = np.linspace(0.0, 18.0, 19)
"""Of the variance that c gives a mean shape to σ². Never below 1: a shape with less is better not followed at all by
least squares, which does not shrink. Up to e¹⁸, shapes of 8 mm over noise of 1 µm; steps of e, between which a
parabola finds the top.
"""
ROUNDING: Final = 1e-15
"""What rounding leaves of values that a surface follows exactly, as a share of their squares."""


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
