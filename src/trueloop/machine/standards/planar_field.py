"""Position errors of a machine in a plane as one field, where the axes are not separated: drilled plates, patterns.

A field answers E(x, y) = actual − commanded, (n, 2) mm. The correction is −E at the commanded position.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.standards.pattern_likelihood import Complex, PatternLikelihood, same_tool, smooth_covariance
from trueloop.machine.standards.similarity import as_complex, fit_similarity

SOME = 400
"""Holes among which the likeliest parameters are sought first: the work grows with the cube of their number."""

SOME_STEPS, WHOLE_STEPS, NEAR_STEPS = 40, 5, 2
"""Steps of the search among these, from there among all, and among all from a field of nearly the same plates."""


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

    @property
    def parameters(self) -> Array:
        """Length, spread, spread of the tools and noise, mm."""
        return np.array([self.length_mm, self.spread_mm, self.tool_spread_mm, self.noise_mm])

    def error_mm(self, point_mm: Array, tool: Array | None = None) -> Array:
        """E at (n, 2) points, without the tools' offsets unless `tool` (n,) says which made the hole."""
        cover = smooth_covariance(point_mm, self.known_mm, self.length_mm, self.spread_mm)
        if tool is not None:
            cover = cover + self.tool_spread_mm**2 * same_tool(tool, self.known_tool)
        found = cover @ self.weight - self.offset_mm - self.slope * as_complex(point_mm)
        return np.column_stack([found.real, found.imag])


def fit_pattern(plates: Sequence[Plate], start: Array | None = None) -> PatternField:
    """The field that plates have in common, each plate's own similarity (its clamping, its temperature) taken out.

    x and y errors are independent draws of one process with Matérn-3/2 covariance along x times that along y: once
    differentiable, so that a correction has a slope, and rougher than a polynomial. Its four parameters maximise the
    restricted likelihood [Rasmussen & Williams 2006, Eq. 2.45: linear nuisance parameters integrated out], sought from
    `start` (those of a field of nearly the same plates) or from what some of the holes say. Written in complex numbers
    because a similarity is linear in them. Raises MCH-DATA for less than 12 holes.
    """
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
    whole = PatternLikelihood(nominal, tool, error, nuisance)
    if start is None:
        found, _ = whole.most_likely(*_start(plates, whole))
    else:
        found, _ = whole.most_likely(start, NEAR_STEPS)
    pattern = PatternField(nominal, tool, whole.weight(found), *found.tolist())
    own = fit_similarity(nominal, nominal + pattern.error_mm(nominal))
    return replace(pattern, offset_mm=own.offset, slope=own.slope)


def _start(plates: Sequence[Plate], whole: PatternLikelihood) -> tuple[Array, int, Array]:
    """The likeliest parameters of some holes of every plate, near those of all, and how to go on from there."""
    counts = [len(plate.nominal_mm) for plate in plates]
    ends, share = np.cumsum([0, *counts]), min(1.0, SOME / sum(counts))
    some = np.concatenate(
        [
            np.unique(np.linspace(start, start + count - 1, max(int(count * share), min(count, 4))).astype(int))
            for start, count in zip(ends, counts, strict=False)
        ]
    )
    nominal, tool = (
        np.concatenate([getattr(plate, name) for plate in plates])[some] for name in ("nominal_mm", "tool")
    )
    few = PatternLikelihood(nominal, tool, whole.error[some], whole.nuisance[some])
    extent = float(np.ptp(nominal, axis=0).max())
    rest = whole.error - whole.nuisance @ np.linalg.lstsq(whole.nuisance, whole.error, rcond=None)[0]
    scale = float(np.std(rest))
    starts = [np.array([extent * share, scale, scale / 2, scale / 2]) for share in (0.1, 0.3)]
    found = [few.most_likely(start, SOME_STEPS) for start in starts]
    likeliest, curvature = min(found, key=lambda one: few.badness_and_slope(one[0])[0])
    return likeliest, WHOLE_STEPS, curvature * len(some) / sum(counts)


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
