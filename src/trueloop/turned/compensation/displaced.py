"""A corrected contour moved as a whole: every position of the tool goes to `p + D(p)`, D a vector.

A tool offset is a constant D, COMP_MTG one that depends on the position. Neither is a shift along the normal: on an
edge radius of 0.2 mm a tool offset of 30 µm would be 2 µm off as one.

The compensated contour, and the path of the nose centre that cuts it.

A point of feature i at arc length s goes to `c(s) = p(s) + u(s) n(s)`, u the shift along the outward normal, −w times
the error. Neighbouring contours are trimmed or extended to where they cross, so that at every nominal point the contour
deviates by u to the last digit; moving points along the feature to close the corners, as [6811 Fig. 9] does, would
change u by its slope times the corner's slide (0.9 µm on the knob of PIECS11). The nose centre runs at
`c(s) + R m(s)`, m the normal of the *compensated* contour: with slope u′ the contact moves tangentially by R u′, which
shifting the nominal centre path would leave out.

With dn/ds = κ t: `c′ = (1 + κ u) t + u′ n`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.compensation.shift import Shift

PARALLEL_SINE: Final = 1e-7
"""Below this sine of the angle between two centre paths their crossing is not sought: they are joined at the middle."""

NEWTON_STEPS: Final = 30

MEET_MM: Final = 1e-9
"""The distance, mm, within which two paths cross, however little the search has settled along them."""


@dataclass(frozen=True)
class ShiftedFeature:
    """A nominal feature with its contour moved along its normal by `shift`."""

    feature: Feature
    shift: Shift
    nose_radius_mm: float

    @property
    def undisplaced(self) -> "ShiftedFeature":
        """Returns itself; a `compensation.displaced` feature returns the one it is made of."""
        return self

    def off_nominal_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the deviation of the contour along the nominal normal, (...)."""
        return self.shift.value_mm(arc_length_mm)

    def contour_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Points of the compensated contour, (...) → (..., 2)."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        return self.feature.point_mm(s) + self.shift.value_mm(s)[..., None] * self.feature.outward_normal(s)

    def tangent(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit tangent of the compensated contour, and of the centre path, (...) → (..., 2)."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        along = 1 + self.feature.curvature_per_mm(s) * self.shift.value_mm(s)
        across = self.shift.slope(s)
        direction = along[..., None] * self.feature.tangent(s) + across[..., None] * self.feature.outward_normal(s)
        unit: Array = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        return unit

    def centre_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Points of the nose-centre path, (...) → (..., 2)."""
        tangent = self.tangent(arc_length_mm)
        normal = np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)
        return self.contour_mm(arc_length_mm) + self.nose_radius_mm * normal


@dataclass(frozen=True)
class CentrePiece:
    """The part of a shifted feature that the nose cuts: from arc length `start_mm` to `end_mm` along the feature."""

    shifted: ShiftedFeature
    start_mm: float
    end_mm: float


def shifted_contour(profile: Profile, shifts: Sequence[Shift], nose_radius_mm: float) -> tuple[ShiftedFeature, ...]:
    """Returns the profile with each feature moved by its shift."""
    pairs = zip(profile.features, shifts, strict=True)
    return tuple(ShiftedFeature(feature, shift, nose_radius_mm) for feature, shift in pairs)


def centre_pieces(profile: Profile, contour: Sequence[ShiftedFeature]) -> tuple[CentrePiece, ...]:
    """Returns the pieces of the nose-centre path, each from and to the crossing with its neighbour's centre path.

    At a convex corner the path runs on beyond the feature to the crossing, as shop programs do; at a concave one it
    stops short of the corner. The free ends stay at the feature's ends, as do those of features that are apart.
    """
    crossings = [_crossing(contour[i], contour[i + 1], junction.kind) for i, junction in enumerate(profile.junctions)]
    starts = [0.0, *(after for _, after in crossings)]
    ends = [*(before for before, _ in crossings), contour[-1].feature.length_mm]
    return tuple(CentrePiece(shifted, start, end) for shifted, start, end in zip(contour, starts, ends, strict=True))


def reaches_mm(shifted: ShiftedFeature, along_mm: float, at_end: bool) -> float:
    """Returns the arc length at which the centre path passes the perpendicular through a point `along_mm` beyond a free
    end.

    The hypothetical neighbour of a profile's free end is a cut square to it [6811 §3.4]; this is where it is met. A
    displacement of the whole path takes the end along.
    """
    shifted = shifted.undisplaced
    feature = shifted.feature
    base = feature.length_mm if at_end else 0.0
    origin, tangent = feature.point_mm(base), feature.tangent(base)
    target = along_mm if at_end else -along_mm
    s = base + target
    for _ in range(NEWTON_STEPS):
        miss = float((shifted.centre_mm(s) - origin) @ tangent) - target
        speed = float(shifted.tangent(s) @ tangent) * _stretch(shifted, s)
        s -= miss / speed
        if abs(miss) < 1e-12:
            break
    return s


def _crossing(before: ShiftedFeature, after: ShiftedFeature, kind: JunctionKind) -> tuple[float, float]:
    """Returns the arc lengths (on `before`, on `after`) where their centre paths cross, nearest to the corner between
    them.

    Features that are apart keep their ends. Tangent ones that rounding keeps from crossing near there go over into each
    other where they end.
    """
    if kind is JunctionKind.APART:
        return before.feature.length_mm, 0.0
    guess = s, t = _first_guess(before, after, kind is JunctionKind.TANGENT)
    near_mm = min(before.feature.length_mm, after.feature.length_mm) / 2
    for _ in range(NEWTON_STEPS):
        gap = after.centre_mm(t) - before.centre_mm(s)
        leaving, arriving = before.tangent(s), after.tangent(t)
        sine = float(leaving[0] * arriving[1] - leaving[1] * arriving[0])
        if abs(sine) < PARALLEL_SINE:
            return _side_by_side(before, after, (s, t))
        if kind is JunctionKind.TANGENT and max(abs(s - guess[0]), abs(t - guess[1])) > near_mm:
            return _side_by_side(before, after, guess)
        step_s = float(gap[0] * arriving[1] - gap[1] * arriving[0]) / sine
        step_t = float(gap[0] * leaving[1] - gap[1] * leaving[0]) / sine
        s += step_s / _stretch(before, s)
        t += step_t / _stretch(after, t)
        if abs(step_s) + abs(step_t) < 1e-12:
            return s, t
    meet = math.dist(before.centre_mm(s), after.centre_mm(t)) < MEET_MM
    return (s, t) if meet or kind is not JunctionKind.TANGENT else _side_by_side(before, after, guess)


def _side_by_side(before: ShiftedFeature, after: ShiftedFeature, at: tuple[float, float]) -> tuple[float, float]:
    """Returns the arc lengths at which two centre paths that run alike there are beside each other."""
    s, t = at
    half = 0.5 * float((after.centre_mm(t) - before.centre_mm(s)) @ before.tangent(s))
    return s + half / _stretch(before, s), t - half / _stretch(after, t)


def _first_guess(before: ShiftedFeature, after: ShiftedFeature, tangent: bool) -> tuple[float, float]:
    """Returns the corner itself, moved by R tan(θ/2) along both features: exact for two lines."""
    end = before.feature.length_mm
    if tangent:
        return end, 0.0
    leaving, arriving = before.feature.tangent(end), after.feature.tangent(0.0)
    turn = np.arctan2(leaving[0] * arriving[1] - leaving[1] * arriving[0], leaving @ arriving)
    reach = before.nose_radius_mm * float(np.tan(turn / 2))
    return end + reach, -reach


def _stretch(shifted: ShiftedFeature, s: float) -> float:
    """Returns the length of the centre path per length of nominal arc, near enough for Newton's steps: 1 + κ R."""
    if isinstance(shifted.feature, Line):
        return 1.0
    return 1.0 + float(shifted.feature.curvature_per_mm(s)) * shifted.nose_radius_mm


STEP_MM: Final = 0.01
"""Half the step of differences: what a displacement holds changes over millimetres."""


@runtime_checkable
class Displacement(Protocol):
    """A displacement added to positions; a frozen dataclass, stored with the path that it displaces."""

    def displacement_mm(self, at_mm: Array) -> Array:
        """Positions (n, 2) in (x as a radius, z), mm, to what is added to them, (n, 2)."""


@dataclass(frozen=True)
class Constant:
    """The displacement by a tool offset (x as a radius, z)."""

    offset_mm: tuple[float, float]

    def displacement_mm(self, at_mm: Array) -> Array:
        """Returns the offset, at every position."""
        return np.broadcast_to(np.asarray(self.offset_mm), at_mm.shape)


@dataclass(frozen=True)
class Then:
    """The second one where the first one has moved to, and both together."""

    first: Displacement
    second: Displacement

    def displacement_mm(self, at_mm: Array) -> Array:
        """Returns the sum of both."""
        moved = self.first.displacement_mm(at_mm)
        return moved + self.second.displacement_mm(at_mm + moved)


@dataclass(frozen=True)
class DisplacedFeature(ShiftedFeature):
    """A shifted feature whose path is displaced besides."""

    displacement: Displacement

    @property
    def undisplaced(self) -> ShiftedFeature:
        """Returns the feature that is displaced."""
        return ShiftedFeature(self.feature, self.shift, self.nose_radius_mm)

    def off_nominal_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the deviation of the contour along the nominal normal, to first order, (...), for display."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        normal = self.feature.outward_normal(s)
        moved = _of(self.displacement, self.feature.point_mm(s) + self.nose_radius_mm * normal)
        return np.asarray(self.shift.value_mm(s) + np.sum(moved * normal, axis=-1))

    def contour_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Points of the contour, (...) → (..., 2), displaced as the nose centre is that cuts them."""
        own = self.undisplaced
        return own.contour_mm(arc_length_mm) + _of(self.displacement, own.centre_mm(arc_length_mm))

    def centre_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Points of the nose-centre path, (...) → (..., 2)."""
        at = self.undisplaced.centre_mm(arc_length_mm)
        return at + _of(self.displacement, at)

    def tangent(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit tangent of the displaced path, (...) → (..., 2)."""
        own = self.undisplaced
        along, at = own.tangent(arc_length_mm), own.centre_mm(arc_length_mm)
        ahead, behind = (_of(self.displacement, at + step * along) for step in (STEP_MM, -STEP_MM))
        direction = along + (ahead - behind) / (2 * STEP_MM)
        unit: Array = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        return unit


def displaced_pieces(pieces: Sequence[CentrePiece], displacement: Displacement) -> tuple[CentrePiece, ...]:
    """Displaces the pieces. They meet where they met before: one position goes to one position."""
    return tuple(
        replace(piece, shifted=DisplacedFeature(p.feature, p.shift, p.nose_radius_mm, displacement))
        for piece in pieces
        for p in [piece.shifted]
    )


def magnitude(
    shifted: ShiftedFeature, own: Shift, displacement: Displacement, arc_length_mm: Array
) -> tuple[Array, Array]:
    """Returns the size of a displacement added to the feature's own shift, and of its change along it, (n,) each."""
    plain, s = shifted.undisplaced, arc_length_mm
    normal = plain.feature.outward_normal(s)
    vector = _of(displacement, plain.centre_mm(s)) + own.value_mm(s)[:, None] * normal
    ahead, behind = (_of(displacement, plain.centre_mm(s + step)) for step in (STEP_MM, -STEP_MM))
    change = (ahead - behind) / (2 * STEP_MM) + own.slope(s)[:, None] * normal
    return np.linalg.norm(vector, axis=-1), np.linalg.norm(change, axis=-1)


def _of(displacement: Displacement, at: Array) -> Array:
    return displacement.displacement_mm(at.reshape(-1, 2)).reshape(at.shape)
