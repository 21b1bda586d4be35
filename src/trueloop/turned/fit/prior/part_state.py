"""The errors of one part anywhere, from its touches and readings, by the state of all terms (`estimate`).

A touch sees the error at its place, less the reference's share where the part's z was taken from a touch; a reading
sees a weighted sum of errors (`touches.error_vectors`). All are linear in the terms, so that the error at any place has
a mean and a covariance, on features that were measured and on those that were not. Many touches of one feature are
averaged over short stretches, by the same linear rule: a scan of thousands of points costs what some hundred touches
do.

The error of the next part of a series that was measured finished, by all of its parts.

Errors are those had nothing been corrected. The level of the parts walks, and what wears goes on: the state has both
(`estimate.catalogue`), with sizes that the parts before the latest show. A plain mean over earlier parts would lag
behind the wear; the latest part alone would hand its own clamping and its reading to the next.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from trueloop.arrays import Array
from trueloop.estimate.catalogue import PRIORS, Catalogue, turned_catalogue
from trueloop.estimate.history import after_parts
from trueloop.estimate.places import Observed, Places, joined
from trueloop.estimate.sizes import fitted_sizes
from trueloop.estimate.state import Normal, State, Updated
from trueloop.geometry.profile import Profile
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um

STRETCHES: Final = 40
"""Touches of one feature beyond so many are averaged over as many stretches."""

BY_DEFINITION_MM: Final = 1e-7
"""Standard uncertainty of a reading that holds by definition: a thousandth of a reading's last digit."""

CONTRADICTED: Final = 0.5
"""A reading that is a gross error with more than this probability is named."""

ROUND_RAD: Final = 0.1
"""Contact angles reach a multiple of this."""


@dataclass(frozen=True, eq=False)
class PartState:
    """The state of one part after its touches and readings; `names` are those of the values that it was given."""

    profile: Profile
    vectors: ErrorVectors
    names: tuple[str, ...]
    observed: Observed
    updated: Updated

    def contradicted(self) -> tuple[str, ...]:
        """Describes the readings that all other values contradict."""
        first = len(self.names) - len(self.vectors.seen)
        found = [k for k in range(first, len(self.names)) if self.updated.gross[k] > CONTRADICTED]
        return tuple(
            f"{self.names[k]}: an error of {Um(float(self.observed.value_mm[k]), '+.1f')}, where the others predict "
            f"{Um(float(self.observed.value_mm[k] - self.updated.left_out_mm[k]), '+.1f')} with a standard uncertainty "
            f"of {Um(float(self.updated.left_out_u_mm[k]))}. Read it again"
            for k in found
        )

    def at(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Normal:
        """Errors of the measured cut at places (n,), relative to the reference touch where z was taken from one."""
        return _at(self.updated.state, self.profile, self.vectors, feature_index, arc_length_mm)

    def explained(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> float:
        """Returns the largest share of the prior variance, over places (n,), that the measurements have taken away."""
        state = self.updated.state
        before = _at(
            State.before(state.catalogue, state.sizes), self.profile, self.vectors, feature_index, arc_length_mm
        )
        after = self.at(feature_index, arc_length_mm)
        return float(np.max(1.0 - np.diag(after.covariance_mm2) / np.diag(before.covariance_mm2)))


def part_state(profile: Profile, vectors: ErrorVectors, fitted: bool = True) -> PartState:
    """Returns the state given all touches and readings of a part, with sizes of the terms as these show them.

    `fitted`: False leaves the sizes at the medians of their priors, in a hundredth of the time.
    """
    names, observed = observed_of(profile, vectors)
    catalogue = catalogue_of(profile)
    sizes = fitted_sizes(catalogue, [observed]) if fitted else catalogue.medians
    return PartState(profile, vectors, names, observed, State.before(catalogue, sizes).given(observed))


def catalogue_of(profile: Profile, drifting: bool = False) -> Catalogue:
    """Returns the terms for the contact angles of a profile."""
    angle = _angles(profile)
    low, high = ROUND_RAD * math.floor(angle.min() / ROUND_RAD), ROUND_RAD * math.ceil(angle.max() / ROUND_RAD)
    return turned_catalogue(low, high, drifting)


def places_on(profile: Profile, feature_index: NDArray[np.intp], arc_length_mm: Array, part: float = 0.0) -> Places:
    """Places (n,) of the measured cut as terms know them, of the `part`-th part; z from the middle of the part."""
    lasting = dict.fromkeys(("tool", "edge", "setting", "part_type", "finish"), 0.0)
    same = {**lasting, "part": part, "age": part, "order": part}
    group, share = profile.in_groups(feature_index, arc_length_mm)
    point_mm = np.empty((len(arc_length_mm), 2))
    for i in np.unique(feature_index).tolist():
        mine = feature_index == i
        point_mm[mine] = profile.features[i].point_mm(arc_length_mm[mine])
    own = {
        "group": group,
        "contact_angle_rad": profile.contact_angle_rad(feature_index, arc_length_mm),
        "radius_mm": point_mm[:, 0],
        "z_mm": point_mm[:, 1] - profile.middle_z_mm,
        "share": share,
        "taken_off_mm": np.zeros(len(point_mm)),
    }
    return Places({**{name: np.full(len(point_mm), value) for name, value in same.items()}, **own})


def _angles(profile: Profile) -> Array:
    ends = [profile.contact_along_rad(i, [0.0, f.length_mm]) for i, f in enumerate(profile.features)]
    return np.concatenate([np.zeros(1), *ends])


def _at(
    state: State, profile: Profile, vectors: ErrorVectors, feature_index: NDArray[np.intp], arc_length_mm: Array
) -> Normal:
    return state.predict(*in_frame(profile, vectors, feature_index, arc_length_mm), repeatability=False)


def in_frame(
    profile: Profile, vectors: ErrorVectors, feature_index: NDArray[np.intp], arc_length_mm: Array, part: float = 0.0
) -> tuple[Places, Array]:
    """Returns places and the functional of their errors that a part's frame shows at n places of its profile.

    N = n, and the functional is 1, where z is as reported; where z was taken from a touch, that is the last of the
    N = n + 1 places, and what its error shifts is taken off: (n, N).
    """
    places, k = places_on(profile, feature_index, arc_length_mm, part), np.flatnonzero(vectors.at_reference)[:1]
    if not len(k):
        return places, np.eye(len(places))
    pairs = zip(feature_index.tolist(), arc_length_mm.tolist(), strict=True)
    normal_z = np.array([profile.features[i].outward_normal(s)[1] for i, s in pairs])
    own = places_on(profile, vectors.feature_index[k], vectors.arc_length_mm[k], part)
    return joined([places, own]), np.column_stack([np.eye(len(places)), -normal_z / vectors.outward_normal[k[0], 1]])


def observed_of(profile: Profile, vectors: ErrorVectors, part: float = 0.0) -> tuple[tuple[str, ...], Observed]:
    """Returns the touches and readings of the `part`-th part as observations, and their names."""
    touched = vectors.chosen(np.flatnonzero(~vectors.by_gauge & ~vectors.at_reference))
    index = np.concatenate(
        [touched.feature_index, *(observation.feature_index for observation in vectors.seen)]
    ).astype(np.intp)
    along = np.concatenate([touched.arc_length_mm, *(observation.arc_length_mm for observation in vectors.seen)])
    places, count = places_on(profile, index, along, part), len(touched.point)
    mean = _averaging(touched)
    rows = len(mean)
    functional = np.zeros((rows + len(vectors.seen), len(index)))
    functional[:rows, :count] = mean
    at = count
    for row, observation in enumerate(vectors.seen, rows):
        functional[row, at : at + len(observation.weight)] = observation.weight
        at += len(observation.weight)
    seen_u = [observation.standard_u_mm or BY_DEFINITION_MM for observation in vectors.seen]
    value = np.concatenate([mean @ touched.error_mm, [observation.value_mm for observation in vectors.seen]])
    names = (
        *(touched.point[np.flatnonzero(row)[0]] for row in mean),
        *(observation.name for observation in vectors.seen),
    )
    reference = np.flatnonzero(vectors.at_reference)
    if not len(reference):
        u = np.concatenate([np.sqrt(mean**2 @ touched.standard_u_mm**2), seen_u])
        return names, Observed(places, value, u, functional)
    k = int(reference[0])
    all_share = vectors.outward_normal[:, 1] / vectors.outward_normal[k, 1]
    keep = np.flatnonzero(~vectors.by_gauge & ~vectors.at_reference)
    share = np.concatenate([mean @ all_share[keep], np.zeros(len(vectors.seen))])
    u = np.concatenate([np.sqrt(mean**2 @ vectors.own_u_mm[keep] ** 2), seen_u])
    shared = vectors.standard_u_mm[k] * share
    own = places_on(profile, vectors.feature_index[[k]], vectors.arc_length_mm[[k]], part)
    with_reference = np.column_stack([functional, -share])
    return names, Observed(joined([places, own]), value, u, with_reference, np.outer(shared, shared))


def _averaging(touched: ErrorVectors) -> Array:
    """Returns the means that stand for touches, (m, n): of each itself, or over stretches of a feature with many."""
    rows = list[Array]()
    for feature in np.unique(touched.feature_index):
        mine = touched.of_feature(int(feature))
        for part in np.array_split(mine, min(len(mine), STRETCHES)):
            row = np.zeros(len(touched.point))
            row[part] = 1.0 / len(part)
            rows.append(row)
    return np.array(rows).reshape(len(rows), len(touched.point))


WEAR_MM: Final = PRIORS["wear"].median
"""Wear to be expected, a part: an edge that wears leaves material on, along every normal."""

FITTED_PARTS: Final = 8
"""The largest number of parts to which sizes are fitted."""

BY_CHANCE: Final = 1e-3
"""A part that differs from the parts before it by so much that chance makes less than this share of parts do so is of
another series: the tool was set, or an insert changed."""


@dataclass(frozen=True, eq=False)
class SeriesState:
    """The state after the `parts` of a series, of which `vectors` is the latest."""

    profile: Profile
    vectors: ErrorVectors
    state: State
    parts: int

    def next_part(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Normal:
        """Predicts the errors of the next part at places (n,), its own scatter included."""
        places, functional = in_frame(self.profile, self.vectors, feature_index, arc_length_mm, float(self.parts))
        found = self.state.predict(places, functional)
        return Normal(found.mean_mm + functional @ _worn_mm(places), found.covariance_mm2)

    @property
    def wear_rate_mm(self) -> tuple[float, float]:
        """Returns the wear a part, and its standard uncertainty."""
        (where,) = (at for key, at in self.state.blocks.items() if key[0] == "wear rate")
        return WEAR_MM + float(self.state.mean[where][0]), float(np.sqrt(self.state.covariance[where, where][0, 0]))


def series_state(profile: Profile, parts: Sequence[ErrorVectors]) -> SeriesState | None:
    """Returns the state after two parts or more, in cutting order; None: the latest contradicts those before."""
    observed = [_unworn(observed_of(profile, one, float(k))[1]) for k, one in enumerate(parts)]
    catalogue = catalogue_of(profile, drifting=True)
    sizes = fitted_sizes(catalogue, observed[:-1][-FITTED_PARTS:])
    updated = after_parts(catalogue, sizes, [[one] for one in observed[:-1]]).state.given(observed[-1])
    off = updated.innovation
    squares = float(off.mean_mm @ np.linalg.solve(off.covariance_mm2, off.mean_mm))
    if chdtrc(len(off.mean_mm), squares) < BY_CHANCE:
        return None
    return SeriesState(profile, parts[-1], updated.state, len(parts))


def _worn_mm(places: Places) -> Array:
    """Returns the wear to be expected before any part was measured, (n,)."""
    return WEAR_MM * places.number("age")


def _unworn(observed: Observed) -> Observed:
    return replace(observed, value_mm=observed.value_mm - observed.of(_worn_mm(observed.places)))
