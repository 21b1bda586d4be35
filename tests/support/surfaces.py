"""Surfaces, patterns and measured parts that tests share."""

import numpy as np
from scipy.spatial.distance import cdist

from trueloop.arrays import Array, for_kernel
from trueloop.geometry.surface import Surface, fit_grid
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.separation.moran import EXPONENT, Weights
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.spline_surface import Places, Size, SplineSurface
from trueloop_lab.simulator.mill import EndMill, MilledStock

GRID = np.linspace(0.0, 1.0, 25)


def wavy_surface(side_mm: float = 50.0, height_mm: float = 4.0) -> Surface:
    """A gentle free-form surface over a square, normals up."""
    x, y = np.meshgrid(np.linspace(0, side_mm, 21), np.linspace(0, side_mm, 21), indexing="ij")
    return fit_grid(np.stack([x, y, height_mm * np.sin(x / 14) * np.cos(y / 17)], axis=2)).surface


def sphere(radius_mm: float = 20.0) -> Surface:
    """An exact quarter by quarter of a sphere, as a rational surface of revolution, the poles cut off."""
    h = np.sqrt(0.5)
    arc = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])  # a quarter circle: equator to pole
    control, weights = np.empty((3, 3, 3)), np.outer([1, h, 1], [1, h, 1])
    for i, (c, s) in enumerate(arc):
        for j, (r, z) in enumerate(arc):
            control[i, j] = radius_mm * np.array([c * r, s * r, z])
    ends = np.array([0.0, 0, 0, 1, 1, 1])
    return Surface((2, 2), ends, ends, control, weights)


def square_places(count: int = 25, side_mm: float = 50.0) -> Places:
    """A regular grid over a flat square."""
    at = np.linspace(0.0, 1.0, count)
    u, v = (a.ravel() for a in np.meshgrid(at, at, indexing="ij"))
    return Places(np.stack([side_mm * u, side_mm * v, 0 * u], axis=1), u, v, at, at)


SQUARE = square_places()
NEAR = Neighbourhood(SQUARE)


def random_surface(rng: np.random.Generator, controls: int, scatter_mm: float, degree: int = 3) -> SplineSurface:
    """A spline surface with independent normal control values."""
    return SplineSurface(Size(controls, controls, degree), rng.normal(0.0, scatter_mm, (controls, controls)))


def on_grid(surface: SplineSurface, at: Array = GRID) -> Array:
    """Its values on the square grid, a row after the other."""
    return surface.grid_mm(at, at).ravel()


def ball_centres(program: bytes, radius_mm: float) -> Array:
    """Centres of a ball end along the feed moves of a program whose programmed point is the tip."""
    path = read_program(program, "linuxcnc").run()
    cutting = path.motion == Motion.LINE
    tips = np.concatenate([path.start_mm[cutting][:1], path.end_mm[cutting]])
    return np.asarray(tips + np.array([0.0, 0.0, radius_mm]))


def left_on_mm(centres_mm: Array, radius_mm: float, points_mm: Array, normal: Array) -> Array:
    """What a ball through these centres leaves at points of a surface, along its normals."""
    return MilledStock().cut_by(ball_end(radius_mm), [centres_mm]).height_mm(points_mm, normal, 0.5)


def ball_end(radius_mm: float, radius_error_mm: float = 0.0) -> EndMill:
    """A ball end, whose axis does not matter."""
    return EndMill(Cutter(radius_mm, radius_mm), radius_error_mm=radius_error_mm)


def points_to_csv(points_mm: Array, shape: tuple[int, int] | None = None) -> bytes:
    """Points as `read_points` reads them, to a nanometre; `shape` of a grid."""
    lines = ["row,column,x_mm,y_mm,z_mm" if shape else "x_mm,y_mm,z_mm"]
    for k, point in enumerate(points_mm):
        if np.all(np.isfinite(point)):
            place = f"{k // shape[1] + 1},{k % shape[1] + 1}," if shape else ""
            lines.append(place + ",".join(f"{value:.6f}" for value in point))
    return ("\n".join(lines) + "\n").encode()


def moran_i(points_mm: Array, values: Array, exponent: float = EXPONENT) -> float:
    """Moran's I = (n/S0) Σ c zᵢ zⱼ / Σ z² [MPM Eq. 2] of values (n,) at points (n, 3), z the values less their mean."""
    z = values - np.mean(values)
    total, products = Weights(for_kernel(points_mm), exponent).sums(z)
    return float(len(z) * products / (total * (z @ z)))


def error_of_products(weights: Weights, vectors: Array, product: Array) -> float:
    """Largest error of a product C V at places drawn by chance, as a share of Σ c |v| there, every pair worked off."""
    rows = np.random.default_rng(0).choice(weights.count, min(64, weights.count), replace=False)
    distance = np.maximum(cdist(weights.points_mm[rows], weights.points_mm), weights.nearest_mm)
    distance[np.arange(len(rows)), rows] = np.inf
    c = distance**-weights.exponent
    return float(np.max(np.abs(product[rows] - c @ vectors) / (c @ np.abs(vectors))))
