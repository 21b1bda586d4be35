"""Calibrated plates and positioning tests."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

Complex = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]
Row = np.ndarray[tuple[int], np.dtype[np.float64]]

ROUNDING = 1e-12
"""Share of spread² on the diagonal, so that holes in one place have a covariance that can be inverted."""

FAR = 12.0
"""Bound of the search: parameters leave their start by factors below exp(12)."""


class PatternLikelihood:
    """Parameters are (length, spread, tool spread, noise) in mm."""

    def __init__(self, nominal_mm: Array, tool: Array, error: Complex, nuisance: Complex) -> None:
        self.dx, self.dy = (np.sqrt(3.0) * np.abs(np.subtract.outer(at, at)) for at in nominal_mm.T)
        self.same = same_tool(tool, tool)
        self.error, self.nuisance = error, nuisance

    def most_likely(self, start: Array, steps: int, curvature: Array | None = None) -> tuple[Array, Array]:
        """Returns the likeliest parameters that so many steps of BFGS lead to, and the inverse of the curvature there.

        That is (4, 4) by the logarithms of the parameters, from which the search among other holes may start.
        """
        from scipy.optimize import minimize

        first: Row = np.log(start).reshape(4)

        def badness(logs: Row) -> tuple[float, Row]:
            value, slopes = self.badness_and_slope(np.exp(np.clip(logs, first - FAR, first + FAR)))
            return value, slopes.reshape(4)

        inverse = np.eye(4) * 4 / len(self.error) if curvature is None else curvature
        options: Any = {"maxiter": steps, "gtol": 0.1, "hess_inv0": inverse}
        found = minimize(badness, first, jac=True, method="BFGS", options=options)
        curvature = np.asarray(found.hess_inv, dtype=np.float64)
        return np.asarray(np.exp(found.x), dtype=np.float64), 0.5 * (curvature + curvature.T)

    def badness_and_slope(self, parameters: Array) -> tuple[float, Array]:
        """Minus twice the logarithm, and its slopes by the logarithms of the parameters (4,)."""
        from scipy.linalg import cho_solve, cholesky
        from scipy.linalg.lapack import dpotri

        length, spread, tools, noise = parameters.tolist()
        smooth, stretched = self._smooth(length)
        lower = cholesky(self._covariance(smooth, parameters), lower=True, overwrite_a=True, check_finite=False)
        both = np.column_stack([self.nuisance, self.error])
        solved = cho_solve((lower, True), np.hstack([both.real, both.imag]), check_finite=False)
        inverse_x, inverse_e = np.split(solved[:, : both.shape[1]] + 1j * solved[:, both.shape[1] :], [-1], axis=1)
        normal = self.nuisance.conj().T @ inverse_x
        weight = inverse_e[:, 0] - inverse_x @ np.linalg.solve(normal, self.nuisance.conj().T @ inverse_e[:, 0])
        badness = 2 * np.log(np.diag(lower)).sum() + np.linalg.slogdet(normal)[1] + np.vdot(self.error, weight).real
        inverse, _ = dpotri(lower, lower=True, overwrite_c=True)
        # P − weight weightᴴ is Hermitian and ∂K real and symmetric: the real part alone counts
        taken = np.hstack([inverse_x @ np.linalg.inv(np.linalg.cholesky(normal)).conj().T, weight[:, None]])
        root = np.hstack([taken.real, taken.imag])
        diagonal = np.diag(inverse) - np.einsum("ij,ij->i", root, root)

        def slope(change: Array) -> float:
            """Returns the slope. The lower triangle of the inverse counts twice, its diagonal once."""
            below = 2 * float(np.vdot(inverse, change)) - float(np.diag(inverse) @ np.diag(change))
            return below - float(np.vdot(root, change @ root))

        slopes = [
            spread**2 * slope(stretched),
            2 * spread**2 * (slope(smooth) + ROUNDING * diagonal.sum()),
            2 * tools**2 * slope(self.same),
            2 * noise**2 * diagonal.sum(),
        ]
        return float(badness), np.array(slopes)

    def weight(self, parameters: Array) -> Complex:
        """Returns Pe (n,): covariances with the holes times it are the pattern's values."""
        from scipy.linalg import cho_solve, cholesky

        lower = cholesky(self._covariance(self._smooth(parameters[0])[0], parameters), lower=True)
        both = np.column_stack([self.nuisance, self.error])
        solved = cho_solve((lower, True), both.real) + 1j * cho_solve((lower, True), both.imag)
        normal = self.nuisance.conj().T @ solved[:, :-1]
        found: Complex = solved[:, -1] - solved[:, :-1] @ np.linalg.solve(
            normal, self.nuisance.conj().T @ solved[:, -1]
        )
        return found

    def _covariance(self, smooth: Array, parameters: Array) -> Array:
        _, spread, tools, noise = parameters
        covariance: Array = spread**2 * smooth + tools**2 * self.same
        covariance[np.diag_indices_from(covariance)] += noise**2 + ROUNDING * spread**2
        return covariance

    def _smooth(self, length: float) -> tuple[Array, Array]:
        """Returns the correlation of all pairs of holes, and its slope by the logarithm of the length."""
        x, y = self.dx / length, self.dy / length
        fall = np.exp(-(x + y))
        left, right = 1 + x, 1 + y
        return left * right * fall, (x * x * right + y * y * left) * fall


def same_tool(left: Array, right: Array) -> Array:
    """Returns 1 where holes share a tool, whose offset they share; tool 0 is the reference."""
    return np.asarray((left[:, None] == right[None]) & (left[:, None] > 0), dtype=np.float64)


@dataclass(frozen=True)
class Similarity:
    """measured ≈ offset + scale · R(rotation) · nominal; `residual_mm` (n, 2) is what is left, measured − fitted."""

    offset_mm: tuple[float, float]
    scale: float
    rotation_rad: float
    residual_mm: Array

    @property
    def offset(self) -> complex:
        """Returns the offset as a complex number."""
        return complex(*self.offset_mm)

    @property
    def slope(self) -> complex:
        """Returns the deviation from the identity, scale · exp(i rotation) − 1."""
        return complex(self.scale * np.exp(1j * self.rotation_rad) - 1.0)

    @property
    def rms_mm(self) -> float:
        """Returns the root mean square of the residuals' lengths."""
        return float(np.sqrt(np.mean(np.sum(self.residual_mm**2, axis=1))))


def fit_similarity(nominal_mm: Array, measured_mm: Array) -> Similarity:
    """Least-squares similarity of (n, 2) points; in complex numbers w ≈ a + b z. Raises MCH-DATA below 3 points."""
    if len(nominal_mm) < 3 or nominal_mm.shape != measured_mm.shape:
        raise Code.MCH_DATA.refusal(
            f"{len(nominal_mm)} nominal and {len(measured_mm)} measured points do not determine a similarity",
            hint="give three pairs of points at least",
        )
    z, w = as_complex(nominal_mm), as_complex(measured_mm)
    rows = np.column_stack([np.ones_like(z), z])
    (a, b), *_ = np.linalg.lstsq(rows, w, rcond=None)
    rest = w - rows @ np.array([a, b])
    return Similarity((a.real, a.imag), float(abs(b)), float(np.angle(b)), np.column_stack([rest.real, rest.imag]))


def as_complex(points: Array) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    """Returns (n, 2) points as n complex numbers."""
    number: np.ndarray[tuple[int], np.dtype[np.complex128]] = points[:, 0] + 1j * points[:, 1]
    return number


SOME = 400
"""Holes among which the likeliest parameters are sought first: the work grows with the cube of their number."""

SOME_STEPS, WHOLE_STEPS, NEAR_STEPS = 40, 5, 2
"""Steps of the search among these, from there among all, and among all from a field of nearly the same plates."""


class PlanarField(Protocol):
    """Anything that knows E in a plane."""

    def error_mm(self, point_mm: Array) -> Array:
        """Returns E at (n, 2) points."""
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
        """Returns E at (n, 2) points."""
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
        """Returns length, spread, spread of the tools and noise, mm."""
        return np.array([self.length_mm, self.spread_mm, self.tool_spread_mm, self.noise_mm])

    def error_mm(self, point_mm: Array, tool: Array | None = None) -> Array:
        """Returns E at (n, 2) points, without the tools' offsets unless `tool` (n,) is the tool that made the hole."""
        # The Matérn-3/2 covariance along each axis, multiplied: errors arise axis by axis
        x, y = (
            np.sqrt(3.0) / self.length_mm * np.abs(np.subtract.outer(point_mm[:, k], self.known_mm[:, k]))
            for k in (0, 1)
        )
        cover: Array = self.spread_mm**2 * (1 + x) * (1 + y) * np.exp(-x - y)
        if tool is not None:
            cover = cover + self.tool_spread_mm**2 * same_tool(tool, self.known_tool)
        found = cover @ self.weight - self.offset_mm - self.slope * as_complex(point_mm)
        return np.column_stack([found.real, found.imag])


def fit_pattern(plates: Sequence[Plate], start: Array | None = None) -> PatternField:
    """Fits the field that plates have in common, each plate's own similarity (its clamping, its temperature) taken out.

    x and y errors are independent draws of one process with Matérn-3/2 covariance along x times that along y: once
    differentiable, so that a correction has a slope, and rougher than a polynomial. Its four parameters maximise the
    restricted likelihood [Rasmussen & Williams 2006, Eq. 2.45: linear nuisance parameters integrated out], sought from
    `start` (those of a field of nearly the same plates) or from those of some of the holes. Written in complex numbers
    because a similarity is linear in them. Raises MCH-DATA for less than 12 holes.
    """
    nominal = np.concatenate([plate.nominal_mm for plate in plates])
    tool = np.concatenate([plate.tool for plate in plates])
    if len(nominal) < 12:
        raise Code.MCH_DATA.refusal(
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
    """Returns the likeliest parameters of some holes of every plate, near those of all, to begin the search."""
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
    """Returns offset, scale and rotation of each plate: two complex columns a plate."""
    count = sum(len(plate.nominal_mm) for plate in plates)
    columns, start = np.zeros((count, 2 * len(plates)), dtype=complex), 0
    for k, plate in enumerate(plates):
        rows = slice(start, start + len(plate.nominal_mm))
        columns[rows, 2 * k] = 1.0
        columns[rows, 2 * k + 1] = as_complex(plate.nominal_mm) / np.ptp(plate.nominal_mm)
        start = rows.stop
    return columns


GAIN: Final = 0.1
"""Share of the RMS by which plates left out have to be better: less comes of chance with a hundred holes."""


@dataclass(frozen=True)
class PlaneTable:
    """The correction −E at a grid's nodes, (nx, ny, 2) mm, linear between; `deviation_mm`: largest off, mid-cell."""

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
    """Judges each plate by the pattern of the others, sought from the `pattern` of all; none of one alone."""
    for k, (plate, name) in enumerate(zip(plates, names, strict=True)):
        others = [other for j, other in enumerate(plates) if j != k]
        if others:
            known = fit_pattern(others, pattern.parameters).error_mm(plate.nominal_mm)
            before, after = (fit_similarity(plate.nominal_mm, plate.measured_mm - off).rms_mm for off in (0, known))
            yield LeftOut(name, before, after)


@dataclass(frozen=True, eq=False)
class JudgedPattern:
    """The plates' common pattern, each one's similarity, its residuals by the others' pattern, and a table."""

    fits: tuple[Similarity, ...]
    pattern: PatternField
    left: tuple[LeftOut, ...]
    table: PlaneTable

    @property
    def not_repeating(self) -> str:
        """Returns why the pattern is not known to repeat on the next plate; empty where it is."""
        return not_repeating(self.left)

    @property
    def after_mm(self) -> tuple[float | None, ...]:
        """Returns the RMS of each plate with the correction of the others; None of a single plate."""
        return tuple(left_out.after_mm for left_out in self.left) or (None,) * len(self.fits)


def judged_pattern(
    plates: Sequence[Plate],
    names: Sequence[str],
    step_mm: float,
    margin_mm: float = 0.0,
    progress: Callable[[str], object] = str,
) -> JudgedPattern:
    """Returns the pattern of drilled plates, judged by each plate; `step_mm` and `margin_mm` as in `pattern_table`."""
    fits = tuple(fit_similarity(plate.nominal_mm, plate.measured_mm) for plate in plates)
    pattern, left = fit_pattern(plates), list[LeftOut]()
    progress(f"plate 1 of {len(plates)} by the others")
    for one in left_out(plates, names, pattern):
        left.append(one)
        progress(f"plate {len(left) + 1} of {len(plates)} by the others")
    return JudgedPattern(fits, pattern, tuple(left), pattern_table(pattern, step_mm, margin_mm))


def not_repeating(left: Sequence[LeftOut]) -> str:
    """Returns why the pattern is not known to repeat on the next plate; empty where it is.

    It is known to where the plates left out are better together by `GAIN` at least, and most of them by themselves.
    """
    if len(left) < 2:
        return f"{len(left)} plates were left out and predicted: nothing shows that the pattern repeats"
    before, after = (
        rms(np.array([getattr(left_out, name) for left_out in left])) for name in ("before_mm", "after_mm")
    )
    worse = sum(left_out.after_mm >= left_out.before_mm for left_out in left)
    if after <= (1 - GAIN) * before and 2 * worse < len(left):
        return ""
    return (
        f"{len(left)} plates left out: {UM_PER_MM * before:.1f} → {UM_PER_MM * after:.1f} µm RMS, {worse} of them "
        "worse: the pattern does not repeat enough to correct by it"
    )


def require_repeating(left: Sequence[LeftOut] | None) -> None:
    """Raises MCH-PATTERN for a pattern that is not known to repeat; a table that is of no plates (None) passes."""
    if left is not None and (why := not_repeating(left)):
        raise Code.MCH_PATTERN.refusal(
            why,
            hint="measure more plates, cut one after the other; a plate drilled with the correction is the best judge",
            override="--unproven",
            values={"plates": len(left)},
        )


def pattern_table(pattern: PatternField, step_mm: float, margin_mm: float = 0.0) -> PlaneTable:
    """Tabulates the pattern over all holes and a margin, where it is a guess, in steps of `step_mm` at the most."""
    low, high = pattern.known_mm.min(axis=0) - margin_mm, pattern.known_mm.max(axis=0) + margin_mm
    x, y = (np.linspace(a, b, int(np.ceil((b - a) / step_mm)) + 1) for a, b in zip(low, high, strict=True))
    correction = -_at(pattern, x, y)
    middle = 0.25 * (correction[:-1, :-1] + correction[1:, :-1] + correction[:-1, 1:] + correction[1:, 1:])
    off = middle + _at(pattern, 0.5 * (x[:-1] + x[1:]), 0.5 * (y[:-1] + y[1:]))
    return PlaneTable(x, y, correction, float(np.hypot(off[..., 0], off[..., 1]).max(initial=0.0)))


def _at(pattern: PatternField, x: Array, y: Array) -> Array:
    """Returns E at the nodes of a grid, (nx, ny, 2), a column of the grid at a time."""
    return np.stack([pattern.error_mm(np.column_stack([np.full(len(y), at), y])) for at in x])


@dataclass(frozen=True)
class BothWays:
    """A value for the approach from below (↑), from above (↓), and for both together."""

    up: float
    down: float
    both: float


@dataclass(frozen=True)
class Positioning:
    """The standard's values. Arrays have one entry a target, in ascending order of `target`.

    `accuracy` A, A↑, A↓; `repeatability` R, R↑, R↓; `systematic` E, E↑, E↓; `mean_range` M; `reversal` B and its mean.
    `deviation_up` and `deviation_down` are the raw deviations (targets, approaches). All in mm, rad where `angular`.
    """

    target: Array
    deviation_up: Array
    deviation_down: Array
    mean_up: Array
    mean_down: Array
    spread_up: Array
    spread_down: Array
    accuracy: BothWays
    repeatability: BothWays
    systematic: BothWays
    mean_range: float
    reversal: float
    mean_reversal: float
    angular: bool = False


def positioning(target: Array, deviation_up: Array, deviation_down: Array, *, angular: bool = False) -> Positioning:
    """Analyses deviations (targets, approaches) of both ways, or of the one whose array is not empty (targets, 0).

    What a test of one way does not give is NaN: B, M, the other way, and A, R, E of both. Raises MCH-DATA for too few
    or missing approaches.
    """
    _check(target, deviation_up, deviation_down)
    order = np.argsort(target)
    up, down = deviation_up[order], deviation_down[order]
    mean_up, spread_up = _mean_and_spread(up)
    mean_down, spread_down = _mean_and_spread(down)
    reversal = mean_up - mean_down
    mean = 0.5 * (mean_up + mean_down)
    highest = np.array([mean_up + 2 * spread_up, mean_down + 2 * spread_down])
    lowest = np.array([mean_up - 2 * spread_up, mean_down - 2 * spread_down])
    means = np.array([mean_up, mean_down])
    at_target = np.array([4 * spread_up, 4 * spread_down, 2 * spread_up + 2 * spread_down + np.abs(reversal)])
    both = at_target if up.size and down.size else at_target[2:]
    return Positioning(
        target=target[order],
        deviation_up=up,
        deviation_down=down,
        mean_up=mean_up,
        mean_down=mean_down,
        spread_up=spread_up,
        spread_down=spread_down,
        accuracy=_spans(highest, lowest),
        repeatability=BothWays(float(at_target[0].max()), float(at_target[1].max()), float(both.max())),
        systematic=_spans(means, means),
        mean_range=float(np.ptp(mean)),
        reversal=float(np.abs(reversal).max()),
        mean_reversal=float(reversal.mean()),
        angular=angular,
    )


def _mean_and_spread(deviation: Array) -> tuple[Array, Array]:
    """Returns mean and standard deviation of each target's approaches; NaN where the test has no approach that way."""
    if not deviation.size:
        return np.full(len(deviation), np.nan), np.full(len(deviation), np.nan)
    return deviation.mean(axis=1), deviation.std(axis=1, ddof=1)


def _spans(highest: Array, lowest: Array) -> BothWays:
    """Returns largest of the one minus smallest of the other: each way, and over both."""
    up, down = highest.max(axis=1) - lowest.min(axis=1)
    return BothWays(float(up), float(down), float(highest.max() - lowest.min()))


def _check(target: Array, up: Array, down: Array) -> None:
    one_way = not up.size or not down.size
    if (up.shape != down.shape and not one_way) or {len(up), len(down)} != {len(target)}:
        raise Code.MCH_DATA.refusal(
            f"{len(target)} targets, deviations ↑ {up.shape} and ↓ {down.shape} do not make one table",
            hint="every target needs the same number of approaches from below and from above, or all from one side",
        )
    given = [deviation for deviation in (up, down) if deviation.size]
    least = min((deviation.shape[1] for deviation in given), default=0)
    if len(target) < 2 or least < 2 or not all(np.isfinite(deviation).all() for deviation in given):
        raise Code.MCH_DATA.refusal(
            f"{len(target)} targets with {least} approaches each way, some missing: no spread can be computed",
            hint="the standard asks for five targets a metre at least and five approaches each way",
        )
