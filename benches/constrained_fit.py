"""The constrained cubic spline at 32 and 1,000 points, knots at every third, value and slope prescribed at both ends.

Beside ours: the report's generalized inverses [6517 Eq. 25] (mended, see `tests/support/truncated_powers.py`), scipy's
general optimizer SLSQP (32 points only), and the best that scipy's parts give by hand: design matrix, end coefficients
eliminated, banded Cholesky of the normal equations. The error is that of the curve at the points, against extended
precision.
"""

import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.optimize import LinearConstraint, minimize

from benches.ratio import Contender, compare
from tests.support import exact_spline, truncated_powers
from trueloop.turned.fit.spline import EndConditions, least_squares_spline

Array = NDArray[np.float64]
LENGTH_MM = 58.25
ENDS_MM = (0.0067, 0.0, -0.019, -0.0005)
KERNEL_AIM_US = {32: 5.0, 1000: 60.0}
PYTHON_AIM_US = {32: 100.0, 1000: 300.0}
ROOT = Path(__file__).parents[1]


@dataclass(frozen=True)
class Problem:
    """Points, values and knots of one size."""

    points: int

    @cached_property
    def s(self) -> Array:
        return LENGTH_MM * (np.arange(self.points) + 0.5) / self.points

    @cached_property
    def y(self) -> Array:
        noise = np.random.default_rng(self.points).standard_normal(self.points)
        return 0.01 * (np.sin(self.s / 7.0) + 0.1 * noise)

    @cached_property
    def knots(self) -> Array:
        knots = self.s[2::3]
        return np.asarray(knots[knots < self.s[-1]])

    @cached_property
    def full_knots(self) -> Array:
        return np.concatenate([np.zeros(4), self.knots, np.full(4, LENGTH_MM)])

    @cached_property
    def truth(self) -> Array:
        """The curve at the points, in extended precision."""
        exact = exact_spline.coefficients(
            list(self.s), list(self.y), list(self.knots), LENGTH_MM, 3, ENDS_MM, np.longdouble
        )
        t = [np.longdouble(k) for k in self.full_knots]
        rows = np.array([exact_spline.basis(np.longdouble(x), t, 3) for x in self.s])
        return np.asarray(rows @ exact, dtype=np.float64)

    def ours(self) -> Array:
        spline = least_squares_spline(self.s, self.y, self.knots, LENGTH_MM, 3, EndConditions(*ENDS_MM)).spline
        return spline.coefficients_mm

    def report(self) -> Array:
        f = np.array([ENDS_MM[0], ENDS_MM[2], ENDS_MM[1], ENDS_MM[3]])
        return truncated_powers.mended(self.s, self.y, self.knots, 0.0, LENGTH_MM, f)

    def _ends(self) -> tuple[Array, Array]:
        t = self.full_knots
        start = ENDS_MM[0] + np.array([0.0, ENDS_MM[1] * (t[4] - t[1]) / 3])
        end = ENDS_MM[2] - np.array([ENDS_MM[3] * (t[-2] - t[-5]) / 3, 0.0])
        return start, end

    def scipy_banded(self) -> Array:
        start, end = self._ends()
        design = BSpline.design_matrix(self.s, self.full_knots, 3).tocsc()
        free = design[:, 2:-2]
        rest = self.y - design[:, :2] @ start - design[:, -2:] @ end
        normal = free.T @ free
        n = normal.shape[0]
        band = np.zeros((4, n))
        for k in range(min(4, n)):
            band[3 - k, k:] = normal.diagonal(k)
        return np.concatenate([start, solveh_banded(band, np.asarray(free.T @ rest)), end])

    def slsqp(self) -> Array:
        design = BSpline.design_matrix(self.s, self.full_knots, 3).toarray()
        start, end = self._ends()
        n = design.shape[1]
        picked = np.eye(n)[[0, 1, n - 2, n - 1]]
        wanted = np.concatenate([start, end])

        def squares(c: Array) -> float:
            return float(np.sum((design @ c - self.y) ** 2))

        def gradient(c: Array) -> Array:
            return np.asarray(2.0 * design.T @ (design @ c - self.y), dtype=np.float64)

        held = LinearConstraint(picked, wanted, wanted)
        found = minimize(squares, np.zeros(n), jac=gradient, constraints=held, method="SLSQP", tol=1e-15)
        return np.asarray(found.x, dtype=np.float64)

    def in_b_splines(self, coefficients: Array) -> Array:
        return np.asarray(BSpline(self.full_knots, coefficients, 3)(self.s), dtype=np.float64)

    def in_truncated_powers(self, coefficients: Array) -> Array:
        return truncated_powers.design(self.s, self.knots) @ coefficients


def contender(name: str, problem: Problem, run: Callable[[], Array], curve: Callable[[Array], Array]) -> Contender:
    """With its accuracy as a note."""
    error_mm = float(np.max(np.abs(curve(run()) - problem.truth)))
    return Contender(name, run, f"{error_mm:.0e} mm")


def kernel_us() -> dict[int, float]:
    """Median time of the kernel alone, without Python, by number of points."""
    command = ["cargo", "run", "--quiet", "--release", "-p", "curve-fit", "--example", "time_fit"]
    printed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return {int(points): float(us) for points, us in (line.split() for line in printed.splitlines())}


def main() -> None:
    """Compare, and say where the aims stand."""
    alone = kernel_us()
    for points in (32, 1000):
        problem = Problem(points)
        rivals = [
            contender("trueloop", problem, problem.ours, problem.in_b_splines),
            contender("scipy, banded by hand", problem, problem.scipy_banded, problem.in_b_splines),
            contender("generalized inverses", problem, problem.report, problem.in_truncated_powers),
        ]
        if points == 32:
            rivals.append(contender("scipy SLSQP", problem, problem.slsqp, problem.in_b_splines))
        samples = compare(f"Constrained cubic spline, {points} points", rivals, note_heading="error")
        for what, us, aim in (
            ("the kernel alone", alone[points], KERNEL_AIM_US[points]),
            ("through Python", samples.median_s("trueloop") * 1e6, PYTHON_AIM_US[points]),
        ):
            print(f"{what}: {us:.3g} µs, {'within' if us <= aim else 'MISSES'} the aim of {aim:g} µs")


if __name__ == "__main__":
    main()
