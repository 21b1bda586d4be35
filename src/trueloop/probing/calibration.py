"""The probe's calibration: how far from the surface the ball's centre is reported, by direction.

The stylus, and whether it can go somewhere without touching anything.

Touches on a sphere (or ring) of known size give the effective ball radius r(θ) = r₀ + a cos kθ + b sin kθ: the ball
less pre-travel and what the control latches too late, with the lobing of a k-legged switch. θ is the contact angle of
the surface that is touched. It holds for the speed, the stylus and the directions it was made with.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.domain.option import Option
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.geometry.feature import Feature, contact_angle_rad, pieces_within
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile, Side
from trueloop.units import UM_PER_MM

CHORD_MM: Final = 2e-3
"""Arcs are taken as polygons that deviate from them by at most this much; clearances are that much uncertain."""

BAR_MM: Final = 1000.0


@dataclass(frozen=True)
class Obstacle:
    """A closed polygon in the (x, z) plane; corner k to k + 1 belongs to `side[k]`, which names it in messages.

    `held_behind`: a bar or chuck is behind it, so that nothing comes to it from there.
    """

    corners_mm: Array
    side: tuple[str, ...]
    held_behind: bool = True

    def distance_mm(self, start_mm: Array, end_mm: Array) -> tuple[float, str]:
        """Returns the distance of the segment between two points to the polygon, 0 inside, and what is nearest."""
        a, b = self.corners_mm, np.roll(self.corners_mm, -1, axis=0)
        if self._holds(start_mm) or self._holds(end_mm):
            return 0.0, self.side[int(np.argmin(_point_to_segments(start_mm, a, b)))]
        between = np.minimum(_point_to_segments(start_mm, a, b), _point_to_segments(end_mm, a, b))
        along = end_mm - start_mm
        share = np.clip((a - start_mm) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
        distance: Array = np.hypot(*(start_mm + share[:, None] * along - a).T)
        between = np.minimum(between, distance)
        between = np.where(_cross(a, b, start_mm, end_mm), 0.0, between)
        nearest = int(np.argmin(between))
        return float(between[nearest]), self.side[nearest]

    def _holds(self, point_mm: Array) -> bool:
        a, b = self.corners_mm, np.roll(self.corners_mm, -1, axis=0)
        straddles = (a[:, 1] > point_mm[1]) != (b[:, 1] > point_mm[1])
        height = b[straddles, 1] - a[straddles, 1]
        x = a[straddles, 0] + (point_mm[1] - a[straddles, 1]) / height * (b - a)[straddles, 0]
        return bool(np.count_nonzero(x > point_mm[0]) % 2)


def stock_obstacle(profile: Profile, allowance_mm: float = 0.0, bar_radius_mm: float | None = None) -> Obstacle:
    """Returns the turned part with an allowance, and behind it a bar of that radius, else of the profile's first."""
    features, corners, sides = _surface(profile, allowance_mm)
    (x_start, z_start), end = features[0].start_mm, features[-1].end_mm
    bar_mm = x_start if bar_radius_mm is None else bar_radius_mm
    behind_mm = z_start - BAR_MM
    tail = [end, (0.0, end[1]), (0.0, behind_mm), (bar_mm, behind_mm), (bar_mm, z_start)]
    return _closed(corners, sides, tail, "the bar")


def whole_obstacle(profile: Profile, allowance_mm: float = 0.0) -> Obstacle:
    """Returns the part as a measuring machine has it: free behind where the profile comes round its back face.

    It is solid about the axis between the profile's two ends, or a ring where they pass each other in the bore.
    """
    features, corners, sides = _surface(profile, allowance_mm)
    z_start, z_end = features[0].start_mm[1], features[-1].end_mm[1]
    if profile.side is not Side.AROUND or z_start <= float(np.min(np.concatenate(corners)[:, 1])):
        return stock_obstacle(profile, allowance_mm)
    solid = [(0.0, z_end), (0.0, z_start)] if z_end > z_start else []
    return replace(_closed(corners, sides, [features[-1].end_mm, *solid], "the solid part"), held_behind=False)


def _surface(profile: Profile, allowance_mm: float) -> tuple[Sequence[Feature], list[Array], list[str]]:
    """The features with an allowance on them, corners along each, and the feature that each belongs to."""
    features: Sequence[Feature] = profile.features
    if allowance_mm > 0.0:
        features = nose_centre_path(profile, allowance_mm).features
    corners, sides = list[Array](), list[str]()
    for feature in features:
        s = np.linspace(0.0, feature.length_mm, pieces_within(feature, CHORD_MM) + 1)[:-1]
        corners.append(feature.point_mm(s))
        sides += [feature.name] * len(s)
    return features, corners, sides


def _closed(
    corners: Sequence[Array], sides: Sequence[str], tail: Sequence[tuple[float, float]], named: str
) -> Obstacle:
    return Obstacle(np.concatenate([*corners, np.array(tail)]), (*sides, *(named,) * len(tail)))


def _point_to_segments(point: Array, a: Array, b: Array) -> Array:
    along = b - a
    square = np.maximum(np.sum(along**2, axis=1), 1e-300)
    share = np.clip(np.sum((point - a) * along, axis=1) / square, 0.0, 1.0)
    distance: Array = np.hypot(*(a + share[:, None] * along - point).T)
    return distance


def _cross(a: Array, b: Array, c: Array, d: Array) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    """Which of the segments a–b cross the segment c–d."""

    def side(p: Array, q: Array, r: Array) -> Array:
        turned: Array = (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (
            r[..., 0] - p[..., 0]
        )
        return turned

    crossed = (side(c, d, a) * side(c, d, b) < 0.0) & (side(a, b, c) * side(a, b, d) < 0.0)
    return np.asarray(crossed)


FINEST_STEP_MM: Final = 0.01

Clearance: TypeAlias = Callable[[Obstacle, Array], tuple[float, str]]
"""Maps an obstacle and a ball centre to the clearance of a part of the stylus, mm, and to what is nearest."""


@dataclass(frozen=True)
class Stylus:
    """A ball on a stem; lengths in mm.

    `stem_angle_rad` is the direction from the ball along the stem, from +z towards +x: π/2 for a probe that reaches in
    from the side. The stem is a straight bar with round ends, from the ball to `stem_length_mm` off its centre.
    """

    ball_radius_mm: Annotated[float, Option("stylus.ball_radius_mm", "Radius of the ball.", above=0)]
    stem_radius_mm: Annotated[float, Option("stylus.stem_radius_mm", "Radius of the stem.", above=0)]
    stem_length_mm: Annotated[
        float, Option("stylus.stem_length_mm", "From the ball's centre to where the probe's body begins.", above=0)
    ] = 50.0
    stem_angle_rad: Annotated[
        float,
        Option(
            "stylus.stem_angle_deg",
            "Where the stem leaves the ball, from +z towards +x: 90 away from the axis, 0 away from the chuck.",
        ),
    ] = math.pi / 2

    @property
    def stem_direction(self) -> Array:
        """Returns the unit vector from the ball along the stem, (2,)."""
        return np.array([math.sin(self.stem_angle_rad), math.cos(self.stem_angle_rad)])

    def ball_clearance_mm(self, obstacle: Obstacle, centre_mm: Array) -> tuple[float, str]:
        """Returns the clearance between ball and obstacle, and what is nearest."""
        distance, nearest = obstacle.distance_mm(centre_mm, centre_mm)
        return distance - self.ball_radius_mm - CHORD_MM, nearest

    def stem_clearance_mm(self, obstacle: Obstacle, centre_mm: Array) -> tuple[float, str]:
        """Returns the clearance between stem and obstacle, and what is nearest."""
        along = self.stem_direction
        ends = centre_mm + self.ball_radius_mm * along, centre_mm + self.stem_length_mm * along
        distance, nearest = obstacle.distance_mm(*ends)
        return distance - self.stem_radius_mm - CHORD_MM, nearest

    def clearance_mm(self, obstacle: Obstacle, centre_mm: Array) -> tuple[float, str]:
        """Returns the clearance between obstacle and ball or stem, whichever is closer, and what is nearest."""
        return min(self.ball_clearance_mm(obstacle, centre_mm), self.stem_clearance_mm(obstacle, centre_mm))


@dataclass(frozen=True)
class Meeting:
    """The place where a straight move comes too close: the ball's centre, what it comes close to, and the clearance."""

    centre_mm: tuple[float, float]
    with_what: str
    clearance_mm: float


def first_meeting(
    clearance_mm: Clearance, obstacle: Obstacle, start_mm: Array, end_mm: Array, margin_mm: float
) -> Meeting | None:
    """Returns the first place on a straight move where less than the margin is left; None when the way is free.

    Nothing is missed between the places looked at: moving by d changes a clearance by at most d, so that what is left
    over the margin may be gone at once.
    """
    length, done = math.dist(start_mm, end_mm), 0.0
    direction = (end_mm - start_mm) / length if length > 0.0 else np.zeros(2)
    while True:
        centre = start_mm + done * direction
        clearance, what = clearance_mm(obstacle, centre)
        if clearance < margin_mm:
            return Meeting((float(centre[0]), float(centre[1])), what, clearance)
        if done >= length:
            return None
        # A hundredth more than is free would be needed to pass through a corner unseen: the margin holds that.
        done = min(done + max(clearance - margin_mm, FINEST_STEP_MM), length)


UNKNOWNS: Final = 5
STEPS: Final = 20
LEAST_SPAN_RAD: Final = math.radians(90.0)
LARGEST_SCATTER_MM: Final = 0.05
"""A probe that scatters more is loose, or the artefact is not the one that was named."""

BEYOND_RAD: Final = math.radians(1.0)
"""So little outside of the calibrated range is in it. The directions of the calibration's own touches are known no
better: the largest scatter let through turns one by 1° where the radii of ball and artefact add up to 3 mm."""


@dataclass(frozen=True)
class BallCalibration:
    """A calibrated probe; lengths in mm.

    `cosine_mm` and `sine_mm` are a and b. `scatter_mm` is the standard deviation of the touches about the fit, from
    `lowest_rad` to `highest_rad` of contact angle: what lies between was touched, or is between two touches.
    `radius_u_mm` is the standard uncertainty that the scatter leaves to r, in the touched direction that is known
    worst: ball, lobing and where the artefact stands are the harder to tell apart the smaller the range.
    """

    effective_radius_mm: float
    cosine_mm: float = 0.0
    sine_mm: float = 0.0
    lobes: int = 3
    scatter_mm: float = 0.0
    lowest_rad: float = -math.pi
    highest_rad: float = math.pi
    radius_u_mm: float = 0.0

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Warns where r is known less well than one touch repeats."""
        if self.radius_u_mm <= self.scatter_mm:
            return ()
        low, high = math.degrees(self.lowest_rad), math.degrees(self.highest_rad)
        message = (
            f"the ball's radius is known to {self.radius_u_mm * UM_PER_MM:.2f} µm (one standard deviation), worse than "
            f"a touch: between {low:.0f}° and {high:.0f}° ball, lobing and artefact are hardly separated"
        )
        hint = "touch it over 180° or more, in at least twenty directions"
        return (Finding(Severity.WARNING, Code.PRB_CALIBRATION, message, hint),)

    @property
    def lobing_mm(self) -> float:
        """Returns the amplitude of the lobing."""
        return math.hypot(self.cosine_mm, self.sine_mm)

    def radius_mm(self, outward_normal: Array) -> Array:
        """Returns the effective ball radius for touches on surfaces of these normals, (n, 2) → (n,)."""
        turned = self.lobes * contact_angle_rad(outward_normal)
        radius: Array = self.effective_radius_mm + self.cosine_mm * np.cos(turned) + self.sine_mm * np.sin(turned)
        return radius

    def covers(self, outward_normal: Array) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
        """Returns whether it holds for touches on surfaces of these normals, (n, 2) → (n,): lobing is known there."""
        low, high = self.lowest_rad - BEYOND_RAD, self.highest_rad + BEYOND_RAD
        inside = np.mod(contact_angle_rad(outward_normal) - low, 2 * np.pi) <= high - low
        return np.asarray(inside, dtype=np.bool_)


def calibrate(
    centres_mm: ArrayLike, artefact_radius_mm: float, *, ring: bool = False, lobes: int = 3
) -> BallCalibration:
    """Fits ball radius and lobing to ball centres (n, 2) reported on a sphere, or inside a ring, of known radius.

    The centre of the artefact is fitted as well, so that its position need not be known. Least squares by
    Gauss-Newton. Raises PRB-CALIBRATION with fewer than six touches, touches on less than a quarter of the circle, or
    ones that scatter by more than 0.05 mm about the fit.
    """
    centres = np.asarray(centres_mm, dtype=np.float64)
    if len(centres) <= UNKNOWNS:
        raise _refusal(
            f"{len(centres)} touches on the artefact; {UNKNOWNS + 1} are needed for ball radius, lobing and centre",
            "touch it in at least six directions, better in twenty",
        )
    side = -1.0 if ring else 1.0
    middle, fitted = _circle_centre(centres), np.zeros(3)
    for _ in range(STEPS):
        angle, terms = _terms(centres, middle, side, lobes)
        distance = np.hypot(*(centres - middle).T)
        design = np.column_stack([side * terms, side * np.sin(angle), side * np.cos(angle)])
        solved = np.linalg.lstsq(design, distance - artefact_radius_mm, rcond=1e-10)[0]
        fitted, moved = solved[:3], solved[3:]
        middle = middle + moved
        if float(np.max(np.abs(moved))) < 1e-12:
            break
    angle, terms = _terms(centres, middle, side, lobes)
    residual = np.hypot(*(centres - middle).T) - artefact_radius_mm - side * terms @ fitted
    scatter = float(np.sqrt(residual @ residual / (len(centres) - UNKNOWNS)))
    low, high = _span(angle, lobes)
    _require_good(len(centres), low, high, scatter, float(fitted[0]))
    radius_mm, cosine_mm, sine_mm = fitted.tolist()
    u_mm = scatter * _worst_factor(terms, angle)
    return BallCalibration(
        effective_radius_mm=radius_mm,
        cosine_mm=cosine_mm,
        sine_mm=sine_mm,
        lobes=lobes,
        scatter_mm=scatter,
        lowest_rad=low,
        highest_rad=high,
        radius_u_mm=u_mm,
    )


def _terms(centres: Array, middle: Array, side: float, lobes: int) -> tuple[Array, Array]:
    """Contact angles of the touches, and 1, cos kθ, sin kθ at them."""
    angle = contact_angle_rad(side * (centres - middle))
    return angle, np.column_stack([np.ones(len(angle)), np.cos(lobes * angle), np.sin(lobes * angle)])


def _worst_factor(terms: Array, angle: Array) -> float:
    """The largest standard uncertainty of r at the touches, of touches that scatter by one; centre and r are fitted."""
    triangular = np.linalg.qr(np.column_stack([terms, np.sin(angle), np.cos(angle)]), mode="r")
    of_radius = np.linalg.pinv(triangular)[:3]
    return float(np.sqrt(np.max(np.sum((terms @ of_radius) ** 2, axis=1))))


def _circle_centre(points: Array) -> Array:
    """Centre of the algebraic least-squares circle."""
    design = np.column_stack([2 * points, np.ones(len(points))])
    return np.asarray(np.linalg.lstsq(design, np.sum(points**2, axis=1), rcond=None)[0][:2])


def _span(angle_rad: Array, lobes: int) -> tuple[float, float]:
    """The shortest range of angles that holds all; the whole turn where every gap is less than half a lobe."""
    ascending = np.sort(angle_rad)
    gaps = np.diff(np.append(ascending, ascending[0] + 2 * np.pi))
    widest = int(np.argmax(gaps))
    if gaps[widest] < math.pi / lobes - BEYOND_RAD:
        return -math.pi, math.pi
    low = float(ascending[(widest + 1) % len(ascending)])
    return low, low + 2 * math.pi - float(gaps[widest])


def _require_good(count: int, low: float, high: float, scatter_mm: float, radius_mm: float) -> None:
    if high - low < LEAST_SPAN_RAD - BEYOND_RAD:
        raise _refusal(
            f"{count} touches span {math.degrees(high - low):.0f}° of the artefact; at least 90° are needed",
            "touch it around the directions that the part will be touched in",
        )
    if scatter_mm > LARGEST_SCATTER_MM or radius_mm <= 0.0:
        raise _refusal(
            f"the touches give a ball radius of {radius_mm:.4f} mm and scatter by {scatter_mm:.4f} mm about it",
            "check the artefact's size, ring or sphere, and that the stylus is tight",
        )


def _refusal(message: str, hint: str) -> TrueloopError:
    return Code.PRB_CALIBRATION.refusal(message, hint=hint)
