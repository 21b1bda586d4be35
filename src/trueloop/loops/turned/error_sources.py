"""The sources of each feature's error: which share of it each group of terms of the state has.

What is shared out is the error that the next cut would have, had nothing been corrected: of the state of the part, or,
where earlier parts of the edge take part, of the state that they and this part's touches make. Every share is linear in
the state, so that the shares add up to the error, and each has its uncertainty. Shares of like effect are separated by
their priors alone as long as one part was measured (a tool set off and a part zero off displace it alike): their
uncertainties then are larger than that of their sum.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.estimate.places import Places
from trueloop.estimate.state import State
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.deviations import places_at
from trueloop.memory.edge.learnt import cut_of, known_edge
from trueloop.memory.made_part import MadePart
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.fit.between_cuts import NONE, BetweenCuts
from trueloop.turned.fit.prior.part_state import in_frame, part_state
from trueloop.turned.touches.error_vectors import ErrorVectors

ALONG: Final = 9
"""Places at which a source is followed along a feature; a feature without a measured place is averaged over them."""


class Source(StrEnum):
    """A source of error, as a cause that a shop can act on."""

    MACHINE = "machine"
    SETTING = "tool setting"
    NOSE = "nose"
    PART = "part"
    NEXT_CUT = "next cut"
    MEASURING = "measuring"


TERMS: Final = {
    Source.SETTING: ("setting", "setting of the tool", "part zero"),
    Source.NOSE: ("nose", "nose of the tool", "short nose"),
    Source.PART: (
        "clamping",
        "form of the part",
        "short form of the part",
        "taper",
        "taper of the part",
        "near the axis",
        "form along",
        "group",
        "group of the part",
        "tilt of the part",
    ),
    Source.NEXT_CUT: (
        "finish level",
        "finish form",
        "finish level of the tool",
        "finish form of the tool",
        "finish form of the type",
        "finish clamping",
        "finish form of the part",
        "finish group of the part",
    ),
}
"""The terms of each source. The gain has a share in none: it acts on what a correction takes off."""


@dataclass(frozen=True)
class Share:
    """The share of one source in the error of a feature, along its outward normal: positive where it leaves material.

    `mean_mm` over the feature's measured places, or over the whole feature where there are none, with its standard
    uncertainty; `low_mm` and `high_mm`: the least and the largest along the feature.
    """

    source: Source
    mean_mm: float
    standard_u_mm: float
    low_mm: float
    high_mm: float


@dataclass(frozen=True)
class FeatureSources:
    """The shares of all sources of one feature, by its index, and their sum without that of measuring.

    Measuring is by how much the feature's measured mean is off its error as all measurements show it.
    """

    index: int
    shares: tuple[Share, ...]
    together_mm: float
    together_u_mm: float


@dataclass(frozen=True, eq=False)
class MachineShare:
    """The machine's errors in the next cut at the gauging points, (n,), with their standard uncertainties, mm."""

    error_mm: Array
    standard_u_mm: Array


def error_sources(
    model: ProfileErrorModel,
    between: BetweenCuts,
    earlier: tuple[Sequence[MadePart], MadePart] | None,
    machine: MachineShare | None,
) -> tuple[FeatureSources, ...]:
    """Returns the shares of every feature, in the profile's order.

    `earlier`: earlier parts of the edge and this part before its finish cut, where the correction is by them too;
    without them the next cut is taken to differ by `between`.
    """
    known = _of_part(model, between) if earlier is None else _of_edge(model, *earlier)
    return tuple(_of_feature(known, model, machine, i) for i in range(len(model.curves)))


@dataclass(frozen=True, eq=False)
class _PartKnowledge:
    """A state, the places of a part as it knows them, and the difference of the next cut that it has no terms for.

    `places` returns, of features, arc lengths, and whether of the finish cut, the places (N,) and the functional (n, N)
    of their errors that the part's frame shows.
    """

    state: State
    places: Callable[[NDArray[np.intp], Array, bool], tuple[Places, Array]]
    between: BetweenCuts


def _of_part(model: ProfileErrorModel, between: BetweenCuts) -> _PartKnowledge:
    vectors = _fitted(model)

    def places(index: NDArray[np.intp], along_mm: Array, finish: bool) -> tuple[Places, Array]:
        del finish  # the next cut is as this one, but for what is taken for the difference of two cuts
        return in_frame(model.profile, vectors, index, along_mm)

    return _PartKnowledge(part_state(model.profile, vectors).updated.state, places, between)


def _fitted(model: ProfileErrorModel) -> ErrorVectors:
    """Returns the touches and readings that the fit uses; the reference touch always, as z counts from it."""
    used = (model.weight > 0.0) | model.vectors.at_reference
    left_out = {point for point, kept in zip(model.vectors.point, used.tolist(), strict=True) if not kept}
    seen = tuple(observation for observation in model.vectors.seen if observation.name not in left_out)
    return replace(model.vectors.chosen(np.flatnonzero(used)), seen=seen)


def _of_edge(model: ProfileErrorModel, history: Sequence[MadePart], today: MadePart) -> _PartKnowledge:
    everywhere = np.repeat(np.arange(len(model.curves), dtype=np.intp), ALONG)
    along = np.concatenate([_along(model.profile, i) for i in range(len(model.curves))])
    known = known_edge(history, today, places_at(model.profile, everywhere, along, model.vectors))
    touched = cut_of(today, known.age, today.semifinish, False, None)

    def places(index: NDArray[np.intp], along_mm: Array, finish: bool) -> tuple[Places, Array]:
        at, functional = known.places(places_at(model.profile, index, along_mm, model.vectors), finish)
        return at, np.eye(len(index)) if functional is None else functional

    return _PartKnowledge(known.state.given(touched).state if len(touched) else known.state, places, NONE)


def _along(profile: Profile, index: int) -> Array:
    return np.linspace(0.0, profile.features[index].length_mm, ALONG)


def _of_feature(
    part: _PartKnowledge, model: ProfileErrorModel, machine: MachineShare | None, index: int
) -> FeatureSources:
    rows = model.vectors.of_feature(index)
    rows = rows[~model.vectors.at_reference[rows] & (model.weight[rows] > 0.0)]
    along = _along(model.profile, index)
    at = model.vectors.arc_length_mm[rows] if len(rows) else along
    every = np.concatenate([at, along])
    places, functional = part.places(np.full(len(every), index, dtype=np.intp), every, True)
    mean = np.concatenate([np.full(len(at), 1.0 / len(at)), np.zeros(ALONG)]) @ functional
    state = part.state.expecting(places)
    shares = [_share(state, places, (mean, functional[len(at) :]), source) for source in TERMS]
    normal = np.array([model.profile.features[index].outward_normal(float(s)) for s in at])
    differs = float(part.between.covariance_mm2(normal, np.full((1, len(at)), 1.0 / len(at)), np.eye(len(at)))[0, 0])
    shares = [_wider(share, differs) if share.source is Source.NEXT_CUT else share for share in shares]
    whole = state.predict(places, mean[None, :], repeatability=False)
    together, variance = float(whole.mean_mm[0]), float(whole.covariance_mm2[0, 0]) + differs
    if machine is not None and len(rows):
        own, u = machine.error_mm[rows], float(np.mean(machine.standard_u_mm[rows]))
        shares.insert(0, Share(Source.MACHINE, float(np.mean(own)), u, float(np.min(own)), float(np.max(own))))
        together, variance = together + shares[0].mean_mm, variance + u**2
    if len(rows):
        shares.append(_measuring(part, model, rows))
    return FeatureSources(index, tuple(shares), together, math.sqrt(variance))


def _share(state: State, places: Places, functionals: tuple[Array, Array], source: Source) -> Share:
    mean, along = functionals
    found = state.predict(places, np.vstack([mean, along]), TERMS[source], repeatability=False)
    values = found.mean_mm[1:]
    return Share(
        source, float(found.mean_mm[0]), float(found.standard_u_mm[0]), float(np.min(values)), float(np.max(values))
    )


def _wider(share: Share, variance_mm2: float) -> Share:
    return replace(share, standard_u_mm=math.sqrt(share.standard_u_mm**2 + variance_mm2))


def _measuring(part: _PartKnowledge, model: ProfileErrorModel, rows: NDArray[np.intp]) -> Share:
    """Returns the measured errors less those of the measured cut as the state has them."""
    vectors = model.vectors
    places, functional = part.places(vectors.feature_index[rows], vectors.arc_length_mm[rows], False)
    state = part.state.expecting(places)
    off = vectors.error_mm[rows] - state.predict(places, functional, repeatability=False).mean_mm
    scatter = state.sizes["repeatability"] ** 2
    u = math.sqrt(float(np.sum(vectors.standard_u_mm[rows] ** 2 + scatter))) / len(rows)
    return Share(Source.MEASURING, float(np.mean(off)), u, float(np.min(off)), float(np.max(off)))
