"""All chains of a profile, in the order in which they prescribe to each other.

Touched lines come first; touched arcs take their end values (and slopes, under the policy PATH) from them; lines
without a touch follow the arcs they are tangent to; what is left is guessed (`untouched`).
"""

from dataclasses import replace

import numpy as np

from trueloop.error_curve.arc_fit import fit_arcs
from trueloop.error_curve.chain import Chain, chains_of
from trueloop.error_curve.chain_fit import ChainFit, ConditionSource, Sources, own_fit, touches_of
from trueloop.error_curve.choose import ModelChoice, NoseOnPart, choose
from trueloop.error_curve.conditions import chain_conditions
from trueloop.error_curve.line_fit import fit_lines
from trueloop.error_curve.options import FitOptions
from trueloop.error_curve.spline import EndConditions, least_squares_spline
from trueloop.error_curve.untouched import expect
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import contact_angle_rad
from trueloop.geometry.profile import Profile
from trueloop.units import UM_PER_MM


def fit_chains(
    profile: Profile, vectors: ErrorVectors, options: FitOptions, nose: NoseOnPart | None
) -> tuple[tuple[ChainFit, ...], tuple[ModelChoice, ...]]:
    """Fits of every chain in the profile's order, and the choices between own curve and nose model."""
    chains = chains_of(profile)
    touched = [bool(np.any(np.isin(vectors.feature_index, chain.features))) for chain in chains]
    fits: dict[int, ChainFit] = {}
    choices: list[ModelChoice] = []
    for i in sorted(range(len(chains)), key=lambda i: (not touched[i], chains[i].curved)):
        conditions, sources = chain_conditions(profile, chains, i, fits, options)
        if not touched[i]:
            fits[i] = _untouched(profile, chains[i], vectors, conditions, sources)
            continue
        fits[i] = _touched(profile, chains[i], vectors, options, conditions, sources)
        held = any(name in options.prescribed for name in _names(profile, chains[i]))
        if nose is not None and chains[i].curved and not held and np.any(np.isin(nose.positions, fits[i].touches)):
            fits[i], choice = choose(profile, vectors, fits[i], nose, options.tangent_policy)
            choices.append(choice)
    return tuple(fits[i] for i in range(len(chains))), tuple(choices)


def _names(profile: Profile, chain: Chain) -> list[str]:
    return [profile.features[i].name for i in chain.features]


def _touched(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    options: FitOptions,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    names, touches = _names(profile, chain), touches_of(profile, chain, vectors)
    if chain.curved:
        return fit_arcs(names, chain, touches, options, conditions, sources)
    return fit_lines(" and ".join(names), chain, touches, options.tangent_policy, conditions, sources)


def _untouched(
    profile: Profile, chain: Chain, vectors: ErrorVectors, conditions: EndConditions, sources: Sources
) -> ChainFit:
    """From its tangent neighbours where it has any, otherwise a guess with a large uncertainty."""
    name = " and ".join(_names(profile, chain))
    note = f"{name}: no touch; continues its tangent neighbours' curves"
    if conditions.start_value_mm is None and conditions.end_value_mm is None:
        middle = profile.features[chain.features[len(chain.features) // 2]]
        angle = float(contact_angle_rad(middle.outward_normal(middle.length_mm / 2)))
        value, u, why = expect(vectors, angle)
        conditions = replace(conditions, start_value_mm=value)
        sources = ConditionSource(standard_u_mm=u), ConditionSource()
        note = f"{name}: no touch; {why}; standard uncertainty {u * UM_PER_MM:.0f} µm. Touch it to be sure"
    fit = least_squares_spline([], [], [], chain.length_mm, conditions.coefficients - 1, conditions)
    return own_fit(chain, touches_of(profile, chain, vectors), fit, sources, note)
