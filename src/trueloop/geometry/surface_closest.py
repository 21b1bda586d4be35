"""The closest point of a surface: Newton's method from the nearest sample, for many points at once."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.geometry.surface import Partials, Surface

ROUNDS: Final = 30
DONE: Final = 1e-13
"""A step below this share of the parameter's interval ends the search."""
SAMPLES: Final = 4
"""Samples of a knot span in each direction, from which the search starts."""
CHUNK: Final = 65536


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
    """Feet of points (n, 3). `near`: parameters to start from, where they are known.

    The foot minimizes the distance over the whole patch as far as the samples tell: between two parts of the surface
    that are equally near, to within a sample's spacing, either may be taken.
    """
    points = np.atleast_2d(np.asarray(points_mm, float))
    u, v = _seeds(surface, points) if near is None else (np.array(near[0], float), np.array(near[1], float))
    for start in range(0, len(points), CHUNK):
        some = slice(start, start + CHUNK)
        u[some], v[some] = _searched(surface, points[some], u[some], v[some])
    at = surface.partials(u, v)
    normal = surface.normal_of(at)
    off = points - at.point_mm
    along = np.sum(off * normal, axis=1)
    sideways = np.linalg.norm(off - along[:, None] * normal, axis=1)
    beyond = np.where(_on_edge(surface, u, v), sideways, 0.0)
    return Feet(u, v, at.point_mm, normal, along, beyond)


def _seeds(surface: Surface, points: Array) -> tuple[Array, Array]:
    from scipy.spatial import KDTree  # slow to import

    us, vs = (_samples(k) for k in (surface.knots_u, surface.knots_v))
    tree = KDTree(surface.grid_mm(us, vs).reshape(-1, 3))
    _, index = tree.query(points)
    return us[index // len(vs)], vs[index % len(vs)]


def _samples(knots: Array) -> Array:
    """A few places in every knot span, at least fifty in all."""
    spans = np.unique(knots)
    each = max(SAMPLES, -(-50 // (len(spans) - 1)))
    inner = spans[:-1, None] + np.diff(spans)[:, None] * np.arange(each) / each
    return np.append(inner.ravel(), spans[-1])


def _searched(surface: Surface, points: Array, u: Array, v: Array) -> tuple[Array, Array]:
    (u0, u1), (v0, v1) = surface.domain
    width = np.array([u1 - u0, v1 - v0])
    low, high = np.array([u0, v0]), np.array([u1, v1])
    at, active = np.stack([u, v], axis=1), np.arange(len(points))
    for _ in range(ROUNDS):
        here = surface.partials(at[active, 0], at[active, 1])
        step = _step(here, points[active], at[active], low, high)
        step = _no_farther(surface, points[active], at[active], here.point_mm, step, low, high)
        at[active] = np.clip(at[active] + step, low, high)
        active = active[np.any(np.abs(step) > DONE * width, axis=1)]
        if not len(active):
            break
    return at[:, 0], at[:, 1]


def _step(here: Partials, points: Array, at: Array, low: Array, high: Array) -> Array:
    """Newton's step towards the least distance; Gauss–Newton's where the curvature would lead away.

    At a bound that the gradient pushes against, the search goes on along the edge.
    """
    r = here.point_mm - points
    gradient = np.stack([_dot(r, here.du), _dot(r, here.dv)], axis=1)
    a, b, c = _dot(here.du, here.du), _dot(here.du, here.dv), _dot(here.dv, here.dv)
    newton = np.stack([a + _dot(r, here.duu), b + _dot(r, here.duv), c + _dot(r, here.dvv)], axis=1)
    gauss = np.stack([a, b, c], axis=1)
    convex = (newton[:, 0] > 0) & (newton[:, 0] * newton[:, 2] > newton[:, 1] ** 2)
    a, b, c = np.where(convex[:, None], newton, gauss).T
    held = ((at <= low) & (gradient > 0)) | ((at >= high) & (gradient < 0))
    area = np.maximum(a * c - b * b, 1e-300)
    both = np.stack([b * gradient[:, 1] - c * gradient[:, 0], b * gradient[:, 0] - a * gradient[:, 1]], axis=1)
    single = -gradient / np.maximum(np.stack([a, c], axis=1), 1e-300)
    step = np.where(np.any(held, axis=1)[:, None], single, both / area[:, None])
    return np.where(held, 0.0, step)


def _no_farther(
    surface: Surface, points: Array, at: Array, here_mm: Array, step: Array, low: Array, high: Array
) -> Array:
    """The step, halved where it would lead farther away."""
    limit = np.sum((here_mm - points) ** 2, axis=1)
    slack = 1e-12 * (limit + 1e-12)
    for _ in range(4):
        to = np.clip(at + step, low, high)
        farther = np.sum((surface.point_mm(to[:, 0], to[:, 1]) - points) ** 2, axis=1) > limit + slack
        if not np.any(farther):
            break
        step = np.where(farther[:, None], step / 2, step)
    return step


def _on_edge(surface: Surface, u: Array, v: Array) -> np.ndarray:
    (u0, u1), (v0, v1) = surface.domain
    return np.asarray((u <= u0) | (u >= u1) | (v <= v0) | (v >= v1))


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("nk,nk->n", a, b))
