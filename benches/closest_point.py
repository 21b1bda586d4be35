"""The closest point of a B-spline surface, beside Open CASCADE's projection and scipy's minimizer; then many, alone."""

from collections.abc import Callable

import numpy as np

from benches.ratio import Contender, compare, compare_once, verdict
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import to_kernel
from trueloop.geometry.surface import Surface, closest, fit_grid

COUNTS, SCIPY_SOON, OCCT_SOON = (100, 10_000, 1_000_000), 100, 10_000
"""Of more points a call of the others takes many seconds: they are timed once."""


def main() -> None:
    """Points up to 2 mm off a gentle surface of 21 × 21 control points."""
    x, y = np.meshgrid(np.linspace(0, 50, 21), np.linspace(0, 50, 21), indexing="ij")
    surface = fit_grid(np.stack([x, y, 4 * np.sin(x / 14) * np.cos(y / 17)], axis=2)).surface
    for count in COUNTS:
        rng = np.random.default_rng(count)
        u, v = rng.uniform(0.02, 0.98, (2, count))
        lift = rng.uniform(-2, 2, (count, 1))
        points = surface.point_mm(u, v) + lift * surface.normal(u, v)
        off = np.max(np.abs(closest(surface, points).distance_mm - lift[:, 0]))
        own = Contender("trueloop", ours(surface, points), f"{off:.1g} mm")
        occt = Contender("Open CASCADE", by_occt(surface, points))
        scipy = Contender("scipy.optimize.minimize", by_scipy(surface, points))
        soon = [occt] * (count <= OCCT_SOON) + [scipy] * (count <= SCIPY_SOON)
        samples = compare(f"{count} points", [own, *soon], rounds=3, note_heading="largest error")
        if once := [slow for slow in (occt, scipy) if slow not in soon]:
            compare_once(samples, "trueloop", once)
        if count == OCCT_SOON:
            verdict(samples, "trueloop", to="Open CASCADE", at_most=1 / 10)


def ours(surface: Surface, points: np.ndarray) -> Callable[[], object]:
    """All points at once."""
    return lambda: closest(surface, points)


def by_occt(surface: Surface, points: np.ndarray) -> Callable[[], object]:
    """GeomAPI_ProjectPointOnSurf, made once and given point after point."""
    occ = kernel()
    handle = to_kernel(occ, surface)
    places = [occ.Pnt(*point) for point in points.tolist()]
    projection = occ.Projection(places[0], handle)

    def run() -> object:
        distance = 0.0
        for place in places:
            projection.Perform(place)
            distance += projection.LowerDistance()
        return distance

    return run


def by_scipy(surface: Surface, points: np.ndarray) -> Callable[[], object]:
    """One point after the other, from the nearest of a grid of samples, with the gradient given."""
    from scipy.optimize import minimize

    at = np.linspace(0, 1, 51)
    samples = surface.grid_mm(at, at)

    def run() -> object:
        return [one(point) for point in points]

    def one(point: np.ndarray) -> float:
        start = np.unravel_index(int(np.argmin(np.sum((samples - point) ** 2, axis=2))), (51, 51))

        def distance(w: np.ndarray) -> tuple[float, np.ndarray]:
            here = surface.partials(w[:1], w[1:])
            off = here.point_mm[0] - point
            return float(off @ off), 2 * np.array([off @ here.du[0], off @ here.dv[0]])

        return float(minimize(distance, at[list(start)], jac=True, bounds=[(0, 1), (0, 1)], tol=1e-12).fun)

    return run


if __name__ == "__main__":
    main()
