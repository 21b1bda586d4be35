"""The end conditions of a chain: from its tangent neighbours, and from the user."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain import Chain, End, TangentPolicy, tangent_neighbours
from trueloop.turned.fit.chain_fit import ChainFit, ConditionSource, Sources
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.spline import EndConditions, Spline
from trueloop.units import UM_PER_MM

AGREE_MM: Final = 1e-9
"""Prescribed numbers that differ by less are the same, rounded twice."""


def chain_conditions(
    profile: Profile, chains: tuple[Chain, ...], index: int, fits: Mapping[int, ChainFit], options: FitOptions
) -> tuple[EndConditions, Sources]:
    """Returns the conditions that fitted tangent neighbours and the user prescribe to a chain, and the source of each
    end's.
    """
    before, after = tangent_neighbours(profile, chains, index)
    start_value, start_slope, start = _from_neighbour(before, fits, options)
    end_value, end_slope, end = _from_neighbour(after, fits, options)
    asked = _asked(profile, chains[index], options)
    name = " and ".join(profile.features[i].name for i in chains[index].features)
    conditions = EndConditions(
        _agreed(name, "value at the start", start_value, asked.start_value_mm),
        _agreed(name, "slope at the start", start_slope, asked.start_slope),
        _agreed(name, "value at the end", end_value, asked.end_value_mm),
        _agreed(name, "slope at the end", end_slope, asked.end_slope),
    )
    return conditions, (start, end)


def conditions_covariance(fit: ChainFit, splines: Mapping[int, Spline]) -> Array:
    """Returns the covariance of the prescribed numbers, in their order; the user's count as exact."""
    c = fit.fit.conditions
    if not c.count:
        return np.zeros((0, 0))
    blocks = [
        _end_covariance(fit.sources[0], splines, c.start_value_mm is not None, c.start_slope is not None),
        _end_covariance(fit.sources[1], splines, c.end_value_mm is not None, c.end_slope is not None),
    ]
    total = np.zeros((c.count, c.count))
    at = 0
    for block in blocks:
        total[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return total


def _from_neighbour(
    end: End | None, fits: Mapping[int, ChainFit], options: FitOptions
) -> tuple[float | None, float | None, ConditionSource]:
    if end is None or end.chain not in fits:
        return None, None, ConditionSource()
    spline = fits[end.chain].fit.spline
    at = spline.length_mm if end.at_end else 0.0
    value, slope = float(spline.of(spline.value_form(at))[0]), float(spline.of(spline.slope_form(at))[0])
    tangent = options.junctions == TangentPolicy.PATH
    return value, slope if tangent else None, ConditionSource(neighbour=end, gives_slope=tangent)


def _end_covariance(source: ConditionSource, splines: Mapping[int, Spline], value: bool, slope: bool) -> Array:
    """Returns the covariance of (value, slope), of those of them that are prescribed."""
    given = np.array([value, slope])
    both = np.diag([source.standard_u_mm**2, 0.0])
    if source.neighbour is not None:
        spline = splines[source.neighbour.chain]
        at = spline.length_mm if source.neighbour.at_end else 0.0
        forms = spline.value_form(at), spline.slope_form(at)
        both = np.array([[spline.covariance(a, b)[0] for b in forms] for a in forms])
        both[0, 0] += spline.drawn_out_u_mm(at)[0] ** 2
        if not source.gives_slope:
            both = np.diag([both[0, 0], 0.0])
    chosen: Array = both[np.ix_(given, given)]
    return chosen


def _asked(profile: Profile, chain: Chain, options: FitOptions) -> EndConditions:
    """Returns the user's conditions at the chain's outer ends; inside a chain there is nothing to prescribe."""
    names = [profile.features[i].name for i in chain.features]
    none = EndConditions()
    asked = [options.prescribed.get(name, none) for name in names]
    for before, after, name in zip(asked, asked[1:], names, strict=False):
        inner = (before.end_value_mm, before.end_slope, after.start_value_mm, after.start_slope)
        if any(number is not None for number in inner):
            raise Code.FIT_CONDITIONS.refusal(
                f"a value or slope is prescribed where {name!r} and the next feature join tangentially "
                f"(given: {[number for number in inner if number is not None]} mm or mm/mm)",
                hint="one curve runs over features that join tangentially: prescribe at its outer ends only",
            )
    return EndConditions(asked[0].start_value_mm, asked[0].start_slope, asked[-1].end_value_mm, asked[-1].end_slope)


def _agreed(name: str, what: str, neighbour: float | None, asked: float | None) -> float | None:
    if neighbour is not None and asked is not None and abs(neighbour - asked) > AGREE_MM:
        raise Code.FIT_CONDITIONS.refusal(
            f"{name}: the {what} is prescribed as {asked * UM_PER_MM:.3f} µm (per mm, for a slope), but the tangent "
            f"neighbour's curve says {neighbour * UM_PER_MM:.3f}",
            hint="leave it out, or declare the junction a corner",
        )
    return asked if neighbour is None else neighbour
