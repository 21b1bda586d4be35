"""The curve of a chain without a touch: from tangent neighbours where it has any, else from touches elsewhere.

What is expected is the mean given the touches (`untouched`), and a chain of which the touches say nothing stays as
programmed. Where it meets a neighbour at a corner, the corner moves along that neighbour by no more than the errors of
both together: a cone at 5° to a cylinder, believed to err by 20 µm more or less than that, would else move the corner
by 0.2 mm, out of an uncertainty of as much.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.fit.chain import Chain
from trueloop.turned.fit.chain_fit import ChainFit, Sources, own_fit, touches_of
from trueloop.turned.fit.knots import Knots, fit_determined
from trueloop.turned.fit.nose_curve import carried
from trueloop.turned.fit.prior.untouched import Expected, expect
from trueloop.turned.fit.spline import EndConditions, least_squares_spline
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import Um, all_of, wording

SAMPLES: Final = 13
SAME_MM: Final = 5e-5
"""Expected errors that differ by less are written as one."""
"""Places along each arc at which the expected error is carried over to a spline."""


def fit_untouched(
    profile: Profile,
    chain: Chain,
    vectors: ErrorVectors,
    conditions: EndConditions,
    sources: Sources,
    fits: Mapping[int, ChainFit],
) -> ChainFit:
    """Fits one chain; `fits` are those of the chains before it, whose corners it meets."""
    if not chain.curved and conditions.count:
        return _continued(profile, chain, vectors, conditions, sources)
    s, index, along = chain_samples(profile, chain)
    angle = profile.contact_angle_rad(index, along)
    expected = expect(profile, vectors, angle, chain.features[0])
    held = np.array([conditions.start_value_mm is not None, conditions.end_value_mm is not None])
    prior = expected.mean_mm if expected.supported else np.zeros_like(s)
    mean, covariance = through(prior, expected.covariance_mm2, held, conditions)
    mean = mean + _to_corners(profile, chain, s, mean, ~held, fits)
    once = np.append(np.diff(s) > 0.0, True)  # a joint is sampled from both sides
    degree, root = 3 if chain.curved else 1, root_of(covariance)
    curve, kept = fit_determined(s[once], mean[once], chain_knots(chain, s), chain.length_mm, degree, conditions)
    note = _note(profile, chain, expected, mean, root)
    return replace(
        own_fit(chain, touches_of(profile, chain, vectors), curve, sources, note),
        residual_mm=np.empty(0),
        leave_one_out_mm=np.empty(0),
        spare=0,
        from_model_mm=carried(s[once], root[once], kept, curve),
        unsupported=not expected.supported and not held.any(),
    )


def _continued(
    profile: Profile, chain: Chain, vectors: ErrorVectors, conditions: EndConditions, sources: Sources
) -> ChainFit:
    """A line goes on as the arcs end that it is tangent to: the contact angle is the same."""
    fit = least_squares_spline([], [], [], chain.length_mm, conditions.coefficients - 1, conditions)
    name = name_of(profile, chain)
    note = wording("{feature}: no touch; continues its tangent neighbours' curves", feature=name)
    return own_fit(chain, touches_of(profile, chain, vectors), fit, sources, note)


def chain_knots(chain: Chain, s: Array) -> Knots:
    """Returns the knots of a chain: two within each arc, and the joints, where the curve may bend."""
    if not chain.curved:
        return Knots((), chain.joints_mm, 1)
    third = SAMPLES // 3
    at = (k for n in range(len(chain.features)) for k in (n * SAMPLES + third, (n + 1) * SAMPLES - third))
    return Knots(tuple(float(s[k]) for k in at), chain.joints_mm, 3)


def name_of(profile: Profile, chain: Chain) -> str:
    """Names a chain by its features."""
    return all_of([profile.features[i].name for i in chain.features])


def chain_samples(profile: Profile, chain: Chain) -> tuple[Array, NDArray[np.intp], Array]:
    """Returns arc lengths along the chain, and features with arc lengths along these, ends of every feature included;
    (n,).
    """
    along = [np.linspace(0.0, profile.features[i].length_mm, SAMPLES) for i in chain.features]
    s = np.concatenate([start + own for start, own in zip(chain.starts_mm, along, strict=True)])
    return s, np.repeat(np.array(chain.features, dtype=np.intp), SAMPLES), np.concatenate(along)


def through(
    mean: Array, covariance: Array, held: "np.ndarray[tuple[int], np.dtype[np.bool_]]", conditions: EndConditions
) -> tuple[Array, Array]:
    """Returns mean and covariance given the values that tangent neighbours prescribe at the ends."""
    ends = np.array([0, len(mean) - 1])[held]
    if not len(ends):
        return mean, covariance
    given = np.array([v for v in (conditions.start_value_mm, conditions.end_value_mm) if v is not None])
    gain = covariance[:, ends] @ np.linalg.pinv(covariance[np.ix_(ends, ends)])
    return mean + gain @ (given - mean[ends]), covariance - gain @ covariance[ends]


def _to_corners(
    profile: Profile,
    chain: Chain,
    s: Array,
    mean: Array,
    free: "np.ndarray[tuple[int], np.dtype[np.bool_]]",
    fits: Mapping[int, ChainFit],
) -> Array:
    """What to add so that corners move no further than errors explain, falling off evenly to the other end, (n,)."""
    share = s / chain.length_mm
    first, last = chain.features[0], chain.features[-1]
    added = np.zeros_like(mean)
    for end, at, weight in ((0, first - 1, 1.0 - share), (1, last, share)):
        if free[end] and 0 <= at < len(profile.junctions) and profile.junctions[at].kind is JunctionKind.CORNER:
            value = float(mean[-end])
            added = added + weight * (_met(profile, at, end == 0, value, fits) - value)
    return added


def _met(profile: Profile, junction: int, comes_after: bool, value_mm: float, fits: Mapping[int, ChainFit]) -> float:
    """The error at a corner that lets it move along the neighbour by at most |e| + |value|; the value where it may.

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


def root_of(covariance: Array) -> Array:
    """Returns F with F·Fᵀ the covariance, (n, m), without components that are only rounding."""
    values, vectors = np.linalg.eigh(covariance)
    counts = values > 1e-9 * max(float(values[-1]), 1e-12)
    root: Array = vectors[:, counts] * np.sqrt(values[counts])
    return root


def _note(profile: Profile, chain: Chain, expected: Expected, mean: Array, root: Array) -> str:
    name = name_of(profile, chain)
    u = Um(float(np.max(np.linalg.norm(root, axis=1), initial=0.0)), ".0f")
    nearest = wording("nearest touched contact angle {away:.0f}° away", away=math.degrees(expected.nearest_rad))
    if not expected.supported:
        why = wording("the touches say nothing of it ({nearest}): left as programmed", nearest=nearest)
    else:
        low, high = Um(float(np.min(mean))), Um(float(np.max(mean)))
        size = low if high.mm - low.mm < SAME_MM else wording("{low} to {high}", low=low, high=high)
        dx, dz = map(Um, expected.offsets_mm)
        why = wording(
            "{size} expected from the other features (tool offsets dX {dx}, dZ {dz}; {nearest})",
            size=size,
            dx=dx,
            dz=dz,
            nearest=nearest,
        )
    return wording(
        "{feature}: no touch; {why}; standard uncertainty {u}. Touch it to be sure", feature=name, why=why, u=u
    )
