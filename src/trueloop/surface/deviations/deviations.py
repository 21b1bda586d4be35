"""Deviations of measured points from a nominal surface, along its outward normals.

Error = n · (measured − nominal), positive where material was left on. Ball-centre data are compared with the surface
offset by the ball's radius: along a common normal that is the centre's distance from the nominal surface less the
radius, and no compensation of the ball, with its own errors, comes in.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Finding, Severity, in_file
from trueloop.geometry.surface import Feet, Surface, closest
from trueloop.surface.deviations.alignment import DATUM, SETUP_MM, Alignment, Faces, best_fit, stands_off_mm
from trueloop.surface.deviations.points import (
    MeasuredPoints,
    averaged,
    findings_of,
    first_of_place,
    refuse_outside,
    refuse_twice,
    reported_twice,
)
from trueloop.units import UM_PER_MM

PLACES = 60


@dataclass(frozen=True)
class SamplingAdvice:
    """A grid that takes from the surface what the ball can feel.

    `step_mm` is the ball's radius; `shortest_wave_mm`, twice the step, the shortest wave that the grid tells from
    others (Nyquist). `rows` and `columns` cover the longest lines along u and v. `hollow_radius_mm` is the surface's
    smallest concave radius (inf: none); the ball has to be smaller: `reaches_everywhere`.
    """

    step_mm: float
    shortest_wave_mm: float
    rows: int
    columns: int
    hollow_radius_mm: float
    reaches_everywhere: bool


def sampling_advice(surface: Surface, ball_radius_mm: float, step_mm: float | None = None) -> SamplingAdvice:
    """Advice for a ball: the step of the grid equals the ball's radius [MPM §3], or is the one given.

    A ball rolls over waves shorter than about its radius: a finer grid would measure the ball, a coarser one would
    mistake short waves for long ones. Raises SRF-BALL for a radius that is not positive.
    """
    if not ball_radius_mm > 0:
        raise Code.SRF_BALL.refusal(
            f"a ball of radius {ball_radius_mm} mm has no sampling step",
            hint="give the calibrated radius of the stylus tip in mm",
            values={"ball_radius_mm": ball_radius_mm},
        )
    step = step_mm or ball_radius_mm
    (u0, u1), (v0, v1) = surface.domain
    us, vs = np.linspace(u0, u1, PLACES), np.linspace(v0, v1, PLACES)
    grid = surface.grid_mm(us, vs)
    along = float(np.max(np.sum(np.linalg.norm(np.diff(grid, axis=0), axis=2), axis=0)))
    across = float(np.max(np.sum(np.linalg.norm(np.diff(grid, axis=1), axis=2), axis=1)))
    u, v = (us[:-1] + us[1:]) / 2, (vs[:-1] + vs[1:]) / 2  # not at the edges: a pole has no curvature
    hollow = float(np.min(surface.curvatures_per_mm(np.repeat(u, len(v)), np.tile(v, len(u)))[:, 0]))
    radius = -1.0 / hollow if hollow < 0 else float("inf")
    rows, columns = int(np.ceil(along / step)) + 1, int(np.ceil(across / step)) + 1
    return SamplingAdvice(
        step_mm=step,
        shortest_wave_mm=2 * step,
        rows=rows,
        columns=columns,
        hollow_radius_mm=radius,
        reaches_everywhere=ball_radius_mm < radius,
    )


LEAST_POINTS = 16
"""Fewer points do not determine a surface."""


@dataclass(frozen=True, eq=False)
class SurfaceDeviations:
    """Deviations of one part, a value a point: parameters, nominal points and normals, and errors in mm.

    `shape` as measured; errors of holes are nan, as are those of points that were averaged with an earlier one of the
    same place. `alignment` says whether location and orientation are among the errors (datum)
    or were taken out (best fit: form alone).
    """

    name: str
    u: Array
    v: Array
    nominal_mm: Array
    normal: Array
    error_mm: Array
    shape: tuple[int, int] | None
    alignment: Alignment
    findings: tuple[Finding, ...] = field(default=())

    @property
    def measured(self) -> np.ndarray:
        """Which points are not holes."""
        return np.isfinite(self.error_mm)


def fit_of_faces(
    surfaces: Sequence[Surface], points: Sequence[MeasuredPoints], setup_mm: float = SETUP_MM
) -> Alignment:
    """Returns the best fit of one part, measured on several faces, to all of them together. Raises SRF-SETUP."""
    there = [np.all(np.isfinite(one.points_mm), axis=1) for one in points]
    xyz = np.concatenate([one.points_mm[has] for one, has in zip(points, there, strict=True)])
    face = np.repeat(np.arange(len(points)), [int(np.count_nonzero(has)) for has in there])
    faces, first = Faces(tuple(surfaces), face), points[0]
    with in_file(first.file):
        return best_fit(faces, xyz, first.ball_radius_mm, faces.closest(xyz), setup_mm, first.name)[0]


def surface_deviations(
    surface: Surface,
    points: MeasuredPoints,
    *,
    fit: bool | Alignment = False,
    farthest_mm: float = 1.0,
    setup_mm: float = SETUP_MM,
) -> SurfaceDeviations:
    """Deviations along the normals, datum-bound or, with `fit`, after a best fit of what the set-up may have done; or
    after the fit of all faces of the part (`fit_of_faces`).

    Scattered points of one place are averaged, and reported; two places of a grid in one spot are refused.
    farthest_mm: a point that stands farther off is refused. setup_mm: how far the part may sit off its datums; motions
    that the points tell worse are not taken out. Raises SRF-POINTS (too few), SRF-OFF, SRF-UNIT, SRF-SIGN, SRF-OUTSIDE,
    SRF-DUPLICATE, SRF-SETUP; what is only suspicious is among `findings`.
    """
    xyz = np.asarray(points.points_mm, float)
    there = np.all(np.isfinite(xyz), axis=1)
    with in_file(points.file):
        _enough(points, there)
        feet = closest(surface, xyz[there])
        found = findings_of(surface, points, there, feet, farthest_mm, bound=not fit)
        alignment = DATUM
        if isinstance(fit, Alignment):
            alignment, feet = fit, closest(surface, fit.apply(xyz[there]))
            found += tuple(_left(points.name, alignment, setup_mm))
        elif fit:
            alone = Faces((surface,), np.zeros(int(np.count_nonzero(there)), int))
            alignment, feet, aside = best_fit(alone, xyz[there], points.ball_radius_mm, feet, setup_mm, points.name)
            found += (*_left(points.name, alignment, setup_mm), *_aside(points, there, feet, aside))
        findings = tuple(finding.in_file(points.file) for finding in found)
        return _once(points, _filled(points, there, feet, alignment, findings))


def inside_trim(
    points: MeasuredPoints, deviations: SurfaceDeviations, trimmed_away: Callable[[Array, Array], np.ndarray]
) -> SurfaceDeviations:
    """Returns the deviations, of points chosen from a scan those alone that a best fit did not take off the face.

    The function says for parameters u and v (n,) which feet lie in a hole or beyond the trimmed edge of the face, as
    the CAD kernel knows. Raises SRF-OUTSIDE for other points that do.
    """
    there = deviations.measured
    outside = trimmed_away(deviations.u[there], deviations.v[there]).astype(np.bool_)
    if points.numbers is None:
        refuse_outside(points, outside, np.flatnonzero(there) + 1, deviations.nominal_mm[there])
        return deviations
    error_mm = deviations.error_mm.copy()
    error_mm[np.flatnonzero(there)[outside]] = np.nan
    _enough(points, np.isfinite(error_mm))
    return replace(deviations, error_mm=error_mm)


def _left(name: str, alignment: Alignment, setup_mm: float) -> Iterator[Finding]:
    if alignment.left:
        yield Finding(
            Severity.NOTE,
            Code.SRF_SETUP,
            f"the best fit of {name!r} leaves {len(alignment.left)} of 6 motions as the datums have them: "
            + "; ".join(alignment.left),
            f"its points do not tell them well enough for a set-up that is off by {setup_mm:g} mm at most "
            "(gauging.setup_mm); taken out, they would take form with them",
            values={"part": name, "setup_mm": setup_mm},
        )


def _aside(points: MeasuredPoints, there: Flags, feet: Feet, aside: Flags) -> Iterator[Finding]:
    """Reports points that do not count for the best fit."""
    if np.any(aside):
        error = feet.distance_mm - points.ball_radius_mm
        worst = int(np.argmax(np.where(aside, np.abs(error), 0.0)))
        number = int(np.flatnonzero(there)[worst]) + 1
        x, y, z = feet.point_mm[worst]
        yield Finding(
            Severity.WARNING,
            Code.SRF_OFF,
            f"{np.count_nonzero(aside)} of {len(aside)} points of {points.name!r} deviate far more than the others "
            f"scatter, by up to {UM_PER_MM * error[worst]:+.1f} µm (x {x:.3f}, y {y:.3f}, z {z:.3f} mm): the best fit "
            "leaves them out",
            "look at these touches: leave them out of the file where a chip or dirt was measured",
            points.place(number),
            values={"part": points.name, "limit_mm": stands_off_mm(error)},
        )


def _filled(
    points: MeasuredPoints, there: np.ndarray, feet: Feet, alignment: Alignment, findings: tuple[Finding, ...]
) -> SurfaceDeviations:
    def whole(values: Array) -> Array:
        filled = np.full((len(there), *values.shape[1:]), np.nan)
        filled[there] = values
        return filled

    error = feet.distance_mm - points.ball_radius_mm
    u, v, nominal, normal, error = (whole(c) for c in (feet.u, feet.v, feet.point_mm, feet.normal, error))
    return SurfaceDeviations(
        name=points.name,
        u=u,
        v=v,
        nominal_mm=nominal,
        normal=normal,
        error_mm=error,
        shape=points.shape,
        alignment=alignment,
        findings=findings,
    )


def _once(points: MeasuredPoints, deviations: SurfaceDeviations) -> SurfaceDeviations:
    """Places measured more than once have their mean, at their first point; the other points become holes."""
    at = np.flatnonzero(deviations.measured)
    if deviations.shape is not None:
        refuse_twice(points, at, first_of_place(deviations.nominal_mm[at]))
        return deviations
    error, twice = averaged(deviations.nominal_mm[at], deviations.error_mm[at])
    if twice is None:
        return deviations
    values = deviations.error_mm.copy()
    values[at] = error
    _enough(points, np.isfinite(values))
    averaged_places = reported_twice(points, twice, at).in_file(points.file)
    return replace(deviations, error_mm=values, findings=(*deviations.findings, averaged_places))


def _enough(points: MeasuredPoints, there: np.ndarray) -> None:
    if np.count_nonzero(there) < LEAST_POINTS:
        raise Code.SRF_POINTS.refusal(
            f"{points.name!r} has {np.count_nonzero(there)} points; {LEAST_POINTS} are the least for a surface",
            hint="measure along a grid; `trueloop surface sampling` prints its step",
            values={"part": points.name},
        )
    if points.shape is not None and points.shape[0] * points.shape[1] != len(there):
        raise Code.SRF_GRID.refusal(
            f"{points.name!r} has {len(there)} points, its grid {points.shape[0]} × {points.shape[1]} places",
            hint="give every place of the grid a row, or leave out row and column",
        )
