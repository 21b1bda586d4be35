"""The curve of a chain that no probe touched, from the state of the part (`part_state`).

What is expected is the mean given all touches and readings. A chain of which they show nothing stays as programmed. A
line is corrected by a straight line where that is near enough to what is expected, else its curve is carried over to a
cubic spline, as that of any arc is. Neighbours that join tangentially have one value where they meet; an arc has their
slope there too: a kink that nobody measured is not cut, least of all into a fillet, which the nose would not reach.
Where a chain meets a neighbour at a corner, the corner moves along that neighbour by no more than the errors of both
together: a cone at 5° to a cylinder, believed to err by 20 µm more or less than that, would else move the corner by
0.2 mm, out of an uncertainty of as much.
"""

import math
from collections.abc import Mapping
from dataclasses import astuple, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Flags
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.fit.arc_fit import STRAIGHT_MM
from trueloop.turned.fit.chain_fit import Chain, ChainFit, Knots, Sources, fit_determined, own_fit, touches_of
from trueloop.turned.fit.prior.part_state import PartState
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um, all_of, wording

SAMPLES: Final = 13
"""Places along each feature at which the expected error is carried over to a spline."""

SUPPORTED: Final = 0.1
"""A chain of whose variance the measurements explain less than this stays as programmed: nothing is known of it."""

SAME_MM: Final = 5e-5
"""Expected errors that differ by less are written as one."""


def fit_from_state(
    profile: Profile,
    chain: Chain,
    state: PartState,
    ends: EndConditions,
    touched: tuple[EndConditions, Sources],
    fits: Mapping[int, ChainFit],
    bends: bool = True,
) -> ChainFit:
    """Fits one chain; `fits` are those of the chains before it, whose corners it meets.

    `ends` are values and slopes of all tangent neighbours that are fitted, `touched` the conditions of those that were
    touched, and of the user, with their sources. `bends`: whether a line may follow a bow.
    """
    conditions, sources = touched
    s, index, along = _chain_samples(profile, chain)
    found, rows = state.at(index, along), touches_of(profile, chain, state.vectors)
    supported = bool(len(rows.positions)) or state.explained(index, along) >= SUPPORTED
    held = np.array([conditions.start_value_mm is not None, conditions.end_value_mm is not None])
    mean = found.mean_mm if supported else np.zeros_like(s)
    mean, covariance = _through(mean, found.covariance_mm2, held, conditions)
    mean = _faded(s / chain.length_mm, mean, ends)
    if not len(rows.positions):
        mean = mean + _to_corners(profile, chain, s, mean, ~held, fits)
    root = root_of(covariance)
    once = np.append(np.diff(s) > 0.0, True)  # a joint is sampled from both sides
    straight = not bends or _is_straight(chain, s[once], mean[once], np.linalg.norm(root[once], axis=1))
    straight = not chain.curved and straight
    degree, knots = 1 if straight else 3, _chain_knots(replace(chain, curved=not straight), s)
    at_ends, zero = (ends, _zero(conditions)) if straight else (_with_ends(ends, mean), None)
    fit, kept = fit_determined(s[once], mean[once], knots, chain.length_mm, degree, at_ends)
    columns = [
        fit_determined(s[once], one[once], kept, chain.length_mm, degree, zero or _with_ends(_zero(conditions), one))[0]
        for one in root.T
    ]
    residual = rows.error_mm - fit.spline.of(fit.spline.value_form(rows.arc_length_mm))
    return replace(
        own_fit(chain, rows, fit, sources, _note(profile, chain, supported, state, mean, root)),
        residual_mm=residual,
        leave_one_out_mm=_left_out(state.vectors, rows.positions, state),
        spare=0,
        from_model_mm=np.column_stack([column.spline.coefficients_mm for column in columns]),
        unsupported=not supported and not held.any(),
        scatter_mm=state.updated.state.sizes["repeatability"] if state.vectors.seen else None,
    )


def _is_straight(chain: Chain, s: Array, mean: Array, u: Array) -> bool:
    """Returns whether straight lines along a chain are within a standard uncertainty, or 0.5 µm, of the mean."""
    knots = Knots((), chain.joints_mm, 1)
    line, _ = fit_determined(s, mean, knots, chain.length_mm, 1, EndConditions())
    return bool(np.all(np.abs(line.residual_mm) <= np.maximum(u, STRAIGHT_MM)))


def _faded(share: Array, mean: Array, ends: EndConditions) -> Array:
    """Returns the mean with the neighbours' values at the ends: a neighbour that stays as programmed has 0."""
    start, end = (
        0.0 if value is None else value - mean[k] for k, value in zip((0, -1), ends.numbers[::2], strict=True)
    )
    return np.asarray(mean + (1.0 - share) * start + share * end)


def _with_ends(conditions: EndConditions, values: Array) -> EndConditions:
    """Returns the conditions, and at free ends the values themselves: neighbours meet to the last bit."""
    start, end = conditions.start_value_mm, conditions.end_value_mm
    return replace(
        conditions,
        start_value_mm=float(values[0]) if start is None else start,
        end_value_mm=float(values[-1]) if end is None else end,
    )


def _zero(conditions: EndConditions) -> EndConditions:
    return EndConditions(*(None if number is None else 0.0 for number in astuple(conditions)))


def _left_out(vectors: ErrorVectors, positions: NDArray[np.intp], state: PartState) -> Array:
    """Returns each reading less its prediction by the others; NaN for readings put together from several."""
    by_name = dict(zip(state.names, state.updated.left_out_mm.tolist(), strict=True))
    return np.array([by_name.get(vectors.point[k], np.nan) for k in positions])


def name_of(profile: Profile, chain: Chain) -> str:
    """Names a chain by its features."""
    return all_of([profile.features[i].name for i in chain.features])


def _chain_samples(profile: Profile, chain: Chain) -> tuple[Array, NDArray[np.intp], Array]:
    """Returns arc lengths along the chain, and features with their arc lengths, both ends included; (n,)."""
    along = [np.linspace(0.0, profile.features[i].length_mm, SAMPLES) for i in chain.features]
    s = np.concatenate([start + own for start, own in zip(chain.starts_mm, along, strict=True)])
    return s, np.repeat(np.array(chain.features, dtype=np.intp), SAMPLES), np.concatenate(along)


def _through(mean: Array, covariance: Array, held: Flags, conditions: EndConditions) -> tuple[Array, Array]:
    """Returns mean and covariance given the values that tangent neighbours prescribe at the ends."""
    ends = np.array([0, len(mean) - 1])[held]
    if not len(ends):
        return mean, covariance
    given = np.array([v for v in (conditions.start_value_mm, conditions.end_value_mm) if v is not None])
    gain = covariance[:, ends] @ np.linalg.pinv(covariance[np.ix_(ends, ends)])
    return mean + gain @ (given - mean[ends]), covariance - gain @ covariance[ends]


def _to_corners(
    profile: Profile, chain: Chain, s: Array, mean: Array, free: Flags, fits: Mapping[int, ChainFit]
) -> Array:
    """Returns what keeps corners from moving further than errors explain, falling off to the other end, (n,)."""
    share = s / chain.length_mm
    first, last = chain.features[0], chain.features[-1]
    added = np.zeros_like(mean)
    for end, at, weight in ((0, first - 1, 1.0 - share), (1, last, share)):
        if free[end] and 0 <= at < len(profile.junctions) and profile.junctions[at].kind is JunctionKind.CORNER:
            value = float(mean[-end])
            added = added + weight * (_met(profile, at, end == 0, value, fits) - value)
    return added


def _met(profile: Profile, junction: int, comes_after: bool, value_mm: float, fits: Mapping[int, ChainFit]) -> float:
    """Returns the error at a corner that lets it move along the neighbour by at most |e| + |value|; the value where it
    may.

    With the neighbour's normal n₁ and error e, and n₂ = c n₁ + s t₁, the corner moves by d = e n₁ + x t₁ and
    n₂ · d = value asks for x = (value − c e)/s, which grows without bound as the corner gets flat.
    """
    before, after = profile.features[junction], profile.features[junction + 1]
    normals = [before.outward_normal(before.length_mm), after.outward_normal(0.0)]
    theirs, ours = normals if comes_after else normals[::-1]
    neighbour = _end_value_mm(junction if comes_after else junction + 1, comes_after, fits)
    if neighbour is None:
        return value_mm
    cosine = float(theirs @ ours)
    sine = float(theirs[0] * ours[1] - theirs[1] * ours[0])
    most = abs(neighbour) + abs(value_mm)
    asked = value_mm - cosine * neighbour
    if abs(asked) <= most * abs(sine):
        return value_mm
    return cosine * neighbour + math.copysign(most * sine, asked)


def _end_value_mm(feature: int, at_end: bool, fits: Mapping[int, ChainFit]) -> float | None:
    """Returns the error of a fitted neighbour where it meets the corner; None where it is not fitted yet."""
    for fit in fits.values():
        if feature in fit.chain.features:
            spline = fit.fit.spline
            return float(spline.of(spline.value_form(spline.length_mm if at_end else 0.0))[0])
    return None


def _chain_knots(chain: Chain, s: Array) -> Knots:
    """Returns the knots of a chain: two within each arc, and the joints, where the curve may bend."""
    if not chain.curved:
        return Knots((), chain.joints_mm, 1)
    third = SAMPLES // 3
    at = (k for n in range(len(chain.features)) for k in (n * SAMPLES + third, (n + 1) * SAMPLES - third))
    return Knots(tuple(float(s[k]) for k in at), chain.joints_mm, 3)


def root_of(covariance: Array) -> Array:
    """Returns F with F·Fᵀ the covariance, (n, m), without components that are only rounding."""
    values, vectors = np.linalg.eigh(covariance)
    counts = values > 1e-9 * max(float(values[-1]), 1e-12)
    root: Array = vectors[:, counts] * np.sqrt(values[counts])
    return root


def _note(profile: Profile, chain: Chain, supported: bool, state: PartState, mean: Array, root: Array) -> str:
    name, u = name_of(profile, chain), Um(float(np.max(np.linalg.norm(root, axis=1), initial=0.0)))
    low, high = Um(float(np.min(mean))), Um(float(np.max(mean)))
    size = low if high.mm - low.mm < SAME_MM else wording("{low} to {high}", low=low, high=high)
    readings = int(np.count_nonzero(np.isin(state.vectors.feature_index, chain.features)))
    if not supported:
        return wording(
            "{feature}: the measurements show nothing of it: left as programmed; standard uncertainty {u}. Measure it "
            "to be sure",
            feature=name,
            u=u,
        )
    if readings:
        return wording(
            "{feature}: {size} by all measurements, {n} of its own among them; standard uncertainty {u}",
            feature=name,
            size=size,
            n=readings,
            u=u,
        )
    return wording(
        "{feature}: no touch; {size} expected from the other features; standard uncertainty {u}. Touch it to be sure",
        feature=name,
        size=size,
        u=u,
    )
