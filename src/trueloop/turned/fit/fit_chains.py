"""All chains of a profile, in the order in which they prescribe to each other.

Touched lines come first; touched arcs take their end values (and slopes, under the policy PATH) from them; lines
without a touch follow the arcs they are tangent to; what is left is expected from the other features
(`untouched_fit`). Where gauges were read, all chains without a touch have their curves from the readings
(`gauged_fit`). Arcs that earlier parts of the edge tell have their curves from there (`remembered_fit`), in the place
of all these.
"""

from collections.abc import Hashable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from trueloop.geometry.profile import Profile
from trueloop.turned.fit.arc_fit import fit_arcs, fit_bent
from trueloop.turned.fit.chain import Chain, TangentPolicy, chains_of
from trueloop.turned.fit.chain_fit import ChainFit, ChainTouches, Sources, touches_of
from trueloop.turned.fit.choose import ModelChoice, NoseOnPart, choose
from trueloop.turned.fit.conditions import chain_conditions
from trueloop.turned.fit.line_fit import fit_lines
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.prior.gauged_fit import fit_gauged, is_supported
from trueloop.turned.fit.prior.part_state import part_state
from trueloop.turned.fit.prior.remembered import Remembered
from trueloop.turned.fit.prior.remembered_fit import fit_remembered
from trueloop.turned.fit.prior.untouched_fit import fit_untouched
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors

Known: TypeAlias = dict[Hashable, ChainFit]
"""Fits of single chains by all that they depend on: whoever fits many subsets of the touches makes each once."""


def fit_chains(
    profile: Profile,
    vectors: ErrorVectors,
    options: FitOptions,
    nose: NoseOnPart | None,
    known: Known | None = None,
    remembered: Remembered | None = None,
) -> tuple[dict[int, ChainFit], tuple[ModelChoice, ...]]:
    """Fits of every chain by its index, in the profile's order, and the choices between own curve and nose model."""
    chains = chains_of(profile)
    fits, choices = fit_touched(profile, vectors, options, nose, known, remembered)
    if vectors.seen:
        return _with_gauged(profile, vectors, options, fits), choices
    for i in sorted(set(range(len(chains))) - set(fits), key=lambda i: chains[i].curved):
        conditions, sources = chain_conditions(profile, chains, i, fits, options)
        own = fit_untouched(profile, chains[i], vectors, conditions, sources, fits)
        fits[i] = _recalled(profile, vectors, own, options, remembered) or own
    return {i: fits[i] for i in range(len(chains))}, choices


def _with_gauged(
    profile: Profile, vectors: ErrorVectors, options: FitOptions, touched: dict[int, ChainFit]
) -> dict[int, ChainFit]:
    """Returns the fits of all chains: those without a touch take values from touched neighbours alone, else from
    readings.
    """
    chains, state = chains_of(profile), part_state(profile, vectors)
    fits, tangent = dict(touched), replace(options, junctions=TangentPolicy.PATH)
    for i in sorted(set(range(len(chains))) - set(touched), key=lambda i: chains[i].curved):
        of_touched = chain_conditions(profile, chains, i, touched, options)
        ends = chain_conditions(profile, chains, i, fits, tangent)[0] if chains[i].curved else of_touched[0]
        supported = is_supported(profile, chains[i], vectors, state)
        bends = not set(_names(profile, chains[i])).intersection(options.straight)
        fits[i] = fit_gauged(profile, chains[i], vectors, state, ends, of_touched, supported, bends)
    fits[0] = replace(fits[0], notes=(*fits[0].notes, *state.contradicted()))
    return {i: fits[i] for i in range(len(chains))}


def fit_touched(
    profile: Profile,
    vectors: ErrorVectors,
    options: FitOptions,
    nose: NoseOnPart | None,
    known: Known | None = None,
    remembered: Remembered | None = None,
) -> tuple[dict[int, ChainFit], tuple[ModelChoice, ...]]:
    """Fits the chains with a touch: those without one have no part in them. `known` is added to."""
    chains = chains_of(profile)
    with_touches = set(vectors.feature_index[~vectors.by_gauge].tolist())
    touched = [i for i, chain in enumerate(chains) if with_touches.intersection(chain.features)]
    fits: dict[int, ChainFit] = {}
    choices: list[ModelChoice] = []
    for i in sorted(touched, key=lambda i: chains[i].curved):
        conditions, sources = chain_conditions(profile, chains, i, fits, options)
        own = _touched(profile, chains[i], vectors, options, conditions, sources, {} if known is None else known)
        recalled = _recalled(profile, vectors, own, options, remembered)
        fits[i] = recalled or own
        free = recalled is None and chains[i].curved and not _held(profile, chains[i], options)
        if nose is not None and free and np.any(np.isin(nose.positions, own.touches)):
            fits[i], choice = choose(profile, vectors, own, nose, options.junctions)
            choices.append(choice)
    return {i: fits[i] for i in touched}, tuple(choices)


def _recalled(
    profile: Profile, vectors: ErrorVectors, own: ChainFit, options: FitOptions, remembered: Remembered | None
) -> ChainFit | None:
    """Returns the fit of a chain with the remembered errors; None where nothing is remembered, or the user prescribes
    its ends.
    """
    if remembered is None or _held(profile, own.chain, options) or not remembered.knows(own.chain):
        return None
    straight = bool(set(_names(profile, own.chain)).intersection(options.straight))
    return fit_remembered(profile, vectors, own, remembered, options.junctions, straight=straight)


def _held(profile: Profile, chain: Chain, options: FitOptions) -> bool:
    return any(name in options.prescribed for name in _names(profile, chain))


def _names(profile: Profile, chain: Chain) -> list[str]:
    return [profile.features[i].name for i in chain.features]


def _touched(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    options: FitOptions,
    conditions: EndConditions,
    sources: Sources,
    known: Known,
) -> ChainFit:
    """Returns the fit, or the known one to the same touches: these may stand at other positions there."""
    touches = touches_of(profile, chain, vectors)
    places = tuple(len(places_mm) for places_mm in touches.by_feature_mm)
    key = (chain, touches.arc_length_mm.tobytes(), touches.error_mm.tobytes(), places, conditions, sources)
    if key not in known:
        known[key] = _fitted(profile, chain, touches, options, conditions, sources)
    return replace(known[key], touches=touches.positions)


def _fitted(
    profile: Profile,
    chain: Chain,
    touches: ChainTouches,
    options: FitOptions,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    names = _names(profile, chain)
    if chain.curved:
        return fit_arcs(names, chain, touches, options, conditions, sources)
    straight = fit_lines(" and ".join(names), chain, touches, options.junctions, conditions, sources)
    if options.knot_every is not None or set(names).intersection(options.straight):
        return straight
    return fit_bent(names, chain, touches, options, sources, straight) or straight
