"""What a map of one part shows at each place: measured, deterministic, random, pattern, predicted, variability."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.pattern.pattern import Pattern
from trueloop.surface.separation.places import Places, projector
from trueloop.surface.separation.separate import Separation


@dataclass(frozen=True, eq=False)
class PartMaps:
    """Values in mm at the places of one part, each (n,).

    `predicted_mm` is what this part would have kept, corrected by the pattern of the *other* parts: a part that is
    among those averaged would look better than a next one will. `variability_mm` is the standard deviation between
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
    others = np.mean(np.delete(stack, pattern.names.index(name), axis=0), axis=0)
    scatter = np.std(stack, axis=0, ddof=1)
    fits_own = pattern.sigma_mm**2 * projector(apart.places, pattern.size).leverages
    return PartMaps(
        name=name,
        places=apart.places,
        measured_mm=apart.measured_mm,
        deterministic_mm=apart.measured_mm - apart.random_mm,
        random_mm=apart.random_mm,
        pattern_mm=pattern.mean.value_mm(u, v),
        predicted_mm=apart.measured_mm - weight * others,
        variability_mm=np.sqrt(np.maximum(scatter**2 - fits_own, 0.0)),
        uncertainty_mm=pattern.uncertainty_mm(scatter, u, v),
    )
