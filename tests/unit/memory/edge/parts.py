"""Parts of one edge made up for tests, by a forward model of their own: sums of sines, no Gaussian process."""

import numpy as np

from trueloop.memory.made_part import CutErrors, MadePart

ANGLES = np.radians(np.linspace(5.0, 85.0, 17))


def errors(error_mm: np.ndarray, angle_rad: np.ndarray = ANGLES) -> CutErrors:
    """Errors on a dome."""
    n = len(angle_rad)
    names = tuple(str(k) for k in range(n))
    return CutErrors(("dome",) * n, names, angle_rad, np.asarray(error_mm, dtype=np.float64), np.full(n, 0.0004))


def made(
    order: int,
    rng: np.random.Generator,
    *,
    gain: float = 1.0,
    correction_mm: np.ndarray | None = None,
    angle_rad: np.ndarray = ANGLES,
    part_type: str = "dome",
) -> MadePart:
    """Part `order` of an edge with a worn nose: what the actuator makes of its correction is inspected."""
    form = 0.015 * np.sin(3.0 * angle_rad) + 0.020 * np.sin(angle_rad) - 0.010 * np.cos(angle_rad)
    moved = 0.002 * (rng.normal() * np.sin(angle_rad) + rng.normal() * np.cos(angle_rad))
    touched = form + moved + 0.0015 * rng.normal(size=len(angle_rad))
    uncorrected = form + moved + 0.003 * np.cos(2.0 * angle_rad) + 0.0015 * rng.normal(size=len(angle_rad))
    taken = touched if correction_mm is None else correction_mm
    finish = errors(uncorrected - gain * taken, angle_rad)
    return MadePart(part_type, str(order), "1", float(order), errors(touched, angle_rad), finish, taken)


def series(count: int, seed: int = 0, gain: float = 1.0) -> tuple[MadePart, ...]:
    """Parts of one type, each corrected by its own touches."""
    rng = np.random.default_rng(seed)
    return tuple(made(order, rng, gain=gain) for order in range(count))
