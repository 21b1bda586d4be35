"""Position errors of a machine in a plane as one field, where the axes are not told apart: drilled plates, patterns.

A field answers E(x, y) = actual − commanded, (n, 2) mm. The correction is −E at the commanded position.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.similarity import as_complex, fit_similarity

Complex = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]


class PlanarField(Protocol):
    """Anything that knows E in a plane."""

    def error_mm(self, point_mm: Array) -> Array:
        """E at (n, 2) points."""
        ...


@dataclass(frozen=True)
class QuadrupoleField:
    """E = +m cos 2(θ − φ) · (x, y), θ the direction of (x, y): scales stretched along φ, shrunk across it.

    The correction x′ = x (1 − m cos 2(θ − φ)), y′ alike, undoes it to first order in m. Without unit: it holds in mm
    and inches alike.
    """

    magnitude: float
    angle_rad: float

    def error_mm(self, point_mm: Array) -> Array:
        """E at (n, 2) points."""
        direction = np.arctan2(point_mm[:, 1], point_mm[:, 0])
        return self.magnitude * np.cos(2 * (direction - self.angle_rad))[:, None] * point_mm


@dataclass(frozen=True)
class Plate:
    """One measured part: points (n, 2) and which tool made each (n,), 0, 1, …"""

    nominal_mm: Array
    measured_mm: Array
    tool: Array


@dataclass(frozen=True)
class PatternField:
    """A smooth field learnt from plates, with an offset for each tool; its prior is a Gaussian process.

    `length_mm`, `spread_mm`, `tool_spread_mm`, `noise_mm` are the most likely ones for the plates. Over their holes the
    field has no similarity of its own: `offset_mm` + `slope` · (x + iy), which nothing tells apart from how the plates
    lay and how warm they were, is taken out. Beyond the holes it is a guess.
    """

    known_mm: Array
    known_tool: Array
    weight: Complex
    length_mm: float
    spread_mm: float
    tool_spread_mm: float
    noise_mm: float
    offset_mm: complex = 0.0
    slope: complex = 0.0

    def error_mm(self, point_mm: Array, tool: Array | None = None) -> Array:
        """E at (n, 2) points, without the tools' offsets unless `tool` (n,) says which made the hole."""
        cover = _smooth(point_mm, self.known_mm, self.length_mm, self.spread_mm)
        if tool is not None:
            cover = cover + _tools(tool, self.known_tool, self.tool_spread_mm)
        found = cover @ self.weight - self.offset_mm - self.slope * as_complex(point_mm)
        return np.column_stack([found.real, found.imag])


def fit_pattern(plates: Sequence[Plate]) -> PatternField:
    """The field that plates have in common, each plate's own similarity (its clamping, its temperature) taken out.

    x and y errors are independent draws of one process with Matérn-3/2 covariance along x times that along y: once
    differentiable, so that a correction has a slope, and rougher than a polynomial. Its four parameters maximise the
    restricted likelihood [Rasmussen & Williams 2006, Eq. 2.45: linear nuisance parameters integrated out]. Written in
    complex numbers because a similarity is linear in them. Raises MCH-DATA for less than 12 holes.
    """
    from scipy.optimize import minimize

    nominal = np.concatenate([plate.nominal_mm for plate in plates])
    tool = np.concatenate([plate.tool for plate in plates])
    if len(nominal) < 12:
        raise TrueloopError(
            Code.MCH_DATA,
            f"{len(nominal)} holes on {len(plates)} plates do not determine a pattern",
            hint="measure twelve holes at least, spread over the plate",
        )
    error = np.concatenate([as_complex(plate.measured_mm - plate.nominal_mm) for plate in plates])
    nuisance = _similarities(plates)
    extent = float(np.ptp(nominal, axis=0).max())
    scale = float(np.std(error - nuisance @ np.linalg.lstsq(nuisance, error, rcond=None)[0]))
    starts = [np.log([extent * share, scale, scale / 2, scale / 2]) for share in (0.1, 0.3)]

    def badness(logarithms: Array) -> float:
        return _solve(np.exp(logarithms), nominal, tool, error, nuisance)[1]

    runs = [minimize(badness, start, method="Nelder-Mead", options={"maxiter": 600, "fatol": 1e-3}) for start in starts]
    length, spread, tool_spread, noise = (float(v) for v in np.exp(min(runs, key=lambda run: float(run.fun)).x))
    weight, _ = _solve(np.array([length, spread, tool_spread, noise]), nominal, tool, error, nuisance)
    pattern = PatternField(nominal, tool, weight, length, spread, tool_spread, noise)
    own = fit_similarity(nominal, nominal + pattern.error_mm(nominal))
    return replace(pattern, offset_mm=own.offset, slope=own.slope)


def _similarities(plates: Sequence[Plate]) -> Complex:
    """Offset, scale and rotation of each plate: two complex columns a plate."""
    count = sum(len(plate.nominal_mm) for plate in plates)
    columns, start = np.zeros((count, 2 * len(plates)), dtype=complex), 0
    for k, plate in enumerate(plates):
        rows = slice(start, start + len(plate.nominal_mm))
        columns[rows, 2 * k] = 1.0
        columns[rows, 2 * k + 1] = as_complex(plate.nominal_mm) / np.ptp(plate.nominal_mm)
        start = rows.stop
    return columns


def _solve(parameters: Array, nominal: Array, tool: Array, error: Complex, nuisance: Complex) -> tuple[Complex, float]:
    """(weights, minus twice the restricted log likelihood up to a constant) for length, spread, tool spread, noise."""
    from scipy.linalg import solve_triangular

    length, spread, tool_spread, noise = parameters
    covariance = _smooth(nominal, nominal, length, spread) + _tools(tool, tool, tool_spread)
    covariance[np.diag_indices_from(covariance)] += noise**2 + 1e-12 * spread**2
    lower = np.linalg.cholesky(covariance)
    both = np.column_stack([nuisance, error])
    # real and imaginary parts side by side: a complex solve would make the triangle complex too
    solved = solve_triangular(lower, np.hstack([both.real, both.imag]), lower=True, check_finite=False)
    white = solved[:, : both.shape[1]] + 1j * solved[:, both.shape[1] :]
    columns, whitened = white[:, :-1], white[:, -1]
    normal = columns.conj().T @ columns
    rest = whitened - columns @ np.linalg.solve(normal, columns.conj().T @ whitened)
    badness = np.vdot(rest, rest).real + 2 * np.log(np.diag(lower)).sum() + np.linalg.slogdet(normal)[1]
    weight: Complex = np.linalg.solve(lower.T, rest).astype(np.complex128)
    return weight, float(badness)


def _smooth(left: Array, right: Array, length: float, spread: float) -> Array:
    """Matérn-3/2 covariance along each axis, multiplied: errors arise axis by axis."""
    x, y = (np.sqrt(3.0) / length * np.abs(np.subtract.outer(left[:, k], right[:, k])) for k in (0, 1))
    covariance: Array = spread**2 * (1 + x) * (1 + y) * np.exp(-x - y)
    return covariance


def _tools(left: Array, right: Array, spread: float) -> Array:
    """Holes of one tool share its offset; tool 0 is the reference."""
    same = (left[:, None] == right[None]) & (left[:, None] > 0)
    covariance: Array = spread**2 * same
    return covariance
