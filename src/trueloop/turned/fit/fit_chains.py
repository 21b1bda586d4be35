"""All chains of a profile, in the order in which they prescribe to each other.

Touched lines come first; touched arcs take their end values (and slopes, under the policy PATH) from them; chains
without a touch have what all touches and readings together show (`prior.from_state`), through the values of touched
tangent neighbours. Chains that earlier parts of the edge show have their curves from there (`prior.remembered_fit`), in
the place of all these.
"""

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from trueloop.geometry.profile import Profile
from trueloop.turned.fit.arc_fit import fit_arcs, fit_bent
from trueloop.turned.fit.chain import Chain, TangentPolicy, chains_of
from trueloop.turned.fit.chain_fit import ChainFit, ChainTouches, Sources, own_fit, touches_of
from trueloop.turned.fit.choose import ModelChoice, NoseOnPart, choose
from trueloop.turned.fit.conditions import chain_conditions
from trueloop.turned.fit.knots import Knots, fit_determined, joint_repeats
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.prior.from_state import fit_from_state
from trueloop.turned.fit.prior.part_state import PartState
from trueloop.turned.fit.prior.remembered import Remembered
from trueloop.turned.fit.prior.remembered_fit import fit_remembered
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import wording

Known: TypeAlias = dict[Hashable, ChainFit]
"""Fits of single chains by all that they depend on: whoever fits many subsets of the touches makes each once."""


def fit_chains(
    profile: Profile,
    vectors: ErrorVectors,
    options: FitOptions,
    nose: NoseOnPart | None,
    state: Callable[[], PartState],
    known: Known | None = None,
    remembered: Remembered | None = None,
) -> tuple[dict[int, ChainFit], tuple[ModelChoice, ...]]:
    """Fits of every chain by its index, in the profile's order, and the choices between own curve and nose model.

    `state` makes that of the part: called where some chain has no touch, or readings were taken.
    """
    chains = chains_of(profile)
    touched, choices = fit_touched(profile, vectors, options, nose, known, remembered)
    fits, tangent = dict(touched), replace(options, junctions=TangentPolicy.PATH)
    rest = sorted(set(range(len(chains))) - set(touched), key=lambda i: chains[i].curved)
    for i in rest:
        of_touched = chain_conditions(profile, chains, i, touched, options)
        ends = chain_conditions(profile, chains, i, fits, tangent)[0] if chains[i].curved else of_touched[0]
        bends = not set(_names(profile, chains[i])).intersection(options.straight)
        own = fit_from_state(profile, chains[i], state(), ends, of_touched, fits, bends)
        conditions, sources = chain_conditions(profile, chains, i, fits, options)
        beside = replace(own, fit=replace(own.fit, conditions=conditions), sources=sources)
        fits[i] = _recalled(profile, vectors, beside, options, remembered) or own
    if vectors.seen:
        fits[0] = replace(fits[0], notes=(*fits[0].notes, *state().contradicted()))
    return {i: fits[i] for i in range(len(chains))}, choices


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


SHORT_SPAN: Final = 0.1
"""Touches that span less than this share of a line say nothing of its slope: drawn out to the ends, their scatter would
be multiplied by ten and more. The line gets a constant."""


def fit_lines(
    name: str,
    chain: Chain,
    touches: ChainTouches,
    policy: TangentPolicy,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    """Fits a straight line; a constant where the touches carry no more. Lines in line with each other are fitted as
    one.

    Under the policy PART the line may bend where one feature ends and the next begins, under PATH it may not.
    """
    s = touches.arc_length_mm
    short = len(s) > 1 and float(np.ptp(s)) < SHORT_SPAN * chain.length_mm and not conditions.count
    degree = 0 if short else 1
    repeats = joint_repeats(policy, degree)
    knots = Knots((), chain.joints_mm if repeats > 0 else (), repeats)
    fit, _ = fit_determined(s, touches.error_mm, knots, chain.length_mm, degree, conditions)
    note = wording("straight line through {n} touches by least squares", n=len(s))
    if short:
        note = wording("{n} touches span less than a tenth of the length: their mean, no slope", n=len(s))
    elif fit.spline.degree == 0:
        note = wording(
            "one touch: its error holds for the whole feature, a taper cannot be seen, nor whether the touch is bad"
        )
    elif len(s) == 2:
        note = wording("straight line through its two touches: a bad one would look like a taper")
    return own_fit(chain, touches, fit, sources, wording("{feature}: {note}", feature=name, note=note))
