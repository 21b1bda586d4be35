"""A corrected contour moved as a whole: every position of the tool goes to `p + D(p)`, D a vector.

A tool offset is a constant D, COMP_MTG one that depends on the position. Neither is a shift along the normal: on an
edge radius of 0.2 mm a tool offset of 30 µm would be 2 µm off as one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.turned.compensation.contour import CentrePiece, ShiftedFeature
from trueloop.turned.compensation.shift import Shift

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
