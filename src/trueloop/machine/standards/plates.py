"""Patterns of drilled plates: judged by the plate that each leaves out, and as tables to correct programs by."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.standards.planar_field import PatternField, Plate, fit_pattern
from trueloop.machine.standards.similarity import Similarity, fit_similarity
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

GAIN: Final = 0.1
"""Share of the RMS by which plates left out have to be better: less comes of chance with a hundred holes."""


@dataclass(frozen=True)
class PlaneTable:
    """The correction −E at the nodes of a grid, (nx, ny, 2) mm, linear between them.

    `deviation_mm` is the largest distance from the pattern in the middle of a cell.
    """

    x_mm: Array
    y_mm: Array
    correction_mm: Array
    deviation_mm: float


@dataclass(frozen=True)
class LeftOut:
    """RMS in mm of one plate's holes about its own similarity, as measured and with the correction of the others.

    That is what a program corrected by the table would have left: the tools' offsets are not in it.
    """

    plate: str
    before_mm: float
    after_mm: float


def left_out(plates: Sequence[Plate], names: Sequence[str], pattern: PatternField) -> Iterator[LeftOut]:
    """Each plate judged by the pattern of the others, one after the other; none of one alone.

    Their parameters are sought from those of the `pattern` of all.
    """
    for k, (plate, name) in enumerate(zip(plates, names, strict=True)):
        others = [other for j, other in enumerate(plates) if j != k]
        if others:
            known = fit_pattern(others, pattern.parameters).error_mm(plate.nominal_mm)
            before, after = (fit_similarity(plate.nominal_mm, plate.measured_mm - off).rms_mm for off in (0, known))
            yield LeftOut(name, before, after)


@dataclass(frozen=True, eq=False)
class JudgedPattern:
    """What plates have in common, each one's own similarity, how each is left by the others' pattern, and a table."""

    fits: tuple[Similarity, ...]
    pattern: PatternField
    left: tuple[LeftOut, ...]
    table: PlaneTable

    @property
    def not_repeating(self) -> str:
        """Why the pattern is not known to repeat on the next plate; empty where it is."""
        return not_repeating(self.left)

    @property
    def after_mm(self) -> tuple[float | None, ...]:
        """RMS of each plate with the correction of the others; None of a single plate."""
        return tuple(one.after_mm for one in self.left) or (None,) * len(self.fits)


def judged_pattern(
    plates: Sequence[Plate],
    names: Sequence[str],
    step_mm: float,
    margin_mm: float = 0.0,
    progress: Callable[[str], object] = str,
) -> JudgedPattern:
    """The pattern of drilled plates, judged by each plate; `step_mm` and `margin_mm` as in `pattern_table`."""
    fits = tuple(fit_similarity(plate.nominal_mm, plate.measured_mm) for plate in plates)
    pattern, left = fit_pattern(plates), list[LeftOut]()
    progress(f"plate 1 of {len(plates)} by the others")
    for one in left_out(plates, names, pattern):
        left.append(one)
        progress(f"plate {len(left) + 1} of {len(plates)} by the others")
    return JudgedPattern(fits, pattern, tuple(left), pattern_table(pattern, step_mm, margin_mm))


def not_repeating(left: Sequence[LeftOut]) -> str:
    """Why the pattern is not known to repeat on the next plate; empty where it is.

    It is known to where the plates left out are better together by `GAIN` at least, and most of them by themselves.
    """
    if len(left) < 2:
        return f"{len(left)} plates were left out and predicted: nothing shows that the pattern repeats"
    before, after = (rms(np.array([getattr(one, name) for one in left])) for name in ("before_mm", "after_mm"))
    worse = sum(one.after_mm >= one.before_mm for one in left)
    if after <= (1 - GAIN) * before and 2 * worse < len(left):
        return ""
    return (
        f"{len(left)} plates left out: {UM_PER_MM * before:.1f} → {UM_PER_MM * after:.1f} µm RMS, {worse} of them "
        "worse: the pattern does not repeat enough to correct by it"
    )


def require_repeating(left: Sequence[LeftOut] | None) -> None:
    """Raises MCH-PATTERN for a pattern that is not known to repeat; a table that is of no plates (None) passes."""
    if left is not None and (why := not_repeating(left)):
        raise TrueloopError(
            Code.MCH_PATTERN,
            why,
            hint="measure more plates, cut one after the other; a plate drilled with the correction is the best judge",
            override="--unproven",
            values={"plates": len(left)},
        )


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
