"""The nominal surface: a B-spline patch, rational or not, with an outward normal.

Parameters (u, v) run over the knots' own interval. Curvature is positive where the surface is convex seen from
outside the material: a ball of radius R has 1/R everywhere.
"""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from trueloop._core import NurbsPatch, fit_surface_grid
from trueloop.arrays import Array, Integers, for_kernel
from trueloop.errors import Code


@dataclass(frozen=True, eq=False)
class BasisRows:
    """At each of n places: index of the first function that differs from zero (n,), and values and first and second
    derivatives of the degree + 1 functions from there on, each (n, degree + 1).
    """

    first: np.ndarray
    values: Array
    slopes: Array
    bends: Array


def basis_rows(knots: Array, degree: int, at: Array) -> BasisRows:
    """Basis functions on a clamped knot vector by the recursion of Cox and de Boor.

    Places outside the knots are those of the nearest end piece continued. Derivatives are differences of the functions
    a degree lower: B′ = p (B₍ᵢ,ₚ₋₁₎/(tᵢ₊ₚ − tᵢ) − B₍ᵢ₊₁,ₚ₋₁₎/(tᵢ₊ₚ₊₁ − tᵢ₊₁)).
    """
    count = len(knots) - degree - 1
    span = np.clip(np.searchsorted(knots, at, side="right") - 1, degree, count - 1)
    while np.any(empty := (knots[span + 1] <= knots[span]) & (span > degree)):
        span = np.where(empty, span - 1, span)
    levels = [np.ones((len(at), 1))]
    for level in range(1, degree + 1):
        levels.append(_raised(levels[-1], knots, span, level, at))
    none = np.zeros((len(at), degree + 1))
    slopes = _derived(levels[degree - 1], knots, span, degree) if degree >= 1 else none
    lower = _derived(levels[degree - 2], knots, span, degree - 1) if degree >= 2 else None
    bends = none if lower is None else _derived(lower, knots, span, degree)
    return BasisRows(span - degree, levels[degree], slopes, bends)


def basis_matrix(knots: Array, degree: int, at: Array) -> Array:
    """Returns the values as a matrix (n, functions)."""
    rows = basis_rows(knots, degree, at)
    matrix = np.zeros((len(at), len(knots) - degree - 1))
    np.put_along_axis(matrix, rows.first[:, None] + np.arange(degree + 1), rows.values, axis=1)
    return matrix


def clamped_knots(count: int, degree: int) -> Array:
    """Knots on [0, 1], evenly spaced within, for so many functions."""
    inner = np.linspace(0.0, 1.0, count - degree + 1)[1:-1]
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def _raised(lower: Array, knots: Array, span: np.ndarray, level: int, at: Array) -> Array:
    """Functions of degree `level` on a piece from those of the degree below."""
    raised = np.zeros((len(at), level + 1))
    for k in range(level):
        left, right = knots[span - level + 1 + k], knots[span + 1 + k]
        share = lower[:, k] / (right - left)
        raised[:, k] += (right - at) * share
        raised[:, k + 1] += (at - left) * share
    return raised


def _derived(lower: Array, knots: Array, span: np.ndarray, degree: int) -> Array:
    """Derivatives of the functions of `degree` from the functions, or their derivatives, of the degree below."""
    derived = np.zeros((len(span), degree + 1))
    for k in range(degree):
        share = degree * lower[:, k] / (knots[span + 1 + k] - knots[span - degree + 1 + k])
        derived[:, k] -= share
        derived[:, k + 1] += share
    return derived


MOST_DEGREE = 25
"""As in the CAD kernel."""
BESIDE = 1e-6
"""Share of the way to the middle of the patch by which a pole's normal is taken beside it."""
CHUNK = 4096
"""Places evaluated at once: their control points stay in the cache."""


@dataclass(frozen=True, eq=False)
class Partials:
    """A surface at n places (u, v): point (n, 3) and partial derivatives, mm per unit of parameter."""

    u: Array
    v: Array
    point_mm: Array
    du: Array
    dv: Array
    duu: Array
    duv: Array
    dvv: Array


@dataclass(frozen=True, eq=False)
class Surface:
    """A patch. `degrees` (p, q); clamped `knots_u`, `knots_v`; `control_mm` (n, m, 3); `weights` (n, m) or None.

    The outward normal is ∂u × ∂v, or its opposite where `flipped`.
    """

    degrees: tuple[int, int]
    knots_u: Array
    knots_v: Array
    control_mm: Array
    weights: Array | None = None
    flipped: bool = False

    def __post_init__(self) -> None:
        _check(self)

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Returns the interval of u and the interval of v."""
        (p, q), (ku, kv) = self.degrees, (self.knots_u, self.knots_v)
        return (float(ku[p]), float(ku[-p - 1])), (float(kv[q]), float(kv[-q - 1]))

    def point_mm(self, u: Array, v: Array) -> Array:
        """Points (n, 3)."""
        u, v = _paired(u, v)
        return np.concatenate([self._points(u[k : k + CHUNK], v[k : k + CHUNK]) for k in _starts(u)])

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Points at every u with every v: (len(u), len(v), 3)."""
        along = basis_matrix(self.knots_u, self.degrees[0], np.asarray(u, float))
        across = basis_matrix(self.knots_v, self.degrees[1], np.asarray(v, float))
        lifted = np.einsum("ai,ijk,bj->abk", along, self._lifted, across, optimize=True)
        return np.asarray(lifted if self.weights is None else lifted[..., :3] / lifted[..., 3:])

    def partials(self, u: Array, v: Array) -> Partials:
        """Points with first and second derivatives."""
        u, v = _paired(u, v)
        parts = [self._partials(u[k : k + CHUNK], v[k : k + CHUNK]) for k in _starts(u)]
        return Partials(u, v, *(np.concatenate(columns) for columns in zip(*parts, strict=True)))

    def normal(self, u: Array, v: Array) -> Array:
        """Returns the outward unit normals (n, 3), at a pole or a collapsed edge that of a place a hair beside it.

        Raises SRF-DEGENERATE where there is none either.
        """
        return self.normal_of(self.partials(u, v))

    def normal_of(self, at: Partials) -> Array:
        """Returns the outward unit normals of places already evaluated."""
        return self.outward((at.u, at.v), at.du, at.dv)

    def outward(self, at: tuple[Array, Array], du: Array, dv: Array, beside: float = BESIDE) -> Array:
        """Returns the outward unit normals (n, 3) from parameters and derivatives (n, 3) there; raises as `normal`."""
        across = np.cross(du, dv)
        length = np.linalg.norm(across, axis=1)
        if np.any(bad := ~(length > 1e-12 * self._size)):
            if beside:
                inner = [
                    value[bad] + beside * ((low + high) / 2 - value[bad])
                    for value, (low, high) in zip(at, self.domain, strict=True)
                ]
                near_by, found = self.partials(*inner), np.empty_like(across)
                found[~bad] = self.outward((at[0][~bad], at[1][~bad]), du[~bad], dv[~bad], 0.0)
                found[bad] = self.outward((near_by.u, near_by.v), near_by.du, near_by.dv, 0.0)
                return found
            x, y, z = self.point_mm(at[0][bad][:1], at[1][bad][:1])[0]
            raise Code.SRF_DEGENERATE.refusal(
                f"the surface has no normal at x {x:.4f} mm, y {y:.4f} mm, z {z:.4f} mm",
                hint="a collapsed part of the patch: leave it out, or fit the surface to a point grid anew",
                values={"x_mm": float(x), "y_mm": float(y), "z_mm": float(z)},
            )
        return np.asarray((-1.0 if self.flipped else 1.0) * across / length[:, None])

    def curvatures_per_mm(self, u: Array, v: Array) -> Array:
        """Returns the principal curvatures (n, 2), the smaller first: negative is concave seen from outside."""
        at = self.partials(u, v)
        normal = self.normal_of(at)
        e, f, g = (np.sum(a * b, axis=1) for a, b in ((at.du, at.du), (at.du, at.dv), (at.dv, at.dv)))
        low, mid, high = (-np.sum(normal * d, axis=1) for d in (at.duu, at.duv, at.dvv))
        area = e * g - f * f
        mean = (e * high - 2 * f * mid + g * low) / (2 * area)
        gauss = (low * high - mid * mid) / area
        spread = np.sqrt(np.maximum(mean * mean - gauss, 0.0))
        return np.stack([mean - spread, mean + spread], axis=1)

    def turned_over(self) -> "Surface":
        """Returns this patch with its normals reversed."""
        return replace(self, flipped=not self.flipped)

    def exchanged(self) -> "Surface":
        """Returns this patch, normals included, with u and v exchanged: one of the two forms has ∂u × ∂v outward."""
        weights = None if self.weights is None else self.weights.T
        control = self.control_mm.swapaxes(0, 1)
        return Surface(
            degrees=self.degrees[::-1],
            knots_u=self.knots_v,
            knots_v=self.knots_u,
            control_mm=control,
            weights=weights,
            flipped=not self.flipped,
        )

    @cached_property
    def _size(self) -> float:
        """The product of derivatives along u and v of a square patch as wide as this."""
        (u0, u1), (v0, v1) = self.domain
        return float(np.sum(np.ptp(self.control_mm.reshape(-1, 3), axis=0) ** 2)) / ((u1 - u0) * (v1 - v0))

    @cached_property
    def _lifted(self) -> Array:
        """Homogeneous control points (n, m, 4); plain ones (n, m, 3) where there are no weights."""
        if self.weights is None:
            return self.control_mm
        w = self.weights[..., None]
        return np.concatenate([self.control_mm * w, w], axis=2)

    @property
    def _width(self) -> int:
        """Numbers of a control point, named where there may be no places at all to count from."""
        return 3 if self.weights is None else 4

    def _near(self, a: BasisRows, b: BasisRows) -> Array:
        """Returns the control points that act on each place, (n, q + 1, (p + 1) × 3 or 4)."""
        rows = a.first[:, None] + np.arange(self.degrees[0] + 1)
        columns = b.first[:, None] + np.arange(self.degrees[1] + 1)
        near = self._lifted[rows[:, None, :], columns[:, :, None]]
        return near.reshape(len(rows), self.degrees[1] + 1, (self.degrees[0] + 1) * self._width)

    def _bases(self, u: Array, v: Array) -> tuple[BasisRows, BasisRows]:
        return basis_rows(self.knots_u, self.degrees[0], u), basis_rows(self.knots_v, self.degrees[1], v)

    def _points(self, u: Array, v: Array) -> Array:
        a, b = self._bases(u, v)
        across = (b.values[:, None, :] @ self._near(a, b)).reshape(len(u), self.degrees[0] + 1, self._width)
        lifted = (a.values[:, None, :] @ across)[:, 0]
        return np.asarray(lifted if self.weights is None else lifted[:, :3] / lifted[:, 3:])

    def _partials(self, u: Array, v: Array) -> tuple[Array, ...]:
        a, b = self._bases(u, v)
        across = np.stack([b.values, b.slopes, b.bends], axis=1) @ self._near(a, b)
        across = (
            across.reshape(len(u), 3, self.degrees[0] + 1, self._width)
            .transpose(0, 2, 1, 3)
            .reshape(len(u), self.degrees[0] + 1, 3 * self._width)
        )
        along = (np.stack([a.values, a.slopes, a.bends], axis=1) @ across).reshape(len(u), 3, 3, self._width)
        parts = along[:, 0, 0], along[:, 1, 0], along[:, 0, 1], along[:, 2, 0], along[:, 1, 1], along[:, 0, 2]
        return parts if self.weights is None else _projected(*parts)


def _paired(u: Array, v: Array) -> tuple[Array, Array]:
    u, v = np.broadcast_arrays(np.atleast_1d(np.asarray(u, float)), np.atleast_1d(np.asarray(v, float)))
    return u, v


def _starts(u: Array) -> range:
    return range(0, max(len(u), 1), CHUNK)


def _projected(h: Array, hu: Array, hv: Array, huu: Array, huv: Array, hvv: Array) -> tuple[Array, ...]:
    """Derivatives of the quotient (x, y, z)/w from those of its parts, each (n, 4)."""
    w = h[:, 3:]
    point = h[:, :3] / w
    du = (hu[:, :3] - hu[:, 3:] * point) / w
    dv = (hv[:, :3] - hv[:, 3:] * point) / w
    duu = (huu[:, :3] - 2 * hu[:, 3:] * du - huu[:, 3:] * point) / w
    duv = (huv[:, :3] - hu[:, 3:] * dv - hv[:, 3:] * du - huv[:, 3:] * point) / w
    dvv = (hvv[:, :3] - 2 * hv[:, 3:] * dv - hvv[:, 3:] * point) / w
    return point, du, dv, duu, duv, dvv


def _check(surface: Surface) -> None:
    """Refuses what is not a patch."""
    n, m, _ = surface.control_mm.shape
    wrong = ""
    for name, knots, degree, count in (
        ("u", surface.knots_u, surface.degrees[0], n),
        ("v", surface.knots_v, surface.degrees[1], m),
    ):
        if not 1 <= degree <= MOST_DEGREE:
            wrong = f"a degree of {degree} along {name}; 1 to {MOST_DEGREE} are possible"
        elif len(knots) != count + degree + 1:
            wrong = f"{count} control points of degree {degree} along {name} do not fit {len(knots)} knots"
        elif not np.all(np.isfinite(knots)) or np.any(np.diff(knots) < 0) or knots[degree] >= knots[count]:
            wrong = f"the {len(knots)} knots along {name} do not ascend"
    if not np.all(np.isfinite(surface.control_mm)):
        wrong = "a control point is no finite number: 'nan' or 'inf'"
    if surface.weights is not None and not np.all(surface.weights > 0):
        wrong = f"a weight of {np.min(surface.weights)} is not positive"
    if wrong:
        raise Code.SRF_SURFACE.refusal(wrong, hint="export the surface again as a B-spline surface")


@dataclass(frozen=True, eq=False)
class Feet:
    """Closest points: parameters (n,), points and outward normals (n, 3), signed distance along the normal (n,), and
    how far the point lies beyond the patch's edge, sideways (n,); 0 over the patch.
    """

    u: Array
    v: Array
    point_mm: Array
    normal: Array
    distance_mm: Array
    beyond_mm: Array


def closest(surface: Surface, points_mm: Array, near: tuple[Array, Array] | None = None) -> Feet:
    """Returns the feet of points (n, 3), finite numbers: the nearest points of the whole patch.

    `near`: parameters to start from instead, where they are known: the foot is then the one downhill from there. Raises
    SRF-DEGENERATE where a foot has no normal.
    """
    points = np.atleast_2d(points_mm)
    start = None if near is None else np.stack(near, axis=1).astype(float)
    at, foot, du, dv = _patch(surface).feet(for_kernel(points), start)
    normal = surface.outward((at[:, 0], at[:, 1]), du, dv)
    off = points - foot
    along = np.einsum("nk,nk->n", off, normal)
    sideways = np.linalg.norm(off - along[:, None] * normal, axis=1)
    low, high = np.array(surface.domain).T
    on_edge = np.any((at <= low) | (at >= high), axis=1)
    return Feet(
        u=at[:, 0],
        v=at[:, 1],
        point_mm=foot,
        normal=normal,
        distance_mm=along,
        beyond_mm=np.where(on_edge, sideways, 0.0),
    )


def near(surface: Surface, points_mm: Array, reach_mm: float) -> Integers:
    """Returns the indices of points (n, 3) that may be within `reach_mm` of a patch, by its box."""
    control = surface.control_mm.reshape(-1, 3)
    low, high = control.min(axis=0) - reach_mm, control.max(axis=0) + reach_mm
    return np.flatnonzero(np.all((points_mm >= low) & (points_mm <= high), axis=1))


def closest_parameters(surface: Surface, points_mm: Array) -> Array:
    """Parameters (n, 2) of the nearest points of the whole patch: they exist at a pole too, which has no normal."""
    return np.asarray(_patch(surface).feet(for_kernel(np.atleast_2d(points_mm)), None)[0])


@lru_cache(maxsize=16)
def _patch(surface: Surface) -> NurbsPatch:
    """The surface as the search has it: made once, a surface is asked many times."""
    weights = np.ones(surface.control_mm.shape[:2]) if surface.weights is None else surface.weights
    lifted = np.concatenate([surface.control_mm * weights[..., None], weights[..., None]], axis=2)
    knots = (for_kernel(surface.knots_u), for_kernel(surface.knots_v))
    return NurbsPatch(surface.degrees, knots, for_kernel(lifted))


@dataclass(frozen=True, eq=False)
class GridFit:
    """A surface on [0, 1]², the parameters of the grid's rows and columns, and the largest distance of a grid point."""

    surface: Surface
    u: Array
    v: Array
    worst_mm: float


def fit_grid(points_mm: Array, controls: tuple[int, int] | None = None, degree: int = 3) -> GridFit:
    """The least-squares surface for a grid of points (n, m, 3), by parameters from averaged chord lengths.

    Without a number of control points it goes through every point. Raises SRF-GRID for a grid too small, with holes
    (nan) or with coincident neighbours.
    """
    points = np.asarray(points_mm, float)
    _check_grid(points, degree)
    u, v = chord_parameters(points), chord_parameters(points.swapaxes(0, 1))
    count = points.shape[:2] if controls is None else controls
    surface = fit_parameterised(points, (u, v), (_knots(u, count[0], degree), _knots(v, count[1], degree)), degree)
    off = np.linalg.norm(surface.grid_mm(u, v) - points, axis=2)
    return GridFit(surface, u, v, float(np.max(off)))


def fit_parameterised(points_mm: Array, at: tuple[Array, Array], knots: tuple[Array, Array], degree: int) -> Surface:
    """The least-squares surface when the parameters of rows and columns, in [0, 1], and the knots are known."""
    inner = tuple(for_kernel(k[degree + 1 : -degree - 1]) for k in knots)
    try:
        columns = [
            fit_surface_grid((inner[0], inner[1]), (degree, degree), at, for_kernel(points_mm[..., k]))
            for k in range(3)
        ]
    except ValueError as refused:
        raise Code.SRF_GRID.refusal(
            f"a grid of {points_mm.shape[0]} × {points_mm.shape[1]} points cannot be fitted: {refused}",
            hint="ask for fewer control points, or give a denser grid",
        ) from None
    return Surface((degree, degree), knots[0], knots[1], np.stack(columns, axis=2))


def chord_parameters(points_mm: Array) -> Array:
    """Parameters in [0, 1] of the rows of a grid: chord lengths between rows, averaged over columns."""
    steps = np.linalg.norm(np.diff(points_mm, axis=0), axis=2)
    along = np.cumsum(steps, axis=0) / np.sum(steps, axis=0)
    return np.concatenate([[0.0], np.mean(along, axis=1)])


def _knots(at: Array, count: int, degree: int) -> Array:
    """Clamped knots that follow the density of the parameters, so that every control point has its share of them."""
    if not degree < count <= len(at):
        raise Code.SRF_GRID.refusal(
            f"{count} control points of degree {degree} for {len(at)} rows: {degree + 1} to {len(at)} are possible",
            hint="ask for fewer control points, or give a denser grid",
        )
    if count == len(at):  # averages of parameters, which make interpolation well posed
        inner = np.array([np.mean(at[k + 1 : k + 1 + degree]) for k in range(count - degree - 1)])
    else:
        even = clamped_knots(count, degree)[degree + 1 : -degree - 1]
        inner = np.interp(even, np.linspace(0.0, 1.0, len(at)), at)
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def _check_grid(points: Array, degree: int) -> None:
    hint = "give a complete grid, row by row, of at least four by four points"
    if points.ndim != 3 or points.shape[2] != 3 or min(points.shape[:2]) <= degree:
        raise Code.SRF_GRID.refusal(f"a grid of {points.shape} values is too small for degree {degree}", hint=hint)
    if np.any(bad := ~np.all(np.isfinite(points), axis=2)):
        row, column = np.argwhere(bad)[0]
        raise Code.SRF_GRID.refusal(
            f"the grid has {np.count_nonzero(bad)} holes, the first in row {row + 1}, column {column + 1}", hint=hint
        )
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(points, axis=axis), axis=2)
        if np.any(same := steps <= 0):
            row, column = np.argwhere(same)[0]
            raise Code.SRF_GRID.refusal(
                f"grid point in row {row + 1}, column {column + 1} coincides with the next one", hint=hint
            )
