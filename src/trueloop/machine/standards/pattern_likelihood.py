"""How likely holes of drilled plates are under a pattern's four parameters, and the likeliest ones.

Errors are complex numbers e (n,), x in the real part; X (n, k) holds the plates' similarities. With the covariance
K = spread² S(length) + tools² T + noise² I of e, minus twice the restricted logarithmic likelihood is, apart from a
constant,

    log det K + log det XᴴK⁻¹X + eᴴPe,     P = K⁻¹ − K⁻¹X (XᴴK⁻¹X)⁻¹ XᴴK⁻¹,

and its slope by a parameter tr(P ∂K) − (Pe)ᴴ ∂K (Pe) [Rasmussen & Williams 2006, Eqs 2.45 and 5.9, restricted].
"""

from typing import Any

import numpy as np

from trueloop.arrays import Array

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
        """The likeliest parameters that so many steps of BFGS lead to, and the inverse of the curvature there.

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
            """The lower triangle of the inverse counts twice, its diagonal once."""
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
        """Pe (n,): covariances with the holes times it are the pattern's values."""
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
        """Correlation of all pairs of holes, and its slope by the logarithm of the length."""
        x, y = self.dx / length, self.dy / length
        fall = np.exp(-(x + y))
        left, right = 1 + x, 1 + y
        return left * right * fall, (x * x * right + y * y * left) * fall


def smooth_covariance(left_mm: Array, right_mm: Array, length: float, spread: float) -> Array:
    """Matérn-3/2 covariance along each axis, multiplied: errors arise axis by axis."""
    x, y = (np.sqrt(3.0) / length * np.abs(np.subtract.outer(left_mm[:, k], right_mm[:, k])) for k in (0, 1))
    covariance: Array = spread**2 * (1 + x) * (1 + y) * np.exp(-x - y)
    return covariance


def same_tool(left: Array, right: Array) -> Array:
    """1 where holes share a tool, whose offset they share; tool 0 is the reference."""
    return np.asarray((left[:, None] == right[None]) & (left[:, None] > 0), dtype=np.float64)
