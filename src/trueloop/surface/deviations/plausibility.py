"""Checks of points measured on a surface: unit, side, place, and points that say the same twice."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Finding, Severity
from trueloop.geometry.surface import Feet, Surface, closest
from trueloop.surface.deviations.points import SAME_MM, Duplicates, MeasuredPoints
from trueloop.units import MM_PER_INCH, UM_PER_MM

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
