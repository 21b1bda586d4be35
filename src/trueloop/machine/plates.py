"""Patterns of drilled plates: judged by the plate that each leaves out, and as tables to correct programs by."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.machine.planar_field import PatternField, Plate, fit_pattern
from trueloop.machine.similarity import fit_similarity


@dataclass(frozen=True)
class PlaneTable:
    """The correction −E at the nodes of a grid, (nx, ny, 2) mm, linear between them.

    `deviation_mm` is the largest distance from the pattern in the middle of a cell.
    """

    x_mm: Array
    y_mm: Array
    correction_mm: Array
    deviation_mm: float


def left_out(plates: Sequence[Plate]) -> list[float | None]:
    """RMS in mm of each plate's residuals after the pattern of the others and its own similarity; None of one alone."""
    if len(plates) < 2:
        return [None] * len(plates)
    return [
        after_pattern_mm(fit_pattern([other for j, other in enumerate(plates) if j != k]), plate)
        for k, plate in enumerate(plates)
    ]


def after_pattern_mm(pattern: PatternField, plate: Plate) -> float:
    """RMS of a plate's residuals after a pattern, its tools' offsets too, and its own similarity."""
    known = pattern.error_mm(plate.nominal_mm, plate.tool)
    return fit_similarity(plate.nominal_mm, plate.measured_mm - known).rms_mm


def pattern_table(pattern: PatternField, step_mm: float, margin_mm: float = 0.0) -> PlaneTable:
    """A grid over all holes of the plates and a margin, where it is a guess; its steps `step_mm` at the most."""
    low, high = pattern.known_mm.min(axis=0) - margin_mm, pattern.known_mm.max(axis=0) + margin_mm
    x, y = (np.linspace(a, b, int(np.ceil((b - a) / step_mm)) + 1) for a, b in zip(low, high, strict=True))
    correction = -_at(pattern, x, y)
    middle = 0.25 * (correction[:-1, :-1] + correction[1:, :-1] + correction[:-1, 1:] + correction[1:, 1:])
    off = middle + _at(pattern, 0.5 * (x[:-1] + x[1:]), 0.5 * (y[:-1] + y[1:]))
    return PlaneTable(x, y, correction, float(np.hypot(off[..., 0], off[..., 1]).max(initial=0.0)))


def _at(pattern: PatternField, x: Array, y: Array) -> Array:
    """E at the nodes of a grid, (nx, ny, 2), a column of the grid at a time."""
    return np.stack([pattern.error_mm(np.column_stack([np.full(len(y), at), y])) for at in x])
