"""The measurements of a part that lower most, a minute, what is not known of its next cut.

A candidate is a functional h of the errors with an instrument of standard uncertainty u. Measured, it takes
(C h)(C h)ᵀ / (hᵀ C h + u²) from the covariance C of the coefficients, whatever its value: the gain is known beforehand.
The candidate with the largest gain a minute is taken, then the next one given that it is measured. A drawing with
limits decides by the probability that the next part is out of these; else the mean square of the error along the
contour does. The means do not count: a correction takes them out.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.estimate.places import Observed, Places
from trueloop.estimate.state import State
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.deviations import places_at
from trueloop.memory.edge.learnt import known_edge, observed, places_of
from trueloop.memory.edge.predict import latest
from trueloop.memory.made_part import MadePart
from trueloop.tolerances.conformance import judge
from trueloop.turned.characteristics.judging import DRAWS, alike_along
from trueloop.turned.characteristics.measurand import measurand
from trueloop.turned.fit.between_cuts import NONE, BetweenCuts
from trueloop.turned.fit.prior.part_state import BY_DEFINITION_MM, PartState, SeriesState, in_frame
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen

Instrument: TypeAlias = Literal["probe", "micrometer", "cmm"]

PLACES: Final = 9
"""Places of each feature at which the error of the contour is weighed."""

OUT: Final = 1e-3
"""No measurement is needed for characteristics that are out of their limits with less than this probability."""

WORTHWHILE: Final = 0.02
"""A measurement that lowers the root mean square of the next part's error by a smaller share is not needed."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A measurement that can be taken, `seen` as errors of the contour; `minutes` it takes; `feature` of the part."""

    seen: Seen
    feature: str
    instrument: Instrument
    minutes: float


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors at n places of the cut that is measured and of the next one: (n, m) times coefficients of this covariance
    (m, m), and independent of these what places scatter by, (n,).
    """

    covariance: Array
    measured: Array
    following: Array
    scatter_mm2: Array
    following_mm2: Array


class EdgeState(Protocol):
    """Knowledge of an edge's errors; `between`: the additional difference of the next cut."""

    @property
    def between(self) -> BetweenCuts:
        """Returns it."""

    def errors(self, index: NDArray[np.intp], along: Array) -> Errors:
        """Returns them at places (n,) of the edge's profile."""


@dataclass(frozen=True, eq=False)
class OfPart:
    """Knowledge from one part's touches and readings; the next cut repeats the errors of the measured one."""

    state: PartState
    between: BetweenCuts

    def errors(self, index: NDArray[np.intp], along: Array) -> Errors:
        """Returns them at places (n,) of the edge's profile."""
        measured = in_frame(self.state.profile, self.state.vectors, index, along)
        return _errors(self.state.updated.state, measured, measured)


@dataclass(frozen=True, eq=False)
class OfSeries:
    """Knowledge from finished parts of a series; the latest is the measured one, the next cut that of another part."""

    series: SeriesState
    between: BetweenCuts = NONE

    def errors(self, index: NDArray[np.intp], along: Array) -> Errors:
        """Returns them at places (n,) of the edge's profile."""
        of, latest_part = self.series, float(self.series.parts - 1)
        measured, following = (in_frame(of.profile, of.vectors, index, along, latest_part + k) for k in (0.0, 1.0))
        return _errors(of.state, measured, following)


@dataclass(frozen=True, eq=False)
class OfHistory:
    """Knowledge from earlier parts and `part` before its finish cut, the next one; if measured, of another part."""

    profile: Profile
    vectors: ErrorVectors
    part: MadePart
    age: float
    state: State
    between: BetweenCuts = NONE

    @classmethod
    def of(cls, profile: Profile, vectors: ErrorVectors, history: Sequence[MadePart], part: MadePart) -> "OfHistory":
        """Takes in earlier parts of the edge in cutting order, then the part's readings before its finish cut."""
        taken = set() if part.semifinish is None else {*part.semifinish.point}
        ends = [np.array([0.0, feature.length_mm]) for feature in profile.features]
        index = np.repeat(np.arange(len(ends)), 2)
        known = known_edge(latest(history, part.part_type), part, places_at(profile, index, np.hstack(ends), vectors))
        state = known.state
        for cut in observed(part, known.age):
            state = state.given(cut).state
        for observation in (seen for seen in vectors.seen if seen.name not in taken):
            at = places_at(profile, observation.feature_index, observation.arc_length_mm, vectors.chosen([]))
            places, _ = places_of(part, known.age, at, False)
            u_mm = np.array([observation.standard_u_mm or BY_DEFINITION_MM])
            state = state.given(
                Observed(places, np.array([observation.value_mm]), u_mm, observation.weight[None, :])
            ).state
        return cls(profile, vectors, part, known.age, state)

    def errors(self, index: NDArray[np.intp], along: Array) -> Errors:
        """Returns them at places (n,) of the edge's profile."""
        at, finished = places_at(self.profile, index, along, self.vectors), self.part.finish is not None
        after = replace(self.part, order=self.part.order + float(finished))
        measured = places_of(self.part, self.age, at, finished)
        return _errors(self.state, measured, places_of(after, self.age + float(finished), at, True))


def _errors(state: State, measured: tuple[Places, Array | None], following: tuple[Places, Array | None]) -> Errors:
    """Returns the errors at places of the measured and the next cut; each with the functional of them that is seen."""
    whole = state.expecting(measured[0]).expecting(following[0])
    rows = [
        whole.design(places) if functional is None else functional @ whole.design(places)
        for places, functional in (measured, following)
    ]
    scatter = [
        whole.catalogue.repeatability_mm2(places, whole.sizes)[: len(row)]
        for (places, _), row in zip((measured, following), rows, strict=True)
    ]
    return Errors(whole.covariance, *rows, *scatter)


@dataclass(frozen=True, eq=False)
class Edge:
    """One edge's part in a plan: its contour, what is known of its errors, and what can be measured yet.

    `characteristics` are of its features, `zero_z_mm` is z of the part's zero, from which lengths count, in the frame
    of the profile; `vectors` are the touches.
    """

    profile: Profile
    vectors: ErrorVectors
    characteristics: tuple[Characteristic, ...]
    zero_z_mm: float
    known: EdgeState
    candidates: tuple[Candidate, ...]


@dataclass(frozen=True)
class NextMeasurement:
    """One measurement of a plan, with what is not known of the next part before and after it (`Plan.criterion`)."""

    name: str
    feature: str
    instrument: Instrument
    minutes: float
    before: float
    after: float


@dataclass(frozen=True)
class Plan:
    """Measurements in the order of their gain a minute.

    `criterion`: "probability_out": the largest probability, over all characteristics with limits, that the next part is
    out of them; "rms_um": the root mean square of the next part's error along the contour, µm. `worst` is the
    characteristic of that probability, "" without limits. `enough`: no further measurement is needed, or none lowers
    what is not known by more than `WORTHWHILE`.
    """

    criterion: Literal["probability_out", "rms_um"]
    before: float
    chosen: tuple[NextMeasurement, ...]
    worst: str
    enough: bool

    @property
    def after(self) -> float:
        """Returns what is not known of the next part when all measurements of the plan are taken."""
        return self.chosen[-1].after if self.chosen else self.before

    @property
    def minutes(self) -> float:
        """Returns how long the measurements take together."""
        return math.fsum(measurement.minutes for measurement in self.chosen)


def next_measurements(edges: Sequence[Edge], count: int) -> Plan:
    """Returns at most `count` measurements, over all edges; fewer where fewer are needed."""
    known = [_EdgeCovariance(edge) for edge in edges]
    limited = any(covariance.limited for covariance in known)
    first, chosen, enough = _worth(known, limited), list[NextMeasurement](), False
    while len(chosen) < count:
        before = _worth(known, limited)
        if limited and before[0] < OUT:
            enough = True
            break
        # The edge and the candidate with the largest gain a minute; None where none is worth its time
        total = math.fsum(edge.at_stake(limited) for edge in known)
        best: tuple[float, int, int] | None = None
        for k, edge in enumerate(known):
            for j, gain in enumerate(edge.gains(limited).tolist()):
                a_minute = gain / edge.edge.candidates[j].minutes
                if gain > 2.0 * WORTHWHILE * total and (best is None or a_minute > best[0]):
                    best = (a_minute, k, j)
        found = None if best is None else best[1:]
        if found is None:
            enough = True
            break
        known[found[0]].measure(found[1])
        candidate, after = known[found[0]].edge.candidates[found[1]], _worth(known, limited)
        chosen.append(
            NextMeasurement(
                name=candidate.seen.name,
                feature=candidate.feature,
                instrument=candidate.instrument,
                minutes=candidate.minutes,
                before=before[0],
                after=after[0],
            )
        )
    last = _worth(known, limited)
    return Plan("probability_out" if limited else "rms_um", first[0], tuple(chosen), last[1], enough)


def _worth(edges: "Sequence[_EdgeCovariance]", limited: bool) -> tuple[float, str]:
    """Returns the largest probability of all characteristics with its name, or the RMS along all contours in µm."""
    if limited:
        return max((one for edge in edges for one in edge.out()), default=(0.0, ""))
    length = math.fsum(edge.length_mm for edge in edges)
    return 1e3 * math.sqrt(math.fsum(edge.next_mm2 * edge.length_mm for edge in edges) / length), ""


class _EdgeCovariance:
    """Knowledge of one edge's errors while a plan is made: the covariance of the coefficients."""

    def __init__(self, edge: Edge) -> None:
        self.edge, profile, between = edge, edge.profile, edge.known.between
        index, along, length = _contour(profile)
        self.length_mm = float(np.sum(length))
        parts = [(candidate.seen.feature_index, candidate.seen.arc_length_mm) for candidate in edge.candidates]
        touches = np.bincount(edge.vectors.feature_index, minlength=len(profile.features)).astype(np.intp)
        sizes = [(asked, measurand(profile, asked, touches, edge.zero_z_mm)) for asked in _limited(edge)]
        parts += [(index, along), *((one.feature_index, one.arc_length_mm) for _, one in sizes)]
        known = edge.known.errors(np.concatenate([a for a, _ in parts]), np.concatenate([b for _, b in parts]))
        self.covariance = known.covariance
        ends = np.cumsum([len(a) for a, _ in parts])
        slices = [slice(end - len(a), end) for end, (a, _) in zip(ends.tolist(), parts, strict=True)]
        count = len(edge.candidates)
        weights = [candidate.seen.weight for candidate in edge.candidates]
        rows = [w @ known.measured[at] for w, at in zip(weights, slices, strict=False)]
        self.rows = np.array(rows).reshape(-1, len(self.covariance))
        own = [float(w**2 @ known.scatter_mm2[at]) for w, at in zip(weights, slices, strict=False)]
        self.noise = np.array([candidate.seen.standard_u_mm**2 for candidate in edge.candidates]) + np.array(own)
        on = slices[count]
        self.along = known.following[on] * np.sqrt(length / self.length_mm)[:, None]
        each = np.eye(len(index))
        varies = between.covariance_mm2(_normals(profile, index, along), each, each)
        self.other_mm2 = float(np.diag(varies).mean() + known.following_mm2[on].mean())
        self.sizes = []
        for (asked, size), at in zip(sizes, slices[count + 1 :], strict=True):
            places = profile, size.feature_index, size.arc_length_mm
            other = between.covariance_mm2(_normals(*places), size.gains, alike_along(*places))
            scatter = size.gains @ np.diag(known.following_mm2[at]) @ size.gains.T
            self.sizes.append((asked, size.nominal, size.gains @ known.following[at], other + scatter))

    @property
    def limited(self) -> bool:
        """Returns whether the drawing has limits for this edge's features."""
        return bool(self.sizes)

    @property
    def next_mm2(self) -> float:
        """Returns the mean square of the next part's error along the contour."""
        return float(np.einsum("ij,jk,ik->", self.along, self.covariance, self.along)) + self.other_mm2

    def out(self) -> list[tuple[float, str]]:
        """Returns the probability of each characteristic to be out of its limits, in any of its places."""
        return [
            (_out_anywhere(asked, nominal, rows @ self.covariance @ rows.T + other), asked.name)
            for asked, nominal, rows, other in self.sizes
        ]

    def at_stake(self, limited: bool) -> float:
        """Returns the sum of probabilities, each in its likeliest place to be out, or mean square times length."""
        if not limited:
            return self.next_mm2 * self.length_mm
        return math.fsum(
            _out(asked, nominal, _variance(rows, self.covariance) + np.diag(other))
            for asked, nominal, rows, other in self.sizes
        )

    def gains(self, limited: bool) -> Array:
        """Returns by how much each candidate lowers `at_stake`, (n,)."""
        seen = self.covariance @ self.rows.T
        variance = np.einsum("ij,ji->i", self.rows, seen) + self.noise
        if not limited:
            return np.asarray(np.sum((self.along @ seen) ** 2, axis=0) / variance * self.length_mm)
        gained = np.zeros(len(variance))
        for asked, nominal, rows, other in self.sizes:
            before = _variance(rows, self.covariance) + np.diag(other)
            less = (rows @ seen) ** 2 / variance
            now = _out(asked, nominal, before)
            gained += [now - _out(asked, nominal, before - less[:, k]) for k in range(len(variance))]
        return gained

    def measure(self, k: int) -> None:
        """Takes candidate k as measured."""
        seen = self.covariance @ self.rows[k]
        self.covariance = self.covariance - np.outer(seen, seen) / float(self.rows[k] @ seen + self.noise[k])


def _limited(edge: Edge) -> list[Characteristic]:
    return [
        characteristic
        for characteristic in edge.characteristics
        if (characteristic.lower_limit is not None or characteristic.upper_limit is not None)
        and characteristic.quantity in (Quantity.DIAMETER, Quantity.LENGTH, Quantity.ANGLE, Quantity.RADIUS)
    ]


def _out(characteristic: Characteristic, nominal: Array, variance: Array) -> float:
    """Returns the probability of the size least likely to be in: its mean is the nominal one after a correction."""
    each = (
        judge(
            float(value), math.sqrt(max(float(v), 1e-18)), None, characteristic.lower_limit, characteristic.upper_limit
        ).probability_in
        for value, v in zip(nominal, variance, strict=True)
    )
    return 1.0 - min(one for one in each if one is not None)


def _out_anywhere(characteristic: Characteristic, nominal: Array, covariance: Array) -> float:
    """Returns the probability that any of the sizes is out, of a covariance (m, m): all have to be in together."""
    least = _out(characteristic, nominal, np.diag(covariance))
    if len(nominal) == 1:
        return least
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn = nominal + np.random.default_rng(0).standard_normal((DRAWS, len(nominal))) @ root.T
    low = -math.inf if characteristic.lower_limit is None else characteristic.lower_limit
    high = math.inf if characteristic.upper_limit is None else characteristic.upper_limit
    return max(least, 1.0 - float(np.mean(np.all((drawn >= low) & (drawn <= high), axis=1))))


def _variance(rows: Array, covariance: Array) -> Array:
    return np.asarray(np.einsum("ij,jk,ik->i", rows, covariance, rows))


def _contour(profile: Profile) -> tuple[NDArray[np.intp], Array, Array]:
    """Returns feature, arc length and the length that it stands for, of places along all features, (n,) each."""
    lengths = np.array([feature.length_mm for feature in profile.features])
    share = (np.arange(PLACES) + 0.5) / PLACES
    index = np.repeat(np.arange(len(lengths), dtype=np.intp), PLACES)
    return index, np.outer(lengths, share).ravel(), np.repeat(lengths / PLACES, PLACES)


def _normals(profile: Profile, index: NDArray[np.intp], along: Array) -> Array:
    pairs = zip(index.tolist(), along.tolist(), strict=True)
    return np.array([profile.features[i].outward_normal(s) for i, s in pairs]).reshape(-1, 2)
