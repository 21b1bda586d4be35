"""Points of a surface as they were measured.

Checks of points measured on a surface: unit, side, place, and points that say the same twice.

Those of a scan of the whole part that are on one face are found by distance and normal.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.geometry.surface import Feet, Surface, closest, near
from trueloop.units import MM_PER_INCH, UM_PER_MM


@dataclass(frozen=True, eq=False)
class MeasuredPoints:
    """Points as a measuring machine gave them, in the part's frame: `points_mm` (n, 3), ball centres where
    `ball_radius_mm` is above zero, else points of the surface. `shape` (rows, columns) when they form a grid, row by
    row; a hole in it is a row of nan. `name` tells the part; `file` and `lines` (n,), 0 for a hole, where it was read;
    `findings` on what was left out of the file. `rounding_mm` is how far rounded coordinates put a point off. `numbers`
    (n,): of points that were found on the face among more, their numbers from 1 among all.
    """

    points_mm: Array
    ball_radius_mm: float = 0.0
    shape: tuple[int, int] | None = None
    name: str = ""
    file: str | None = None
    lines: Integers | None = None
    findings: tuple[Finding, ...] = ()
    rounding_mm: float = 0.0
    numbers: Integers | None = None

    def number_in_file(self, number: int) -> int:
        """Returns the number from 1 that a point, counted from 1 here, has in its file."""
        return number if self.numbers is None else int(self.numbers[number - 1])

    def place(self, number: int) -> Place:
        """Where a point, counted from 1, was read."""
        return Place(self.file, None if self.lines is None else int(self.lines[number - 1]))


SAME_MM: Final = 1e-4
"""Points whose feet on the surface are closer than this are at one place."""
NEIGHBOURS: Final = 2000
"""Points whose nearest neighbours say how much errors change from one point to the next."""


@dataclass(frozen=True, eq=False)
class Duplicates:
    """Points measured more than once: `spare` (m,) are the points, counted from 0, whose errors went into the mean of
    an earlier one; `places` is how many such places there are.

    Of all of them the two errors of one place that differ most: `difference_mm`, between the points `pair`.
    `typical_mm` is the median difference between a point and its nearest neighbour elsewhere.
    """

    spare: Integers
    places: int
    difference_mm: float
    pair: tuple[int, int]
    typical_mm: float


def first_of_place(points_mm: Array, within_mm: float = SAME_MM) -> Integers:
    """For each point (n, 3) the first point of its place, (n,), counted from 0: a chain of points, each within that
    distance of another one, is one place. The distance is kept to a tenth.

    In O(n log n), and memory in proportion to n: points in one spot, of which there may be any number, are joined
    before pairs are looked for.
    """
    from scipy.sparse import coo_array  # slow to import
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    first = _first_of_spot(np.rint(points_mm / (within_mm / 10)))
    spots = np.unique(first)
    near = KDTree(points_mm[spots]).query_pairs(within_mm, output_type="ndarray")
    graph = coo_array((np.ones(len(near), bool), near.T), shape=(len(spots), len(spots)))
    _, group = connected_components(graph, directed=False)
    _, earliest = np.unique(group, return_index=True)
    first[spots] = spots[earliest[group]]
    return first[first]


def _first_of_spot(spots: Array) -> Integers:
    """For each row (n, 3) the first one equal to it."""
    order = np.lexsort(spots.T)  # stable: of equal rows the first one comes first
    begins = np.concatenate([[True], np.any(np.diff(spots[order], axis=0) != 0, axis=1)])
    first = np.empty(len(spots), int)
    first[order] = order[np.flatnonzero(begins)][np.cumsum(begins) - 1]
    return first


def averaged(points_mm: Array, error_mm: Array) -> tuple[Array, Duplicates | None]:
    """Errors (n,) of points whose feet (n, 3) are given, each place's mean at its first point and nan at its others;
    and what was averaged, None where no place was measured twice.
    """
    first = first_of_place(points_mm)
    spare = np.flatnonzero(first != np.arange(len(first)))
    if not len(spare):
        return error_mm, None
    count = np.bincount(first, minlength=len(first))
    mean = np.bincount(first, error_mm, minlength=len(first)) / np.maximum(count, 1)
    found = np.where(count > 0, mean, np.nan)
    # The largest difference between two errors of one place, and the points that have them, the earlier one first
    members = np.flatnonzero(np.isin(first, np.flatnonzero(count > 1)))
    order = members[np.lexsort((error_mm[members], first[members]))]
    start = np.flatnonzero(np.diff(first[order], prepend=-1))
    end = np.append(start[1:], len(order)) - 1
    spread = error_mm[order[end]] - error_mm[order[start]]
    worst = int(np.argmax(spread))
    a, b = sorted((int(order[start[worst]]), int(order[end[worst]])))
    difference, pair = float(spread[worst]), (a, b)
    typical = _between_neighbours(points_mm[count > 0], found[count > 0])
    return found, Duplicates(spare, int(np.count_nonzero(count > 1)), difference, pair, typical)


def _between_neighbours(points_mm: Array, error_mm: Array) -> float:
    from scipy.spatial import KDTree  # slow to import

    if len(points_mm) < 2:
        return 0.0
    some = np.arange(0, len(points_mm), -(-len(points_mm) // NEIGHBOURS))
    _, near = KDTree(points_mm).query(points_mm[some], k=2)
    return float(np.median(np.abs(error_mm[some] - error_mm[np.asarray(near)[:, 1]])))


FACING: Final = 0.9
"""Cosine between a point's normal and the face's from which the point may be on it: at a sharp edge a mesh has the mean
of both faces' normals.
"""
EXACT_MM: Final = (1e-4, 1e-3)
"""No surface is cut as exactly, whatever the last digit of its points: the least and the most that rounding counts."""
FRAME: Final = 0.05
"""A scan whose deviations go on beyond the farthest, on so large a share of the face, is in another frame."""
PLANE_POINTS: Final = 12
"""Points whose plane is the normal of a point, where the file has none."""


def on_face(
    surface: Surface,
    scan: MeasuredPoints,
    normal: Array | None,
    farthest_mm: float,
    trim: Callable[[Array, Array], np.ndarray] | None = None,
    face: str = "the face",
) -> MeasuredPoints:
    """Returns the points of a scan that are on the face, with a note of the others: how many, and why.

    On the face is a point within `farthest_mm` of it, whose foot is inside its edges, and whose normal is that of the
    face. `normal` (n, 3) points out of the material; without it that of neighbouring points counts, of either sign.
    Raises SRF-OFF where no point is left, and where deviations do not end at `farthest_mm` but go on beyond it: what is
    left would be cut off there. Raises SRF-FILE where all points left have no error.
    """
    points, total = scan.points_mm, len(scan.points_mm)
    some = near(surface, points, 2 * farthest_mm + scan.ball_radius_mm)
    if len(some):
        feet = closest(surface, points[some])
        here = (np.abs(feet.distance_mm - scan.ball_radius_mm) <= 2 * farthest_mm) & (feet.beyond_mm == 0)
        if trim is not None and np.any(here):
            here[here] = ~trim(feet.u[here], feet.v[here]).astype(np.bool_)
        some, of_face, off_mm = some[here], feet.normal[here], feet.distance_mm[here] - scan.ball_radius_mm
    within = np.abs(off_mm) <= farthest_mm if len(some) else np.ones(0, dtype=np.bool_)
    beside = total - int(np.count_nonzero(within))
    facing: Flags = np.ones(len(some), dtype=np.bool_)
    if len(some) > PLANE_POINTS:
        own = _normals(points, some) if normal is None else normal[some]
        cosine = np.einsum("nk,nk->n", own, of_face)
        facing = (np.abs(cosine) if normal is None else cosine) >= FACING
    farther, facing = facing & ~within, facing & within
    kept = some[facing]
    if not len(kept):
        raise Code.SRF_OFF.refusal(
            f"0 of {total} points of {scan.name!r} are on {face}: {beside} are more than {farthest_mm:g} mm off it "
            f"or beside it, {total - beside} face elsewhere",
            hint="look at unit, frame, face and gauging.columns: the scan has to be in the frame of the CAD model",
            override="gauging.farthest_mm in the job",
            values={"part": scan.name, "limit_mm": farthest_mm},
        )
    outer = int(np.count_nonzero(np.abs(off_mm[facing]) > farthest_mm / 2))
    if min(outer, int(np.count_nonzero(farther))) > FRAME * len(kept):
        half_mm = farthest_mm / 2
        raise Code.SRF_OFF.refusal(
            f"{np.count_nonzero(farther)} points of {scan.name!r} are {farthest_mm:g} to {2 * farthest_mm:g} mm off "
            f"{face}, {outer} are {half_mm:g} to {farthest_mm:g} mm off, and {len(kept) - outer} nearer: they are in "
            "another frame, or of another part",
            hint="look at frame, face and part: axes swapped or reversed (a mirror), a turn by 180°, another zero",
            override="gauging.farthest_mm in the job",
            values={"part": scan.name, "limit_mm": farthest_mm},
        )
    exact_mm = float(np.clip(scan.rounding_mm, *EXACT_MM))
    if len(kept) > PLANE_POINTS and np.all(np.abs(off_mm[facing]) <= exact_mm):
        raise Code.SRF_FILE.refusal(
            f"all {len(kept)} points of {scan.name!r} on {face} are exactly nominal, within {exact_mm:.2g} mm: not "
            "measured",
            hint="name the columns of the measured x, y and z: gauging.columns in the job; where the file has "
            "deviations alone, export the measured points",
            place=Place(scan.file),
        )
    note = Finding(
        Severity.NOTE,
        Code.SRF_OUTSIDE,
        f"{len(kept)} of {total} points of {scan.name!r} are on {face}: {beside} are more than {farthest_mm:g} mm "
        f"off it or beside it, {total - beside - len(kept)} face elsewhere",
        "nothing to do where the scan is of more than the face",
        values={"part": scan.name},
    )
    lines, notes = None if scan.lines is None else scan.lines[kept], (note,) if len(kept) < total else ()
    return replace(scan, points_mm=points[kept], lines=lines, findings=notes, numbers=kept + 1)


def _normals(points_mm: Array, some: np.ndarray) -> Array:
    """Normals (m, 3) of the planes through the neighbours of some of the points, of either sign."""
    from scipy.spatial import KDTree  # slow to import

    _, around = KDTree(points_mm).query(points_mm[some], k=PLANE_POINTS)
    off = points_mm[around] - np.mean(points_mm[around], axis=1, keepdims=True)
    _, turned = np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))
    return np.asarray(turned[:, :, 0])


CONFLICT: Final = 6.0
"""Values of one place that differ by so many times what neighbours do contradict each other."""
BEYOND_MM: Final = 0.05
"""Sideways distance from the edge that a touch may have: its foot is then the edge."""
AREA: Final = 40
HOLES: Final = 0.25
"""A grid with a larger share of holes is not a grid."""


def findings_of(
    surface: Surface, points: MeasuredPoints, there: np.ndarray, feet: Feet, farthest_mm: float, *, bound: bool
) -> tuple[Finding, ...]:
    """Refuses points that cannot belong to the surface; returns what is only suspicious.

    bound: the points keep to the datums, so that a deviation common to all of them is one of the part.
    """
    xyz, radius = points.points_mm[there], points.ball_radius_mm
    number = np.flatnonzero(there) + 1
    error = feet.distance_mm - radius
    refuse_unit(surface, xyz, error, radius, points.name)
    # Ball centres inside the material: the normal points the wrong way
    middle = float(np.median(feet.distance_mm))
    if radius > 0 and abs(middle + radius) < 0.5 * radius:
        raise Code.SRF_SIGN.refusal(
            f"the ball's centre is {middle:.4f} mm from the surface of {points.name!r}, on the inner side of the "
            f"material; with a ball of radius {radius:g} mm it should be at {radius:g} mm",
            hint="the surface's normals point into the material: turn them (flip = true)",
        )
    if np.any(bad := np.abs(error) > farthest_mm):
        worst = int(np.argmax(np.abs(error)))
        x, y, z = xyz[worst]
        shown = points.number_in_file(int(number[worst]))
        raise Code.SRF_OFF.refusal(
            f"{np.count_nonzero(bad)} of {len(error)} points of {points.name!r} are more than {farthest_mm:g} mm off "
            f"the surface; the farthest, with {error[worst]:+.3f} mm, is point {shown} (x {x:.3f}, y {y:.3f}, "
            f"z {z:.3f} mm)",
            hint="look at frame, ball radius and that touch; a larger distance can be allowed",
            place=points.place(int(number[worst])),
            override="gauging.farthest_mm in the job",
            values={"part": points.name, "limit_mm": farthest_mm},
        )
    refuse_outside(points, feet.beyond_mm > BEYOND_MM, number, xyz)
    found = [*points.findings, *_holes(points, there), *_ball(surface, feet, radius)]
    if bound:
        found += _off_alike(error, radius)
    return tuple(found)


CLUSTER: Final = 0.1
"""Points as wide as a smaller share of the face are likely in another unit, however near it they are."""
UNITS: Final = (
    (MM_PER_INCH, 'they are in inch: for a scan, gauging.unit = "inch" in the job; else write them in mm'),
    (1 / MM_PER_INCH, 'they are in mm and were read as inch: gauging.unit = "mm" in the job'),
    (1 / UM_PER_MM, "they are in µm: write them in mm"),
    (UM_PER_MM, "they are in m: write them in mm"),
)
"""Factors to mm, and what they say."""


def refuse_unit(surface: Surface, xyz: Array, error: Array, radius: float, name: str) -> None:
    """Points that, read in another unit, are about as large as the surface and fit it far better."""
    off = float(np.median(np.abs(error)))
    size = float(np.linalg.norm(np.ptp(surface.control_mm.reshape(-1, 3), axis=0)))
    if off < 1e-3 * size and float(np.linalg.norm(np.ptp(xyz, axis=0))) > CLUSTER * size:
        return
    for factor, hint in UNITS:
        some = xyz[:: max(1, len(xyz) // 200)] * factor
        share = float(np.linalg.norm(np.ptp(some, axis=0))) / size
        fits = np.median(np.abs(closest(surface, some).distance_mm - radius))
        if 0.3 < share < 1.5 and fits < max(0.05 * off, 1e-3 * size):
            raise Code.SRF_UNIT.refusal(
                f"the points of {name!r} are {off:.3f} mm off the surface and as wide as {share / factor:.2g} of it; "
                f"multiplied by {factor:g} they fit",
                hint=hint,
                values={"part": name},
            )


def refuse_outside(points: MeasuredPoints, outside: np.ndarray, number: Integers, xyz: Array) -> None:
    """Refuses points of a part that lie beyond the edge of the face: `outside` (n,) says which of `xyz` (n, 3) do."""
    if np.any(outside):
        first = int(np.argmax(outside))
        x, y, z = xyz[first]
        raise Code.SRF_OUTSIDE.refusal(
            f"point {number[first]} of {points.name!r} (x {x:.3f}, y {y:.3f}, z {z:.3f} mm) lies beyond the edge of "
            f"the face, as do {np.count_nonzero(outside) - 1} others",
            hint="leave points off the face out, or name the face they lie on",
            place=points.place(int(number[first])),
            values={"part": points.name},
        )


def refuse_twice(points: MeasuredPoints, at: Integers, first: Integers) -> None:
    """Refuses a grid two of whose places are one: `at` (n,) are the points measured, `first` (n,) which of these is the
    first of each one's place.
    """
    spare = np.flatnonzero(first != np.arange(len(first)))
    if len(spare):
        a, b = int(at[first[spare[0]]]) + 1, int(at[spare[0]]) + 1
        raise Code.SRF_DUPLICATE.refusal(
            f"points {a} and {b} of {points.name!r}, two places of a grid, are the same to {SAME_MM} mm, as are "
            f"{len(spare) - 1} others",
            hint="give every place of the grid its own point; without row and column, points of one place are averaged",
            place=points.place(b),
            values={"part": points.name, "points": [a, b]},
        )


def reported_twice(points: MeasuredPoints, found: Duplicates, at: Integers) -> Finding:
    """Reports the averaged points among `at` (n,); a warning if one place's values differ far more than neighbours."""
    first, second = (int(at[number]) + 1 for number in found.pair)
    a, b = points.number_in_file(first), points.number_in_file(second)
    odd = found.difference_mm > CONFLICT * found.typical_mm
    return Finding(
        Severity.WARNING if odd else Severity.NOTE,
        Code.SRF_DUPLICATE,
        f"{len(found.spare)} of {len(points.points_mm)} points of {points.name!r} were averaged with others of their "
        f"place ({found.places} places, within {SAME_MM * UM_PER_MM:g} µm): their values differ by up to "
        f"{found.difference_mm * UM_PER_MM:.2f} µm (points {a} and {b}), neighbours by "
        f"{found.typical_mm * UM_PER_MM:.2f} µm (median)",
        "look at these two: one is no touch of this place, or the part moved between them" if odd else "nothing to do",
        points.place(second),
        values={"part": points.name, "points": [a, b]},
    )


def _holes(points: MeasuredPoints, there: np.ndarray) -> Iterator[Finding]:
    missing = int(np.count_nonzero(~there))
    if missing > HOLES * len(there):
        raise Code.SRF_HOLES.refusal(
            f"{missing} of {len(there)} points of {points.name!r} are missing; {HOLES:.0%} is the most a grid may lack",
            hint="measure them, or give the points without row and column",
            values={"part": points.name, "missing": missing},
        )
    if missing:
        yield Finding(
            Severity.WARNING,
            Code.SRF_HOLES,
            f"{missing} of {len(there)} points of {points.name!r} are missing",
            "the model bridges them smoothly; what it says there is not measured",
            values={"part": points.name, "missing": missing},
        )


def _ball(surface: Surface, feet: Feet, radius: float) -> Iterator[Finding]:
    """A ball larger than a hollow touches its rims, not its ground: the whole measured area is looked at."""
    if radius <= 0:
        return
    u, v = (np.linspace(np.min(k), np.max(k), AREA + 2)[1:-1] for k in (feet.u, feet.v))
    u, v = np.repeat(u, AREA), np.tile(v, AREA)
    hollow = surface.curvatures_per_mm(u, v)[:, 0]
    worst = int(np.argmin(hollow))
    if hollow[worst] * radius <= -1.0:
        x, y, z = surface.point_mm(u[worst : worst + 1], v[worst : worst + 1])[0]
        yield Finding(
            Severity.WARNING,
            Code.SRF_BALL,
            f"a ball of radius {radius:g} mm cannot reach the ground on {np.mean(hollow * radius <= -1.0):.0%} of the "
            f"area: the surface is concave with radius {-1 / hollow[worst]:.3f} mm at x {x:.3f}, y {y:.3f}, "
            f"z {z:.3f} mm",
            "take a smaller ball; deviations of its rims are reported as those of the ground",
            values={"ball_radius_mm": radius},
        )


def _off_alike(error: Array, radius: float) -> Iterator[Finding]:
    """All points off by about the same, more than an error of machining would be: centres given as touches, or a ball
    of another radius.
    """
    middle, scatter = float(np.median(error)), float(np.std(error))
    if abs(middle) > 0.1 and scatter < 0.2 * abs(middle):
        side = "outside" if middle > 0 else "inside"
        centres = "if they are ball centres, give ball_radius_mm; if the normals point inwards, flip them"
        ball = (
            f"they fit a ball of radius {radius + middle:.3f} mm, and gauging.ball_radius_mm is {radius:g} mm: look "
            "for a diameter, another stylus, and points that are corrected for the ball already (ball_radius_mm = 0)"
        )
        yield Finding(
            Severity.WARNING,
            Code.SRF_SIGN,
            f"all points deviate by about {middle:+.3f} mm, scattering by {scatter:.3f} mm: {side} the material",
            ball if radius > 0 else centres,
        )
