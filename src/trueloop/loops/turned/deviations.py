"""The deviations of a program's contour from the nominal, feature by feature.

A curved feature may be cut by many short lines. Their ends are what was meant, and what is corrected; between them the
part has facets, which are on it when it is measured.
"""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Line, is_curved
from trueloop.nc.match.contour_match import FeatureMatch
from trueloop.turned.compensation.shift import ZERO, Shift, sampled

SAMPLES: Final = 257

FEWEST_CHORDS: Final = 4
FACETS_MM: Final = 0.005
"""Lines that leave deeper facets are not chords of a curve."""

STRETCHES: Final = 32
"""The ends of chords, each rounded by the programmer, deviate by what the mean of those in each of so many stretches
does."""

OF_RESOLUTION: Final = 1.5
"""Ends that deviate by no more than so much of the control's resolution are rounded on both axes."""


def of_contour(match: FeatureMatch, resolution_mm: float) -> Shift:
    """Returns deviations of the intended contour: sampled, exact on lines, and good to the square of the spacing on
    arcs.

    Of chords the ends count; where these are only rounded, there is none.
    """
    if not is_chords(match):
        return _of_all(match)
    s, off = _at_ends(match)
    if np.max(np.abs(off)) <= OF_RESOLUTION * resolution_mm:
        return ZERO
    groups = np.array_split(np.arange(len(s)), min(STRETCHES, len(s)))
    return sampled(*(np.array([np.mean(of[group]) for group in groups]) for of in (s, off)))


def of_surface(match: FeatureMatch) -> Shift:
    """Returns deviations of the surface that is cut, facets and all."""
    if not is_chords(match):
        return _of_all(match)
    ends = _at_ends(match)[0]
    s = np.unique(np.concatenate([ends, *(ends[:-1] + share * np.diff(ends) for share in (0.25, 0.5, 0.75))]))
    return sampled(s, match.deviation_mm(s))


def unevenness_mm(match: FeatureMatch, contour: Shift) -> float:
    """Returns by how much chords, with their facets and the rounding of their ends, deviate from the intended contour.

    0 of other moves; never more than `FACETS_MM`, which is what chords are allowed.
    """
    if not is_chords(match):
        return 0.0
    surface = of_surface(match)
    off = surface.value_mm(surface.breaks_mm) - contour.value_mm(surface.breaks_mm)
    return min(float(np.max(np.abs(off))), FACETS_MM)


def is_chords(match: FeatureMatch) -> bool:
    """Returns whether a curved feature is cut by short lines from point to point of it."""
    lines = all(isinstance(matched.move.path, Line) for matched in match.moves)
    many = is_curved(match.feature) and len(match.moves) >= FEWEST_CHORDS
    return many and lines and _facets_mm(match) <= FACETS_MM


def _facets_mm(match: FeatureMatch) -> float:
    ends, off = _at_ends(match)
    middle = (off[:-1] + off[1:]) / 2
    return float(np.max(np.abs(match.deviation_mm((ends[:-1] + ends[1:]) / 2) - middle), initial=0.0))


def _at_ends(match: FeatureMatch) -> tuple[Array, Array]:
    """Returns arc lengths of the ends of moves on the feature, ascending, and the deviation of each."""
    both = np.unique(np.round([[m.start_mm, m.end_mm] for m in match.moves], 9))
    s = both[(both >= 0.0) & (both <= match.feature.length_mm)]
    return s, match.deviation_mm(s)


def _of_all(match: FeatureMatch) -> Shift:
    s = np.linspace(0.0, match.feature.length_mm, SAMPLES)
    return sampled(s, match.deviation_mm(s))
