"""Splines over a grid by least squares, beside what a user would pick: geomdl, scipy's fitters, Open CASCADE."""

from collections.abc import Callable

import numpy as np

from benches.ratio import Contender, compare, compare_once, verdict
from trueloop._core import fit_surface_grid
from trueloop.formats.cad.kernel import kernel
from trueloop.geometry.surface import clamped_knots

SIZES = ((25, 15), (100, 40), (1000, 100))
SOON_MOST = 100
"""Beyond, one fit of the slower ones takes a minute and more: they are timed once."""


def main() -> None:
    """Compare the fits size by size, one value a grid point; geomdl and OCCT fit points in space."""
    for points, controls in SIZES:
        at = np.linspace(0.0, 1.0, points)
        values = np.random.default_rng(1).normal(0.0, 0.01, (points, points))
        slow = slow_contenders(at, values, controls)
        samples = compare(
            f"{points} × {points} points, {controls} × {controls} control values",
            contenders(at, values, controls) + (slow if points <= SOON_MOST else []),
            rounds=3 if points > SOON_MOST else 5,
        )
        verdict(samples, "trueloop", to="scipy, two passes", at_most=1 / 5)
        if points <= SOON_MOST:
            verdict(samples, "trueloop", to="geomdl", at_most=1 / 1000)
        else:
            compare_once(samples, "trueloop", slow)


def contenders(at: np.ndarray, values: np.ndarray, controls: int) -> list[Contender]:
    """Ours first, and the fast one."""
    return [
        Contender("trueloop", ours(at, values, controls)),
        Contender("scipy, two passes", two_passes(at, values, controls)),
    ]


def slow_contenders(at: np.ndarray, values: np.ndarray, controls: int) -> list[Contender]:
    """Those that do not know that the points stand on a grid, or work point by point."""
    return [
        Contender("scipy LSQBivariateSpline", scattered(at, values, controls)),
        Contender("geomdl", by_geomdl(at, values, controls)),
        Contender("Open CASCADE, interpolating", by_occt(at, values)),
    ]


def ours(at: np.ndarray, values: np.ndarray, controls: int) -> Callable[[], object]:
    """The Rust kernel."""
    inner = np.ascontiguousarray(clamped_knots(controls, 3)[4:-4])
    return lambda: fit_surface_grid((inner, inner), (3, 3), (at, at), values)


def two_passes(at: np.ndarray, values: np.ndarray, controls: int) -> Callable[[], object]:
    """One direction after the other, as someone who knows would do it."""
    from scipy.interpolate import make_lsq_spline

    knots = clamped_knots(controls, 3)

    def run() -> object:
        along = make_lsq_spline(at, values, knots, 3).c
        return make_lsq_spline(at, along.T, knots, 3).c.T

    return run


def scattered(at: np.ndarray, values: np.ndarray, controls: int) -> Callable[[], object]:
    """FITPACK's fit for points anywhere."""
    from scipy.interpolate import LSQBivariateSpline

    inner = clamped_knots(controls, 3)[4:-4]
    u, v = (a.ravel() for a in np.meshgrid(at, at, indexing="ij"))
    return lambda: LSQBivariateSpline(u, v, values.ravel(), inner, inner, kx=3, ky=3)


def by_geomdl(at: np.ndarray, values: np.ndarray, controls: int) -> Callable[[], object]:
    """Global approximation after The NURBS Book."""
    from geomdl import fitting

    x, y = np.meshgrid(at, at, indexing="ij")
    points = np.stack([x, y, values], axis=2).reshape(-1, 3).tolist()
    n = len(at)
    return lambda: fitting.approximate_surface(points, n, n, 3, 3, ctrlpts_size_u=controls, ctrlpts_size_v=controls)


def by_occt(at: np.ndarray, values: np.ndarray) -> Callable[[], object]:
    """GeomAPI_PointsToBSplineSurface: it cannot be told a number of control points, only a tolerance."""
    from OCP.GeomAbs import GeomAbs_Shape
    from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface

    occ, n = kernel(), len(at)
    points = occ.Points(1, n, 1, n)
    for i in range(n):
        for j in range(n):
            points.SetValue(i + 1, j + 1, occ.Pnt(float(at[i]), float(at[j]), float(values[i, j])))
    return lambda: GeomAPI_PointsToBSplineSurface(points, 3, 3, GeomAbs_Shape.GeomAbs_C2, 1e-3).Surface()


if __name__ == "__main__":
    main()
