"""The closest point of a surface, for many points at once; the search is done in Rust (`crates/nurbs`)."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from trueloop._core import NurbsPatch
from trueloop.arrays import Array, for_kernel
from trueloop.geometry.surface import Surface


@dataclass(frozen=True, eq=False)
class Feet:
    """Closest points: parameters (n,), points and outward normals (n, 3), signed distance along the normal (n,), and
    how far the point lies beyond the patch's edge, sideways (n,); 0 over the patch.
    """

    u: Array
    v: Array
    point_mm: Array
    normal: Array
    distance_mm: Array
    beyond_mm: Array


def closest(surface: Surface, points_mm: Array, near: tuple[Array, Array] | None = None) -> Feet:
    """Returns the feet of points (n, 3), finite numbers: the nearest points of the whole patch.

    `near`: parameters to start from instead, where they are known: the foot is then the one downhill from there. Raises
    SRF-DEGENERATE where a foot has no normal.
    """
    points = np.atleast_2d(points_mm)
    start = None if near is None else np.stack(near, axis=1).astype(float)
    at, foot, du, dv = _patch(surface).feet(for_kernel(points), start)
    normal = surface.outward(foot, du, dv)
    off = points - foot
    along = np.einsum("nk,nk->n", off, normal)
    sideways = np.linalg.norm(off - along[:, None] * normal, axis=1)
    low, high = np.array(surface.domain).T
    on_edge = np.any((at <= low) | (at >= high), axis=1)
    return Feet(at[:, 0], at[:, 1], foot, normal, along, np.where(on_edge, sideways, 0.0))


def closest_parameters(surface: Surface, points_mm: Array) -> Array:
    """Parameters (n, 2) of the nearest points of the whole patch: they exist at a pole too, which has no normal."""
    return np.asarray(_patch(surface).feet(for_kernel(np.atleast_2d(points_mm)), None)[0])


@lru_cache(maxsize=16)
def _patch(surface: Surface) -> NurbsPatch:
    """The surface as the search has it: made once, a surface is asked many times."""
    weights = np.ones(surface.control_mm.shape[:2]) if surface.weights is None else surface.weights
    lifted = np.concatenate([surface.control_mm * weights[..., None], weights[..., None]], axis=2)
    knots = (for_kernel(surface.knots_u), for_kernel(surface.knots_v))
    return NurbsPatch(surface.degrees, knots, for_kernel(lifted))
