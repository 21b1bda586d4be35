"""A corrected contour moved as a whole: every position of the tool goes to `p + D(p)`, D a vector.

A tool offset is a constant D, COMP_MTG one that depends on the position. Neither is a shift along the normal: on an
edge radius of 0.2 mm a tool offset of 30 µm would be 2 µm off as one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature
from trueloop.turned.compensation.contour import CentrePiece, ShiftedFeature
from trueloop.turned.compensation.shift import Shift

Displacement: TypeAlias = Callable[[Array], Array]
"""Positions (n, 2) in (x as a radius, z), mm, to what is added to them, (n, 2)."""

STEP_MM: Final = 0.01
"""Half the step of differences: what a displacement holds changes over millimetres."""


@dataclass(frozen=True)
class DisplacedFeature(ShiftedFeature):
    """A shifted feature whose path is displaced besides."""

    displacement: Displacement

    @property
    def undisplaced(self) -> ShiftedFeature:
        """What is displaced."""
        return ShiftedFeature(self.feature, self.shift, self.nose_radius_mm)

    def contour_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Points of the contour, (...) → (..., 2), displaced as the nose centre is that cuts them."""
        own = self.undisplaced
        return own.contour_mm(arc_length_mm) + _of(self.displacement, own.centre_mm(arc_length_mm))

    def centre_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Points of the nose-centre path, (...) → (..., 2)."""
        at = self.undisplaced.centre_mm(arc_length_mm)
        return at + _of(self.displacement, at)

    def tangent(self, arc_length_mm: ArrayLike) -> Array:
        """Unit tangent of the displaced path, (...) → (..., 2)."""
        own = self.undisplaced
        along, at = own.tangent(arc_length_mm), own.centre_mm(arc_length_mm)
        ahead, behind = (_of(self.displacement, at + step * along) for step in (STEP_MM, -STEP_MM))
        direction = along + (ahead - behind) / (2 * STEP_MM)
        unit: Array = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        return unit


def displaced_pieces(pieces: Sequence[CentrePiece], displacement: Displacement) -> tuple[CentrePiece, ...]:
    """The pieces displaced. They meet where they met before: one position goes to one position."""
    return tuple(
        replace(piece, shifted=DisplacedFeature(p.feature, p.shift, p.nose_radius_mm, displacement))
        for piece in pieces
        for p in [piece.shifted]
    )


def constant(offset_mm: tuple[float, float]) -> Displacement:
    """The displacement by a tool offset (x as a radius, z)."""
    return lambda at: np.broadcast_to(np.asarray(offset_mm), at.shape)


def then(first: Displacement, second: Displacement) -> Displacement:
    """The second one where the first one has moved to, and both together."""

    def both(at: Array) -> Array:
        moved = np.asarray(first(at))
        return moved + np.asarray(second(at + moved))

    return both


def magnitude(shifted: ShiftedFeature, own: Shift | None, displacement: Displacement) -> Shift:
    """Size of a displacement, or of its sum with a shift of the feature's own, and of its change along the feature."""
    plain = shifted.undisplaced
    feature = plain.feature

    def vector(s: ArrayLike) -> Array:
        moved = _of(displacement, plain.centre_mm(s))
        return moved if own is None else moved + own.value_mm(s)[..., None] * feature.outward_normal(s)

    def value_mm(s: ArrayLike) -> Array:
        return np.asarray(np.linalg.norm(vector(s), axis=-1))

    def slope(s: ArrayLike) -> Array:
        at = np.asarray(s, dtype=np.float64)
        ahead, behind = (_of(displacement, plain.centre_mm(at + step)) for step in (STEP_MM, -STEP_MM))
        change = (ahead - behind) / (2 * STEP_MM)
        if own is not None:
            change = change + own.slope(at)[..., None] * feature.outward_normal(at)
        return np.asarray(np.linalg.norm(change, axis=-1))

    return Shift(value_mm, slope)


def along_normal(feature: Feature, nose_radius_mm: float, displacement: Displacement) -> Shift:
    """What a displacement shifts a feature's contour by along its normal, to first order: to show and to judge it."""

    def value_mm(s: ArrayLike) -> Array:
        normal = feature.outward_normal(s)
        moved = _of(displacement, feature.point_mm(s) + nose_radius_mm * normal)
        return np.asarray(np.sum(moved * normal, axis=-1))

    def slope(s: ArrayLike) -> Array:
        return (value_mm(np.asarray(s) + STEP_MM) - value_mm(np.asarray(s) - STEP_MM)) / (2 * STEP_MM)

    return Shift(value_mm, slope)


def _of(displacement: Displacement, at: Array) -> Array:
    return np.asarray(displacement(at.reshape(-1, 2))).reshape(at.shape)
