"""A pattern in figures, over the face that exists: what trimming cut away counts nowhere."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity
from trueloop.geometry.surface import Surface
from trueloop.surface.deviations.alignment import rigid_motions, spread_of
from trueloop.surface.on_face import FIGURES, SUPPORT, OnFace, square
from trueloop.surface.pattern.pattern import PLACES, Pattern, by_chance
from trueloop.surface.pattern.support import between
from trueloop.surface.separation.separate import COVERAGE
from trueloop.units import UM_PER_MM

MUCH: Final = 0.1
"""Of a face with a larger share without support the mean uncertainty is not that of what was measured."""
MOST: Final = 0.5
"""Share of a pattern from which a motion of the part is named as what makes it."""
NAMED: Final = 0.001
"""A smaller share of the face without support is not reported: the last row of points never stands on the edge."""


@dataclass(frozen=True)
class SurfaceFigures:
    """Of the face as it is: the largest correction before weighting, the mean half-widths (95 %) for the pattern and
    for what a next part keeps, the share of the pattern's mean square that a motion of the part makes (`rigid`); the
    share of its area that no measurement supports, and the largest half-width there with its place (x, y, z).
    """

    largest_mm: float
    uncertainty_mm: float
    next_part_mm: float
    unsupported: float = 0.0
    unsupported_u_mm: float = 0.0
    unsupported_at_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rigid: float = 0.0


def figures_of(surface: Surface, pattern: Pattern, there: OnFace) -> SurfaceFigures:
    """Returns the figures of a pattern over the face that is `there`."""
    at, _, _ = square(FIGURES)
    inside = there.square(FIGURES).ravel()
    largest = float(np.max(np.abs(pattern.mean.grid_mm(at, at)).ravel()[inside], initial=0.0))
    unsure, kept = (
        float(np.mean(values.ravel()[inside])) if np.any(inside) else 0.0
        for values in (pattern.uncertainty_grid_mm(at, at), pattern.next_part_grid_mm(at, at))
    )
    rigid = _rigid_share(surface, pattern, there)
    if pattern.support is None:
        return SurfaceFigures(largest, unsure, kept, rigid=rigid)
    at, u, v = square(SUPPORT)
    inside = there.square(SUPPORT).ravel()
    area = np.where(inside, _area(surface, u, v), 0.0)
    bare = inside & ~pattern.support.supported.ravel()
    unsure_mm = np.where(bare, pattern.uncertainty_grid_mm(at, at).ravel(), 0.0)
    worst = int(np.argmax(unsure_mm))
    (u0, u1), (v0, v1) = surface.domain
    x, y, z = surface.point_mm(u0 + (u1 - u0) * u[[worst]], v0 + (v1 - v0) * v[[worst]])[0].tolist()
    share = float(np.sum(area[bare]) / np.sum(area)) if np.any(inside) else 0.0
    return SurfaceFigures(
        largest_mm=largest,
        uncertainty_mm=unsure,
        next_part_mm=kept,
        rigid=rigid,
        unsupported=share,
        unsupported_u_mm=float(unsure_mm[worst]),
        unsupported_at_mm=(x, y, z),
    )


def _rigid_share(surface: Surface, pattern: Pattern, there: OnFace) -> float:
    """Returns the share of the pattern's mean square that a small motion of the part makes, 0 to 1."""
    at, u, v = square(FIGURES)
    inside = there.square(FIGURES).ravel()
    pattern_mm = pattern.mean.grid_mm(at, at).ravel()[inside]
    if not np.any(pattern_mm):
        return 0.0
    (u0, u1), (v0, v1) = surface.domain
    places = u0 + (u1 - u0) * u[inside], v0 + (v1 - v0) * v[inside]
    points = surface.point_mm(*places)
    centre = np.mean(points, axis=0)
    motions = rigid_motions(points, surface.normal(*places), centre, spread_of(points, centre))
    made = motions.shapes[:, motions.size > 1e-12 * motions.size[0]]
    return float(np.sum((made.T @ pattern_mm) ** 2) / np.sum(pattern_mm**2))


def rigid_findings(figures: SurfaceFigures, parts: Sequence[str], setup_mm: float) -> Iterator[Finding]:
    """Yields a warning where a motion of the part makes most of a pattern that is corrected by the datum."""
    if figures.rigid > MOST:
        yield Finding(
            Severity.WARNING,
            Code.SRF_SETUP,
            f"{100 * figures.rigid:.0f} % of the pattern's mean square is a shift or turn of the part: a fixture, the "
            "tool's length, or the alignment of the measurement makes it",
            'gauging.alignment = "best-fit" takes it out and corrects form alone',
            values={"part": ", ".join(parts), "setup_mm": setup_mm},
        )


def require_known(figures: SurfaceFigures, pattern: Pattern, there: OnFace, best_fit: bool) -> None:
    """Raises SRF-PARTS for a pattern that parts which differ so have by chance: its correction may make worse.

    Parts that were set up anew and are compared by their datum differ so, and not in form. A face of which much is not
    supported is judged by `check_support`: the uncertainty there says nothing of the rest. Few parts are shrunk by what
    they cannot tell: where they show nothing, nothing is corrected.
    """
    if pattern.own_mm is not None:
        return
    inside = there.square(FIGURES)[:: (FIGURES - 1) // (PLACES - 1), :: (FIGURES - 1) // (PLACES - 1)].ravel()
    if figures.unsupported > MUCH or (p_value := by_chance(pattern.models, inside)) < 1 - COVERAGE:
        return
    more = "measure more parts; these show nothing to correct"
    raise Code.SRF_PARTS.refusal(
        f"the pattern of {pattern.parts} parts, up to {figures.largest_mm * UM_PER_MM:.1f} µm, is known to "
        f"± {figures.uncertainty_mm * UM_PER_MM:.1f} µm (95 %): parts that differ as these do show one as large by "
        f"chance (p {p_value:.2g})",
        hint=more
        if best_fit
        else f'gauging.alignment = "best-fit" takes out how each part was set up, and corrects form alone; or {more}',
    )


def assumed_findings(pattern: Pattern) -> Iterator[Finding]:
    """Yields a note of how much parts are assumed to differ, where too few parts show it."""
    if pattern.own_mm is not None:
        yield Finding(
            Severity.NOTE,
            Code.SRF_PARTS,
            f"how much parts differ is not seen in {pattern.of_parts}: {pattern.own_mm * UM_PER_MM:.2f} µm (one "
            "standard deviation) is assumed, and the correction is shrunk by that and by what the points do not tell",
            "model.part_to_part_um in the job states it, where it is known; three parts or more show it",
        )


def unsupported_at(pattern: Pattern, u: Array, v: Array) -> np.ndarray:
    """Returns which pairs of parameters in [0, 1] no measurement supports."""
    if pattern.support is None:
        return np.zeros(np.shape(u), bool)
    return np.asarray(between(1.0 - pattern.support.supported, np.ravel(u), np.ravel(v)) > 0.5).reshape(np.shape(u))


def headline(figures: SurfaceFigures) -> str:
    """Returns the share of the face without support, in words; empty where that is negligible."""
    if figures.unsupported < NAMED:
        return ""
    return (
        f"{100 * figures.unsupported:.1f} % of the face is not supported by measurements: correction faded to what the "
        f"pattern around tells, known there to ± {figures.unsupported_u_mm * UM_PER_MM:.1f} µm (95 %) at worst"
    )


def support_findings(figures: SurfaceFigures) -> Iterator[Finding]:
    """Yields a warning where a part of the face is not supported."""
    if words := headline(figures):
        x, y, z = figures.unsupported_at_mm
        at = f"near x {x:.3f}, y {y:.3f}, z {z:.3f} mm"
        hint = (
            "measure there as well: far from any point, in lengths of the pattern's waves, the face stays as programmed"
        )
        yield Finding(Severity.WARNING, Code.SRF_SUPPORT, f"{words}, {at}", hint)


def check_support(figures: SurfaceFigures, least: float) -> None:
    """Refuses a correction of a face of which measurements support less than a share. Raises SRF-SUPPORT."""
    if 1 - figures.unsupported < least:
        x, y, z = figures.unsupported_at_mm
        raise Code.SRF_SUPPORT.refusal(
            f"measurements support {100 * (1 - figures.unsupported):.1f} % of the face; {100 * least:g} % is the "
            f"least; they say least near x {x:.3f}, y {y:.3f}, z {z:.3f} mm",
            hint="measure the whole face, with points no farther apart than a quarter of the pattern's waves",
            override="compensation.min_supported_percent in the job",
        )


def support_record(figures: SurfaceFigures, pattern: Pattern) -> dict[str, object]:
    """Returns how far measurements support the pattern over the face, and the process by which this is judged."""
    support: dict[str, object] = {"unsupported_percent": 100 * figures.unsupported}
    if pattern.support is None:
        return support
    process = pattern.support.process
    return support | {
        "largest_u95_um": figures.unsupported_u_mm * UM_PER_MM,
        "largest_u95_at_mm": list(figures.unsupported_at_mm),
        "waves_um": process.waves_mm2**0.5 * UM_PER_MM,
        "waves_mm": list(process.waves_mm),
        "form_um": process.form_mm2**0.5 * UM_PER_MM,
        "form_mm": list(process.form_mm),
        "noise_of_mean_um": process.noise_mm2**0.5 * UM_PER_MM,
    }


def _area(surface: Surface, u: Array, v: Array) -> Array:
    """Returns the area of the surface at pairs of parameters in [0, 1], in proportion."""
    (u0, u1), (v0, v1) = surface.domain
    at = surface.partials(u0 + (u1 - u0) * u, v0 + (v1 - v0) * v)
    return np.asarray(np.linalg.norm(np.cross(at.du, at.dv), axis=1))
