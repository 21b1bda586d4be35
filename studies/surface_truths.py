"""Simulated truths for judging how deviations of a surface are taken apart: splines, and what no spline is."""

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.spline_surface import Places, Size, SplineSurface

GRID: Final = np.linspace(0.0, 1.0, 25)
SIDE_MM: Final = 50.0
NOISE_MM: Final = 0.0022
"""A random part within ±6.5 µm [MPM §8], as the largest of 625 values."""
WAVES: Final = 60

Truth: TypeAlias = Callable[[np.random.Generator], Array]


def square_places() -> Places:
    """The published grid: 25 × 25 over a square of 50 mm."""
    u, v = (a.ravel() for a in np.meshgrid(GRID, GRID, indexing="ij"))
    return Places(np.stack([SIDE_MM * u, SIDE_MM * v, 0 * u], axis=1), u, v, GRID, GRID)


SQUARE: Final = square_places()
NEAR: Final = Neighbourhood(SQUARE)


def spline(rng: np.random.Generator, controls: int, scatter_mm: float) -> Array:
    """A spline surface with independent control values, at the grid's points."""
    values = rng.normal(0.0, scatter_mm, (controls, controls))
    return SplineSurface(Size(controls, controls), values).grid_mm(GRID, GRID).ravel()


def field(rng: np.random.Generator, length: float, scatter_mm: float) -> Array:
    """A smooth random field that forgets itself over `length`, as a share of the side."""
    waves, phase = rng.normal(0.0, 1.0 / length, (WAVES, 2)), rng.uniform(0.0, 2 * np.pi, WAVES)
    angles = np.outer(SQUARE.u, waves[:, 0]) + np.outer(SQUARE.v, waves[:, 1]) + phase
    return np.asarray(scatter_mm * np.sqrt(2 / WAVES) * np.sum(np.cos(angles), axis=1))


def _edges(rng: np.random.Generator) -> Array:
    u, v = SQUARE.u, SQUARE.v
    return np.asarray(0.020 * np.exp(-u / 0.08) + 0.008 * np.exp((v - 1) / 0.05) + field(rng, 0.3, 0.004))


def _step(rng: np.random.Generator) -> Array:
    along = (SQUARE.u + 0.3 * SQUARE.v - 0.6) / 0.03
    return np.asarray(0.004 * np.tanh(along) + field(rng, 0.3, 0.004))


def _bowed(rng: np.random.Generator) -> Array:
    bow = 0.1 * ((SQUARE.u - 0.5) ** 2 + (SQUARE.v - 0.4) ** 2) + 0.05 * SQUARE.u
    return bow + spline(rng, 9, 0.006)


TRUTHS: Final[dict[str, Truth]] = {
    "nothing but noise": lambda rng: 0.0 * SQUARE.u,
    "spline of 9 × 9, 8 µm": lambda rng: spline(rng, 9, 0.008),
    "the same of 6 µm on a bow of 100 µm": _bowed,
    "smooth field, waves over 10 mm": lambda rng: field(rng, 0.2, 0.006),
    "smooth field, waves over 5 mm": lambda rng: field(rng, 0.1, 0.006),
    "weak smooth field of 1 µm": lambda rng: field(rng, 0.3, 0.001),
    "waves along one side": lambda rng: 0.006 * np.sin(25 * SQUARE.u + rng.uniform(0, 6)),
    "steep at two edges": _edges,
    "a step of 8 µm": _step,
}


def white(rng: np.random.Generator) -> Array:
    """Normal noise."""
    return rng.normal(0.0, NOISE_MM, len(SQUARE.u))


def heavy(rng: np.random.Generator) -> Array:
    """Noise of the same scatter with heavy tails: Student's t with four degrees of freedom."""
    return np.asarray(rng.standard_t(4, len(SQUARE.u)) * NOISE_MM / np.sqrt(2.0))
