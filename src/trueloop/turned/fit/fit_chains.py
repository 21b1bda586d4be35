"""All chains of a profile, in the order in which they prescribe to each other.

Touched lines come first; touched arcs take their end values (and slopes, under the policy PATH) from them; chains
without a touch have what all touches and readings together show (`prior.from_state`), through the values of touched
tangent neighbours. Chains that earlier parts of the edge show have their curves from there (`prior.remembered_fit`), in
the place of all these.

The end conditions of a chain: from its tangent neighbours, and from the user.

Own curve or nose model: leave-one-out decides for every arc, and both figures are kept.

The own curve knows this part alone; the nose model knows the nose from other parts and takes two offsets from this one.
Many touches favour the first, few the second. The own curve's shape was already chosen by the same figure, which
flatters it: with n touches it must be better by one part in √n.
"""

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.turned.fit.arc_fit import fit_arcs, fit_bent
from trueloop.turned.fit.chain_fit import (
    Chain,
    ChainFit,
    ChainTouches,
    ConditionSource,
    End,
    Knots,
    Sources,
    TangentPolicy,
    chains_of,
    fit_determined,
    joint_repeats,
    own_fit,
    tangent_neighbours,
    touches_of,
)
from trueloop.turned.fit.nose_fit import NoseModel, NosePrediction, NoseTouches, nose_curve, nose_touches
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.prior.from_state import fit_from_state
from trueloop.turned.fit.prior.part_state import PartState
from trueloop.turned.fit.prior.remembered_fit import Remembered, fit_remembered
from trueloop.turned.fit.spline import EndConditions, Spline
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, all_of, wording

UNSEEN_RAD: Final = math.radians(6.0)
"""How much of a chain's contact angles a nose model may leave open at an end: parts are touched about 4° from the ends
of their arcs, and what lies much beyond is drawn out from no knowledge."""


@dataclass(frozen=True)
class ModelChoice:
    """Leave-one-out RMS of both models on the same touches of one curve, and which of them serves.

    `own_rms_mm` is infinite where one touch alone determines something. With too few touches to leave one out of
    the offsets, `nose_rms_mm` is the model's own standard uncertainty of a touch.
    """

    features: tuple[str, ...]
    touches: int
    own_rms_mm: float
    nose_rms_mm: float
    nose_serves: bool

    @property
    def words(self) -> str:
        """Describes the choice and its reason."""
        served = wording("nose model of other parts, with two offsets from this one")
        return wording(
            "{feature}: {served}; leave-one-out RMS over {n} touches: nose model {nose}, own curve {own}",
            feature=all_of(self.features),
            served=served if self.nose_serves else wording("own curve"),
            n=self.touches,
            nose=Um(self.nose_rms_mm, ".2f"),
            own=wording("no figure") if math.isinf(self.own_rms_mm) else Um(self.own_rms_mm, ".2f"),
        )


@dataclass(frozen=True)
class NoseOnPart:
    """A nose model, and the part's touches on arcs that it covers; `positions` are theirs in the error vectors."""

    prediction: NosePrediction
    touches: NoseTouches
    positions: NDArray[np.intp]


def nose_on_part(profile: Profile, vectors: ErrorVectors, nose: NoseModel) -> NoseOnPart:
    """Applies a nose model of other parts to this one. Raises FIT-POINTS when touches do not set the tool offsets."""
    touches = nose_touches("this part", profile, vectors)
    used = touches.on_arc & nose.covers(touches.contact_angle_rad)
    arcs = touches.subset(used)
    return NoseOnPart(nose.predict(arcs), arcs, np.flatnonzero(~vectors.at_reference)[used])


def choose(
    profile: Profile, vectors: ErrorVectors, fit: ChainFit, nose: NoseOnPart, policy: TangentPolicy
) -> tuple[ChainFit, ModelChoice]:
    """Chooses the fit of a chain of arcs, or the nose model's curve in its place where that predicts the touches
    better.

    A nose model that was never seen at some of the chain's contact angles does not serve it: it would guess there.
    """
    mine = np.isin(nose.positions, fit.touches)
    errors = _left_out(nose, mine)
    own = fit.leave_one_out_mm[np.isin(fit.touches, nose.positions[mine])]
    own_rms = float("inf") if np.any(np.isnan(own)) else rms(own)
    nose_rms = rms(errors)
    if math.isnan(nose_rms):
        u = nose.prediction.standard_deviation_mm(nose.touches.contact_angle_rad[mine])
        nose_rms = rms(np.hypot(u, nose.prediction.model.scatter_mm))
    names = tuple(profile.features[i].name for i in fit.chain.features)
    nose_serves = nose_rms < own_rms * (1.0 + 1.0 / math.sqrt(len(errors)))
    choice = ModelChoice(names, len(errors), own_rms, nose_rms, nose_serves)
    unseen_rad = _unseen_rad(profile, fit, nose.prediction.model)
    if unseen_rad > UNSEEN_RAD:
        words = wording(
            "{feature}: the nose model of other parts leaves {open:.0f}° of its contact angles open",
            feature=choice.features[0],
            open=math.degrees(unseen_rad),
        )
        return replace(fit, notes=(*fit.notes, words)), replace(choice, nose_serves=False)
    if not choice.nose_serves:
        return fit, choice
    left_out = np.full(len(fit.touches), np.nan)
    left_out[np.isin(fit.touches, nose.positions[mine])] = errors
    served = nose_curve(profile, vectors, fit, nose.prediction, joint_repeats(policy, 3))
    spare = max(len(fit.touches) - 2, 0)
    return replace(served, leave_one_out_mm=left_out, spare=spare, notes=(choice.words,)), choice


def _unseen_rad(profile: Profile, fit: ChainFit, nose: NoseModel) -> float:
    """Returns by how much contact angles of the chain lie outside the nose's fitted range, at the worse end."""
    ends = [
        float(angle)
        for i in fit.chain.features
        for angle in profile.contact_along_rad(i, [0.0, profile.features[i].length_mm])
    ]
    return max(max(ends) - nose.highest_rad, nose.lowest_rad - min(ends), 0.0)


def _left_out(nose: NoseOnPart, mine: NDArray[np.bool_]) -> Array:
    """Returns the error of predicting each touch with offsets from all the others; NaN where those do not set them."""
    errors = []
    for k in np.flatnonzero(mine):
        others = nose.touches.subset(np.arange(len(mine)) != k)
        try:
            expected = nose.prediction.model.predict(others).value_mm(nose.touches.contact_angle_rad[k])[0]
        except TrueloopError:
            expected = np.nan
        errors.append(nose.touches.error_mm[k] - expected)
    return np.array(errors)


Known: TypeAlias = dict[Hashable, ChainFit]
"""Fits of single chains by all that they depend on: whoever fits many subsets of the touches makes each once."""


def fit_chains(
    profile: Profile,
    vectors: ErrorVectors,
    options: FitOptions,
    nose: NoseOnPart | None,
    state: Callable[[], PartState],
    edge_state: Known | None = None,
    remembered: Remembered | None = None,
) -> tuple[dict[int, ChainFit], tuple[ModelChoice, ...]]:
    """Fits of every chain by its index, in the profile's order, and the choices between own curve and nose model.

    `state` makes that of the part: called where some chain has no touch, or readings were taken.
    """
    chains = chains_of(profile)
    touched, choices = fit_touched(profile, vectors, options, nose, edge_state, remembered)
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
    edge_state: Known | None = None,
    remembered: Remembered | None = None,
) -> tuple[dict[int, ChainFit], tuple[ModelChoice, ...]]:
    """Fits the chains with a touch: those without one have no part in them. `edge_state` is added to."""
    chains = chains_of(profile)
    with_touches = set(vectors.feature_index[~vectors.by_gauge].tolist())
    touched = [i for i, chain in enumerate(chains) if with_touches.intersection(chain.features)]
    fits: dict[int, ChainFit] = {}
    choices: list[ModelChoice] = []
    for i in sorted(touched, key=lambda i: chains[i].curved):
        conditions, sources = chain_conditions(profile, chains, i, fits, options)
        own = _touched(
            profile, chains[i], vectors, options, conditions, sources, {} if edge_state is None else edge_state
        )
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
    """Returns a chain's fit with the remembered errors; None: nothing remembered, or ends prescribed by the user."""
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
    edge_state: Known,
) -> ChainFit:
    """Returns the fit, or the known one to the same touches: these may stand at other positions there."""
    touches = touches_of(profile, chain, vectors)
    places = tuple(len(places_mm) for places_mm in touches.by_feature_mm)
    key = (chain, touches.arc_length_mm.tobytes(), touches.error_mm.tobytes(), places, conditions, sources)
    if key not in edge_state:
        edge_state[key] = _fitted(profile, chain, touches, options, conditions, sources)
    return replace(edge_state[key], touches=touches.positions)


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
    name: str, chain: Chain, touches: ChainTouches, policy: TangentPolicy, conditions: EndConditions, sources: Sources
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


AGREE_MM: Final = 1e-9
"""Prescribed numbers that differ by less are the same, rounded twice."""


def chain_conditions(
    profile: Profile, chains: tuple[Chain, ...], index: int, fits: Mapping[int, ChainFit], options: FitOptions
) -> tuple[EndConditions, Sources]:
    """Returns the conditions that fitted tangent neighbours and the user set to a chain, and each end's source."""
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


def _agreed(name: str, what: str, neighbour: float | None, stated: float | None) -> float | None:
    if neighbour is not None and stated is not None and abs(neighbour - stated) > AGREE_MM:
        raise Code.FIT_CONDITIONS.refusal(
            f"{name}: the {what} is prescribed as {stated * UM_PER_MM:.3f} µm (per mm, for a slope), but the tangent "
            f"neighbour's curve says {neighbour * UM_PER_MM:.3f}",
            hint="leave it out, or declare the junction a corner",
        )
    return stated if neighbour is None else neighbour
