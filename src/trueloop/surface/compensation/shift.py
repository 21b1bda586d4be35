"""The corrected surface: the nominal one moved along its normals by −w times the pattern.

M(u, v) = N(u, v) − w · MPM(u, v) · n(u, v) [MPM Eq. 5], fitted again as a B-spline surface on the nominal's parameters.

The machining pattern as a surface: the nominal one moved along its normals by what parts have alike, magnified.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Final, Protocol

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.domain.option import Limits, Option, allowed_by
from trueloop.errors import Code
from trueloop.geometry.surface import Surface, closest, fit_parameterised, near
from trueloop.nc.program.along import lengths_mm, points_along
from trueloop.nc.program.tool_path import ToolPath
from trueloop.surface.compensation.cutter import Contacts, Cutter, ToolAxes, contacts
from trueloop.surface.on_face import LIMITS, WHOLE, OnFace, Trim
from trueloop.surface.options import SurfaceOptions
from trueloop.surface.separation.spline_surface import SplineSurface
from trueloop.units import UM_PER_MM

CUTS_MM: Final = 0.05
"""A cutter farther than this off the nominal surface does not finish it: it leads in, leads out, or passes by."""
ROUNDS: Final = 12
SAME_MM: Final = 1e-8


@dataclass(frozen=True, eq=False)
class MovedLocations:
    """Cutter locations (n, 3) after correction, and which of them cut the surface at all; the others stay."""

    tips_mm: Array
    cutting: np.ndarray
    gap_mm: Array


def moved_locations(
    nominal: Surface, corrected: Surface, cutter: Cutter, tips_mm: Array, axes: Array, *, cuts_mm: float = CUTS_MM
) -> MovedLocations:
    """Every location whose gap to the nominal surface is at most `cuts_mm`, moved along the nominal normal until its
    gap to the corrected surface is the same.

    The gap is kept, not made zero: what a roughing allowance, a chord or the programmer's rounding left stays left.
    """
    before = contacts(nominal, cutter, tips_mm, axes)
    cutting = is_cutting(before, cuts_mm)
    moved = tips_mm.copy()
    if np.any(cutting):
        moved[cutting] = _moved(before, corrected, cutter, tips_mm, axes, cutting)
    return MovedLocations(moved, cutting, before.gap_mm)


def is_cutting(contacts: Contacts, cuts_mm: float = CUTS_MM) -> np.ndarray:
    """At which places (n,) the cutter finishes the surface."""
    return np.asarray((np.abs(contacts.gap_mm) <= cuts_mm) & (contacts.feet.beyond_mm <= cuts_mm))


def _moved(
    before: Contacts, corrected: Surface, cutter: Cutter, tips: Array, axes: Array, cutting: np.ndarray
) -> Array:
    (u0, u1), (v0, v1) = corrected.domain
    normal, wanted = before.feet.normal[cutting], before.gap_mm[cutting]
    tips, axes = tips[cutting], axes[cutting]
    start = closest(corrected, before.feet.point_mm[cutting])
    feet = (np.clip(start.u, u0, u1), np.clip(start.v, v0, v1))
    along = np.zeros(len(tips))
    for _ in range(ROUNDS):
        now = contacts(corrected, cutter, tips + along[:, None] * normal, axes, feet)
        step = wanted - now.gap_mm
        along += step
        feet = (now.feet.u, now.feet.v)
        if np.max(np.abs(step)) < SAME_MM:
            break
    return np.asarray(tips + along[:, None] * normal)


TOGETHER_MM: Final = 2e-3
"""Faces as near to the cutter as the nearest one, to so much, are cut with it: on both sides of a corner, and all along
a fillet of the cutter's own radius.
"""
FILLED: Final = 0.1
"""A hollow's radius less the cutter's, over the hollow's: below, all the hollow is as near as its nearest place,
which jumps, and a face is moved by what it is at the place touched.
"""
ALIKE: Final = 0.03
"""Two normals within about 20° of each other are one direction, along which displacements are averaged: across it, two
that differ a little would be taken for a large one.
"""


@dataclass(frozen=True, eq=False)
class MovedFace:
    """A nominal surface and the corrected one; `trim` says which of its places are cut away, where a program cuts
    several faces, of which each ends where the next begins; `number` is the face's in its model.
    """

    nominal: Surface
    corrected: Surface
    trim: Trim | None = None
    number: int | None = None

    def shift_mm(self, u: Array, v: Array) -> Array:
        """Returns how far the face is moved along its nominal normal at parameters (n,) of the nominal."""
        (u0, u1), (v0, v1) = self.nominal.domain
        (a0, a1), (b0, b1) = self.corrected.domain
        at = self.nominal.partials(u, v)
        share_u, share_v = (u - u0) / (u1 - u0), (v - v0) / (v1 - v0)
        moved = self.corrected.point_mm(a0 + (a1 - a0) * share_u, b0 + (b1 - b0) * share_v) - at.point_mm
        return np.asarray(np.sum(moved * self.nominal.normal_of(at), axis=1))


def moved_over_faces(
    faces: Sequence[MovedFace], cutter: Cutter, tips_mm: Array, axes: Array, *, cuts_mm: float = CUTS_MM
) -> tuple[MovedLocations, Integers]:
    """Returns cutter locations moved by the faces that they cut, and the number from 0 of the nearest one, (n,).

    Where the cutter touches one face it is moved along that normal; where it touches several at once, by the smallest
    displacement m that has the amount of each along its normal, n_k · m = s_k, by least squares. In a fillet of its own
    radius these are the faces at both ends of it and the fillet between.
    """
    if len(faces) == 1 and faces[0].trim is None:
        (face,) = faces
        moved = moved_locations(face.nominal, face.corrected, cutter, tips_mm, axes, cuts_mm=cuts_mm)
        return moved, np.zeros(len(tips_mm), int)
    gap_mm = np.full((len(faces), len(tips_mm)), np.inf)
    normal, along_mm = np.zeros((len(faces), len(tips_mm), 3)), np.zeros((len(faces), len(tips_mm)))
    for k, face in enumerate(faces):
        some = near(face.nominal, tips_mm, 2 * cutter.radius_mm + cuts_mm)
        if not len(some):
            continue
        touch = contacts(face.nominal, cutter, tips_mm[some], axes[some])
        cutting = is_cutting(touch, cuts_mm)
        if face.trim is not None and np.any(cutting):
            cutting[cutting] = ~face.trim(touch.feet.u[cutting], touch.feet.v[cutting]).astype(np.bool_)
        if not np.any(cutting):
            continue
        here = some[cutting]
        moved_mm = _moved(touch, face.corrected, cutter, tips_mm[some], axes[some], cutting) - tips_mm[here]
        gap_mm[k, here], normal[k, here] = touch.gap_mm[cutting], touch.feet.normal[cutting]
        along_mm[k, here] = np.sum(moved_mm * normal[k, here], axis=1)
        u, v = touch.feet.u[cutting], touch.feet.v[cutting]
        filled = np.flatnonzero(1 + cutter.corner_mm * face.nominal.curvatures_per_mm(u, v)[:, 0] < FILLED)
        along_mm[k, here[filled]] = face.shift_mm(u[filled], v[filled])
    nearest = np.argmin(gap_mm, axis=0)
    least_mm = gap_mm[nearest, np.arange(len(tips_mm))]
    together = (gap_mm <= least_mm + TOGETHER_MM) & np.isfinite(gap_mm)
    products = np.einsum("kn,kni,knj->nij", together, normal, normal)
    size, turn = np.linalg.eigh(products)
    share = np.divide(1.0, size, out=np.zeros_like(size), where=size > ALIKE * np.maximum(size[:, -1:], 1e-300))
    wanted = np.einsum("kn,kn,kni->ni", together, along_mm, normal)
    moved_by = np.einsum("nij,nj,nkj,nk->ni", turn, share, turn, wanted)
    return MovedLocations(tips_mm + moved_by, np.isfinite(least_mm), least_mm), nearest


UP: Final = (0.0, 0.0, 1.0)
TURN_DEG: Final = 1.0
"""The tool turns no more than this between two places that are looked at."""


@dataclass(frozen=True)
class SurfaceJob:
    """How a program is to be corrected: its cutter, the tool axis out of the material, or the letters of the words that
    turn it (`tool_axis`), the chord tolerance, the distance between the places looked at along a move, what may be
    cut too deep, values of the program's parameters, and whether words that the dialect does not know are left alone.
    `zero_mm`: where the zero of the `work_offsets`, or of the only one in which the program cuts, lies on the surface.
    `tool`: the T number whose moves are corrected; None where one tool cuts. `further`: the same for other tools of the
    program, each with its own cutter and axis.
    """

    cutter: Cutter
    axis: tuple[float, float, float] = UP
    tolerance_mm: Annotated[
        float,
        Option(
            "compensation.chord_um",
            "How far a block may deviate from the corrected path before blocks are put in.",
            above=0,
        ),
    ] = 5e-4
    sample_mm: float = 0.5
    gouge_mm: Annotated[
        float, Option("compensation.gouge_um", "How deep the cutter may go into the corrected surface.", above=0)
    ] = 5e-3
    cuts_mm: float = CUTS_MM
    rotary: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)
    accept_unknown_words: bool = False
    zero_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    work_offsets: tuple[str, ...] = ()
    tool: int | None = None
    further: tuple["SurfaceJob", ...] = ()

    @property
    def by_tool(self) -> tuple["SurfaceJob", ...]:
        """Returns the jobs of all tools."""
        return (self, *self.further)


@dataclass(frozen=True, eq=False)
class Samples:
    """Places along the moves at feed: move and share of it (n,), and tips before and after (n, 3); and the tool's axes
    along all moves. `face`: the number from 0 of the face nearest to each place.
    """

    move: np.ndarray
    share: Array
    before_mm: Array
    after_mm: Array
    cutting: np.ndarray
    axes: ToolAxes
    face: Integers

    @property
    def cutting_moves(self) -> np.ndarray:
        """Indices of the moves that cut."""
        return np.unique(self.move[self.cutting])

    def moves_on(self, face: int) -> np.ndarray:
        """Indices of the moves that cut a face."""
        return np.unique(self.move[self.cutting & (self.face == face)])

    def joined(self, others: Sequence["Samples"]) -> "Samples":
        """Returns these places with those of other moves, in the order of the moves."""
        every = (self, *others)
        order = np.argsort(np.concatenate([one.move for one in every]), kind="stable")
        move, share, before_mm, after_mm, cutting, face = (
            np.concatenate([getattr(one, name) for one in every])[order]
            for name in ("move", "share", "before_mm", "after_mm", "cutting", "face")
        )
        return Samples(move, share, before_mm=before_mm, after_mm=after_mm, cutting=cutting, axes=self.axes, face=face)


def places(
    path: ToolPath, axes: ToolAxes, moves: Integers, sample_mm: float, turn_deg: float = TURN_DEG
) -> tuple[Integers, Array]:
    """Places along moves, their ends included, no further apart than `sample_mm` and `turn_deg`: move and share."""
    pieces = np.ceil(np.maximum(lengths_mm(path, moves) / sample_mm, axes.turned_deg(moves) / turn_deg))
    pieces = np.maximum(1, pieces).astype(int)
    share = [np.linspace(0.0, 1.0, n + 1) for n in pieces]
    return np.repeat(moves, pieces + 1), np.concatenate(share) if share else np.empty(0)


def sampled(path: ToolPath, moves: Integers, turning: ToolAxes, faces: Sequence[MovedFace], job: SurfaceJob) -> Samples:
    """Places along some moves of a path in the coordinates of the faces, and where the correction takes them."""
    move, share = places(path, turning, moves, job.sample_mm)
    tips, axes = points_along(path, move, share), turning.directions(move, share)
    moved, face = moved_over_faces(faces, job.cutter, tips, axes, cuts_mm=job.cuts_mm)
    return Samples(
        move=move, share=share, before_mm=tips, after_mm=moved.tips_mm, cutting=moved.cutting, axes=turning, face=face
    )


COLLAPSED_MM: Final = 0.01
"""Distance below which places of the grid of limits count once: at a pole there is no slope around it."""
DEGREE: Final = 3
CHECKS: Final = 3
"""Places between two samples of the fit where the fitted surface is compared with the exact one."""
FEWEST: Final = 8
MOST: Final = 150
"""Pieces a direction that the refit begins and ends with, more where the nominal has more."""
MANY: Final = 50
HOPELESS: Final = 0.7
"""Half as many pieces again take a smooth surface to a fifth of the distance: where many gain less, none will do."""


class Deviation(Protocol):
    """A deviation in mm over parameters in [0, 1]: a pattern, a part's model, or raw errors interpolated."""

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""


@dataclass(frozen=True, eq=False)
class Displacement:
    """Terms in mm that are taken off along the normal together: a pattern, and corrections that were in force."""

    terms: tuple[SplineSurface, ...]

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""
        return np.asarray(sum(term.grid_mm(u, v) for term in self.terms))

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""
        return np.asarray(sum(term.value_mm(u, v) for term in self.terms))

    def largest_mm(self, there: OnFace) -> float:
        """Returns the largest amount on the face that is there."""
        values = np.abs(self.grid_mm(*_samples(LIMITS)))
        return float(np.max(values[there.square(LIMITS)], initial=0.0))


@dataclass(frozen=True, eq=False)
class CorrectedSurface:
    """The corrected surface on [0, 1] × [0, 1], and how far the refit deviates from the exact M(u, v) at most."""

    surface: Surface
    worst_mm: float
    largest_shift_mm: float


def corrected_surface(
    nominal: Surface,
    deviation: Deviation,
    *,
    weight: float = 1.0,
    tolerance_mm: float = SurfaceOptions.tolerance_mm,
    limits: Limits | None = None,
    there: OnFace = WHOLE,
) -> CorrectedSurface:
    """The surface to be machined instead of the nominal one.

    Pieces are added until a check three times as dense as the samples finds the refit within tolerance; knots of the
    nominal stay knots. Limits are judged on the face that is there alone. Raises CMP-SIZE or CMP-SLOPE where the
    correction exceeds the limits, SRF-TOLERANCE where more pieces do not help.
    """
    check_surface_limits(nominal, deviation, weight, limits or Limits(), there)
    pieces, before = FEWEST, np.inf
    while True:
        lines = [_lines(*direction, pieces) for direction in zip(_knots(nominal), nominal.degrees, strict=True)]
        surface = _fitted(nominal, deviation, weight, lines)
        worst = _off(nominal, deviation, weight, surface, lines)
        if worst <= tolerance_mm:
            inside = there.square(LIMITS)
            largest = float(np.max(np.abs(deviation.grid_mm(*_samples(LIMITS)))[inside], initial=0.0)) * weight
            return CorrectedSurface(surface, worst, largest)
        if pieces >= MOST or (pieces > MANY and worst > HOPELESS * before):
            rows, columns = surface.control_mm.shape[:2]
            raise Code.SRF_TOLERANCE.refusal(
                f"{rows} × {columns} control points leave {worst * UM_PER_MM:.3g} µm; "
                f"{tolerance_mm * UM_PER_MM:g} µm is wanted",
                hint="the nominal surface has a crease or a seam there: correct its faces one by one, or allow more",
                override="compensation.tolerance_um in the job",
                values={"left_um": worst * UM_PER_MM, "limit_um": tolerance_mm * UM_PER_MM},
            )
        pieces, before = min(MOST, int(1.5 * pieces)), worst


def moved_mm(nominal: Surface, deviation: Deviation, weight: float, u: Array, v: Array) -> Array:
    """The exact M(u, v) on a grid of parameters in [0, 1]: (len(u), len(v), 3)."""
    (u0, u1), (v0, v1) = nominal.domain
    wide_u, wide_v = np.repeat(u0 + (u1 - u0) * u, len(v)), np.tile(v0 + (v1 - v0) * v, len(u))
    at = nominal.partials(wide_u, wide_v)
    shift = weight * deviation.grid_mm(u, v).ravel()
    return np.asarray(at.point_mm - shift[:, None] * nominal.normal_of(at)).reshape(len(u), len(v), 3)


def check_surface_limits(nominal: Surface, deviation: Deviation, weight: float, limits: Limits, there: OnFace) -> None:
    """Refuses a correction that is too large or too steep anywhere on the face, saying where and by how much."""
    at, inside = _samples(LIMITS), there.square(LIMITS)
    points = nominal.grid_mm(*(low + (high - low) * a for (low, high), a in zip(nominal.domain, at, strict=True)))
    size = np.where(inside, np.abs(weight * deviation.grid_mm(*at)), 0.0)
    slope = np.zeros_like(size)
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(points, axis=axis), axis=2)
        inner = (slice(0, -1), slice(None)) if axis == 0 else (slice(None), slice(0, -1))
        both = inside[inner] & (inside[1:] if axis == 0 else inside[:, 1:])
        both &= steps > COLLAPSED_MM
        rise = np.where(both, np.diff(weight * deviation.grid_mm(*at), axis=axis), 0.0)
        slope[inner] = np.hypot(slope[inner], rise / np.maximum(steps, COLLAPSED_MM))
    for code, values, limit, unit, key in (
        (Code.CMP_SIZE, size, limits.correction_mm, "µm", "correction_mm"),
        (Code.CMP_SLOPE, slope, limits.slope, "µm/mm", "slope"),
    ):
        k = np.unravel_index(int(np.argmax(values)), values.shape)
        if values[k] > limit:
            x, y, z = points[k]
            raise code.refusal(
                f"the correction reaches {values[k] * UM_PER_MM:.1f} {unit} at x {x:.3f}, y {y:.3f}, z {z:.3f} mm; the "
                f"limit is {limit * UM_PER_MM:.1f} {unit}",
                hint="look at the deviations there first: bad touches are likelier than such an error",
                override=allowed_by(key),
                values=dict(zip(code.values, (float(values[k]) * UM_PER_MM, limit * UM_PER_MM), strict=True)),
            )


@dataclass(frozen=True, eq=False)
class _Lines:
    """The knots of the refit in one direction, on [0, 1], and the parameters of its samples."""

    knots: Array
    samples: Array
    checks: Array


def _lines(knots: Array, degree: int, pieces: int) -> _Lines:
    """At least so many pieces, none across a knot of the nominal surface, and as smooth there as the normal is.

    Where the nominal is smooth to order p − m, its normal, and with it the corrected surface, is so to one order less.
    """
    inner, count = np.unique(knots[(knots > 0) & (knots < 1)], return_counts=True)
    spans = np.diff(np.concatenate([[0.0], inner, [1.0]]))
    parts = [max(1, round(pieces * float(span))) for span in spans]
    ends = np.concatenate([[0.0], inner, [1.0]])
    cells = np.concatenate(
        [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], parts, strict=True)]
    )
    repeat = dict(zip(inner.tolist(), np.clip(DEGREE - (degree - count - 1), 1, DEGREE).tolist(), strict=True))
    own = np.repeat(cells[1:], [repeat.get(cell, 1) for cell in cells[1:].tolist()])
    edges = np.append(cells, 1.0)

    def within(each: int) -> Array:
        share = np.arange(each) / each
        return np.append((edges[:-1, None] + np.diff(edges)[:, None] * share).ravel(), 1.0)

    clamped = np.concatenate([np.zeros(DEGREE + 1), own, np.ones(DEGREE + 1)])
    return _Lines(clamped, within(DEGREE + 1), within(CHECKS * (DEGREE + 1)))


def _knots(nominal: Surface) -> tuple[Array, Array]:
    """The nominal's knots on [0, 1]."""
    (u0, u1), (v0, v1) = nominal.domain
    return (nominal.knots_u - u0) / (u1 - u0), (nominal.knots_v - v0) / (v1 - v0)


def _fitted(nominal: Surface, deviation: Deviation, weight: float, lines: Sequence[_Lines]) -> Surface:
    along, across = lines
    points = moved_mm(nominal, deviation, weight, along.samples, across.samples)
    surface = fit_parameterised(points, (along.samples, across.samples), (along.knots, across.knots), DEGREE)
    return surface.turned_over() if nominal.flipped else surface


def _off(nominal: Surface, deviation: Deviation, weight: float, surface: Surface, lines: Sequence[_Lines]) -> float:
    u, v = (line.checks[:: max(1, len(line.checks) // 700)] for line in lines)
    exact, fitted = moved_mm(nominal, deviation, weight, u, v), surface.grid_mm(u, v)
    return float(np.max(np.linalg.norm(exact - fitted, axis=2)))


def _samples(count: int) -> tuple[Array, Array]:
    at = np.linspace(0.0, 1.0, count)
    return at, at


UNLIMITED = Limits(correction_mm=math.inf, slope=math.inf)


@dataclass(frozen=True, eq=False)
class WrittenPattern:
    """Nominal surface and pattern in CAD files of these names, the pattern magnified by `factor`."""

    files: tuple[str, ...]
    factor: float
    made: CorrectedSurface


def pattern_surface(
    nominal: Surface, pattern: Deviation, factor: float, tolerance_mm: float = SurfaceOptions.tolerance_mm
) -> CorrectedSurface:
    """N(u, v) + factor · MPM(u, v) · n(u, v): what the process makes of the nominal surface, material left on outwards
    [MPM §6], fitted to `tolerance_mm` times the factor where that magnifies.

    With a factor so large that the pattern reaches the surface's radius of curvature, the surface folds. Raises
    SRF-TOLERANCE where no fit comes that near.
    """
    allowed = tolerance_mm * max(1.0, factor)
    return corrected_surface(nominal, pattern, weight=-factor, tolerance_mm=allowed, limits=UNLIMITED)
