"""All chains of a profile, in the order in which they prescribe to each other.

Touched lines come first; touched arcs take their end values (and slopes, under the policy PATH) from them; lines
without a touch follow the arcs they are tangent to; what is left is expected from the other features
(`untouched_fit`).
"""

import numpy as np

from trueloop.geometry.profile import Profile
from trueloop.turned.fit.arc_fit import fit_arcs
from trueloop.turned.fit.chain import Chain, chains_of
from trueloop.turned.fit.chain_fit import ChainFit, Sources, touches_of
from trueloop.turned.fit.choose import ModelChoice, NoseOnPart, choose
from trueloop.turned.fit.conditions import chain_conditions
from trueloop.turned.fit.line_fit import fit_lines
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.fit.untouched_fit import fit_untouched
from trueloop.turned.touches.error_vectors import ErrorVectors


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
            fits[i] = fit_untouched(profile, chains[i], vectors, conditions, sources, fits)
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
