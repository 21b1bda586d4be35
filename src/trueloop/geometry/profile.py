"""A profile: the ordered chain of features of a turned part, and the junctions between them."""

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array, Integers
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line, contact_angle_rad

TANGENT_WITHIN_RAD: Final = 1e-3
"""Two features whose directions differ by less meet tangentially, unless the job says otherwise: rounding coordinates
to 1e-5 in turns a 0.5 mm feature by 0.5 mrad, and no drawing has a corner of less than 0.06 degrees."""


APART_MM: Final = 0.05
"""Ends that lie farther from each other do not meet: what is between them another edge cuts."""


class JunctionKind(StrEnum):
    """The way two features meet: the angle is critical (tangent) or not (corner) [6811 §2.2]; or they are apart."""

    CORNER = "corner"
    TANGENT = "tangent"
    APART = "apart"


class Side(StrEnum):
    """The side of its material as seen from a profile's surface, which sets the direction in which its features run.

    The material is always on the right of the direction of travel, seen with z to the right and x up. An outside
    profile therefore runs from the chuck end to the free end, a bore from the free end to the chuck end; a profile
    around the part runs along the outside, over the front face and back through the bore, or is a back face alone.
    """

    OUTSIDE = "outside"
    INSIDE = "inside"
    AROUND = "around"


LOWEST_CONTACT_RAD: Final = {Side.OUTSIDE: -0.75 * math.pi, Side.INSIDE: -1.25 * math.pi, Side.AROUND: -0.75 * math.pi}
"""Contact angles of the first feature count from here: nothing is cut at −135° outside, at +135° in a bore."""


@dataclass(frozen=True)
class Junction:
    """The place where one feature ends and the next begins.

    `turn_rad` is the angle by which the direction of travel turns, positive to the right (a convex corner: the material
    takes less than half a turn), negative to the left (a corner that the nose can reach only as a fillet).
    """

    kind: JunctionKind
    turn_rad: float
    by_design: bool = False


FACES_Z: Final = math.cos(math.radians(3.0))
"""A line whose normal has at least this component along z is a face."""
AT_FACE_MM: Final = 1e-6
"""A face this near to a z stands there."""


@dataclass(frozen=True)
class Located:
    """Points put onto a profile: index of the nearest feature, arc length on it, distance along the outward normal."""

    feature_index: np.ndarray[tuple[int], np.dtype[np.intp]]
    arc_length_mm: Array
    distance_mm: Array


@dataclass(frozen=True)
class Profile:
    """A chain of features, its material on the right; `junctions[i]` stands between `features[i]` and `[i + 1]`."""

    features: tuple[Feature, ...]
    junctions: tuple[Junction, ...]
    side: Side = Side.OUTSIDE

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Returns the features' names, in order."""
        return tuple(feature.name for feature in self.features)

    def faces_at(self, z_mm: float) -> list[int]:
        """Returns the faces at a z, mm, by index: lines within 3° of square to the axis."""
        return [
            k
            for k, one in enumerate(self.features)
            if isinstance(one, Line) and abs(float(one.outward_normal(0.0)[1])) > FACES_Z
            if abs(float(one.point_mm(0.5 * one.length_mm)[1]) - z_mm) < AT_FACE_MM
        ]

    @property
    def length_mm(self) -> float:
        """Returns the arc length of the whole chain."""
        return math.fsum(feature.length_mm for feature in self.features)

    def start_of(self, index: int) -> float:
        """Returns the arc length along the whole profile at which feature `index` begins, mm."""
        return math.fsum(feature.length_mm for feature in self.features[:index])

    @cached_property
    def middle_z_mm(self) -> float:
        """Returns z in the middle between the outermost ends of the features."""
        ends = [end[1] for feature in self.features for end in (feature.start_mm, feature.end_mm)]
        return 0.5 * (min(ends) + max(ends))

    def in_groups(self, feature_index: Integers, arc_length_mm: ArrayLike) -> tuple[Integers, Array]:
        """Returns places (n,) by group of tangent features: its first feature, and the share of its length before."""
        first, before = [0], [0.0]
        for i, junction in enumerate(self.junctions):
            tangent = junction.kind is JunctionKind.TANGENT
            first.append(first[i] if tangent else i + 1)
            before.append(before[i] + self.features[i].length_mm if tangent else 0.0)
        group, lengths = np.array(first, dtype=np.intp), np.array([feature.length_mm for feature in self.features])
        whole = np.bincount(group, weights=lengths, minlength=len(group))
        index = np.asarray(feature_index, dtype=np.intp)
        return group[index], (np.array(before)[index] + np.asarray(arc_length_mm)) / whole[group[index]]

    def contact_angle_rad(self, feature_index: Integers, arc_length_mm: ArrayLike) -> Array:
        """Returns the contact angles at places of the profile, (n,): of the outward normal from +z towards +x.

        Continuous along the profile: a back face is at +π on an outside and at −π in a bore, where π/2 and −π/2 are
        the cylinders, and no arc jumps by a full turn.
        """
        index = np.asarray(feature_index, dtype=np.intp)
        s = np.broadcast_to(np.asarray(arc_length_mm, dtype=np.float64), index.shape)
        middle, angle = self._middle_contact_rad, np.empty(index.shape)
        for i in np.unique(index).tolist():
            here = index == i
            found = contact_angle_rad(self.features[i].outward_normal(s[here]))
            angle[here] = found + 2.0 * math.pi * np.round((middle[i] - found) / (2.0 * math.pi))
        return angle

    def contact_along_rad(self, index: int, arc_length_mm: ArrayLike) -> Array:
        """Returns the contact angles along one feature, (n,), counted as in `contact_angle_rad`."""
        s = np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64))
        return self.contact_angle_rad(np.full(s.shape, index), s)

    @cached_property
    def _middle_contact_rad(self) -> tuple[float, ...]:
        """Returns the contact angle in the middle of each feature, carried on from the first by the chain's turns."""
        first = float(contact_angle_rad(self.features[0].outward_normal(0.0)))
        lowest = LOWEST_CONTACT_RAD[self.side]
        angle = first + 2.0 * math.pi * math.ceil((lowest - first) / (2.0 * math.pi))
        turns = (*(junction.turn_rad for junction in self.junctions), 0.0)
        middles = []
        for feature, turn_rad in zip(self.features, turns, strict=True):
            half = feature.turn_rad / 2.0
            middles.append(angle - half)
            angle -= 2.0 * half + turn_rad
        return tuple(middles)

    def locate(self, points_mm: ArrayLike) -> Located:
        """Returns the nearest feature for each point, (n, 2); a foot beyond a feature's end counts by its end."""
        points = np.atleast_2d(np.asarray(points_mm, dtype=np.float64))
        feet = [feature.locate(points) for feature in self.features]
        arc_length = np.stack([foot[0] for foot in feet])
        distance = np.stack([foot[1] for foot in feet])
        lengths = np.array([[feature.length_mm] for feature in self.features])
        beyond = np.maximum(np.maximum(-arc_length, arc_length - lengths), 0.0)
        nearest = np.argmin(np.hypot(distance, beyond), axis=0)
        rows = np.arange(len(points))
        return Located(nearest, arc_length[nearest, rows], distance[nearest, rows])


def junctions_of(
    features: Sequence[Feature], by_design: Mapping[tuple[str, str], JunctionKind] | None = None
) -> tuple[Junction, ...]:
    """Returns the junctions of a chain, by its directions; `by_design` overrides the kind by the features' names."""
    by_design = by_design or {}
    return tuple(
        _junction(before, after, by_design.get((before.name, after.name)))
        for before, after in itertools.pairwise(features)
    )


def _junction(before: Feature, after: Feature, by_design: JunctionKind | None) -> Junction:
    if math.dist(before.end_mm, after.start_mm) > APART_MM:
        return Junction(JunctionKind.APART, 0.0)
    arriving, leaving = before.tangent(before.length_mm), after.tangent(0.0)
    left = arriving[1] * leaving[0] - arriving[0] * leaving[1]
    turn_rad = -math.atan2(left, float(arriving @ leaving))
    found = JunctionKind.TANGENT if abs(turn_rad) < TANGENT_WITHIN_RAD else JunctionKind.CORNER
    return Junction(by_design or found, turn_rad, by_design is not None)


SQUARE: Final = math.cos(math.radians(0.5))
"""A line within half a degree of the axis is a cylinder, one within half a degree of square to it a face."""


def kind_of(feature: Feature) -> str:
    """Returns the kind of a feature: cylinder, face, cone, arc or curve."""
    if isinstance(feature, Curve):
        return "curve"
    if isinstance(feature, Arc):
        return "arc"
    (x0, z0), (x1, z1), least = feature.start_mm, feature.end_mm, SQUARE * feature.length_mm
    if abs(z1 - z0) > least:
        return "cylinder"
    return "face" if abs(x1 - x0) > least else "cone"


def named_by_kind(features: Iterable[Feature]) -> tuple[Feature, ...]:
    """Names the features cylinder-1, face-1, cone-1, arc-1, cylinder-2…, in their order from the chuck."""
    seen, named = Counter[str](), list[Feature]()
    for feature in features:
        kind = kind_of(feature)
        seen[kind] += 1
        name = f"{kind}-{seen[kind]}"
        line = isinstance(feature, Line)  # `replace` takes long, and a drawing has many
        named.append(Line(name, feature.start_mm, feature.end_mm) if line else replace(feature, name=name))
    return tuple(named)
