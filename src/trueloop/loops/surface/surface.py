"""From measured parts to a corrected surface and a corrected program."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Place, Severity, in_file
from trueloop.geometry.surface import Surface
from trueloop.loops.batch import Item, Result, run_batch
from trueloop.loops.surface.figures import (
    SurfaceFigures,
    assumed_findings,
    figures_of,
    require_known,
    rigid_findings,
    support_findings,
)
from trueloop.nc.program.program import Program
from trueloop.surface.compensation.program import CorrectedProgram, Steps, corrected_program
from trueloop.surface.compensation.shift import CorrectedSurface, Displacement, MovedFace, SurfaceJob, corrected_surface
from trueloop.surface.deviations.alignment import Alignment
from trueloop.surface.deviations.deviations import SurfaceDeviations, inside_trim, surface_deviations
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.on_face import NextFace, OnFace, Trim, on_face
from trueloop.surface.options import SurfaceOptions
from trueloop.surface.pattern.field import FaceField, FaceParts, fields_of
from trueloop.surface.pattern.pattern import LEAST_PARTS, PartMaps, Pattern, part_maps, parts_needed, pattern_of
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.separate import (
    OutlyingPoint,
    Separation,
    averaged_over_cells,
    outlying_point,
    separate,
)
from trueloop.surface.separation.spline_surface import Places, SplineSurface, places_of, same_places
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class WorstTouch:
    """A part's worst touch for people: `name` and `place` of the touch that `found` is about."""

    name: str
    found: OutlyingPoint
    place: Place

    @property
    def words(self) -> str:
        """Describes the touch, how far off it is, and how probable that is by chance."""
        off_um = self.found.off_mm * UM_PER_MM
        return f"{self.name} lies {off_um:+.1f} µm off what the other touches tell (p {self.found.p_value:.2g})"


def worst_touch(points: MeasuredPoints, deviations: SurfaceDeviations, apart: Separation) -> WorstTouch:
    """Returns the worst touch of a part that was taken apart point by point, or cell by cell."""
    found = outlying_point(apart)
    there = np.flatnonzero(deviations.measured)
    if len(there) != len(apart.random_mm):
        x, y, z = apart.places.points_mm[found.index]
        return WorstTouch(
            f"the cell at x {x:.3f}, y {y:.3f}, z {z:.3f} mm of {points.name!r}", found, Place(points.file)
        )
    index = int(there[found.index])
    at = ""
    if points.shape is not None:
        row, column = divmod(index, points.shape[1])
        at = f" (row {row + 1}, column {column + 1})"
    number = points.number_in_file(index + 1)
    return WorstTouch(f"point {number}{at} of {points.name!r}", found, points.place(index + 1))


def touch_findings(worst: WorstTouch, confidence: float) -> Iterator[Finding]:
    """Yields a warning where the worst touch is worse than chance makes it."""
    if worst.found.p_value < 1.0 - confidence:
        hint = "measure it again, or leave it out: it bends the part's surface around it"
        yield Finding(
            Severity.WARNING, Code.SRF_OUTLIER, worst.words, hint, worst.place, values={"p_value": worst.found.p_value}
        )


@dataclass(frozen=True)
class Work:
    """The place where parts are computed (`run_batch`); `progress` is called with it: "deviations: 3 of 10 parts"."""

    workers: int = 1
    scheduler: str | None = None
    progress: Callable[[str], object] = str

    def done(self, work: Callable[[Item], Result], items: Sequence[Item], what: str) -> Iterator[Result]:
        """Results in the order of the items."""
        results = run_batch(work, items, workers=self.workers, scheduler=self.scheduler)
        for k in range(len(items)):
            self.progress(f"{what}: {k} of {len(items)} parts")
            yield next(results)


HERE: Final = Work()


@dataclass(frozen=True, eq=False)
class Part:
    """One part: its deviations, their deterministic and random parts, and its worst touch.

    `permutation_p`: of the test for spatial randomness by shuffling, made where the part is worked off.
    """

    deviations: SurfaceDeviations
    separation: Separation
    worst: WorstTouch
    permutation_p: float

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Returns the findings on its points and on their residuals."""
        return (*self.deviations.findings, *self.separation.findings)


@dataclass(frozen=True, eq=False)
class SurfaceModel:
    """All parts, their pattern, and how many parts the wanted uncertainty needs; `figures` are of what is `on_face`,
    `left_out` reports parts that are outlying beyond doubt. `face` is its number, where a job names several.
    """

    surface: Surface
    options: SurfaceOptions
    parts: tuple[Part, ...]
    pattern: Pattern
    parts_needed: int
    figures: SurfaceFigures
    on_face: OnFace
    left_out: tuple[Finding, ...] = ()
    face: int | None = None

    @property
    def of_face(self) -> str:
        """Returns "face 3: " where a job names several faces, else nothing."""
        return "" if self.face is None else f"face {self.face}: "

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Returns the findings in the parts and between them."""
        if self.face is None:
            return self.own_findings
        named = f"face {self.face}:"
        return tuple(
            one if named in one.message else replace(one, message=f"{self.of_face}{one.message}")
            for one in self.own_findings
        )

    @property
    def own_findings(self) -> tuple[Finding, ...]:
        """Returns the findings without the number of the face."""
        own = [finding for part in self.parts for finding in part.findings]
        names = [part.deviations.name for part in self.parts]
        rigid = () if self.options.best_fit else rigid_findings(self.figures, names, self.options.setup_mm)
        assumed = assumed_findings(self.pattern)
        return (*support_findings(self.figures), *assumed, *rigid, *own, *self.left_out, *self.pattern.findings)


def maps_of(model: SurfaceModel) -> list[tuple[PartMaps, Array]]:
    """Returns the maps of every part of the model, with the outward normals at its places."""
    (u0, u1), (v0, v1) = model.surface.domain
    found = []
    for part in model.parts:
        apart = part.separation
        normal = model.surface.normal(u0 + (u1 - u0) * apart.places.u, v0 + (v1 - v0) * apart.places.v)
        found.append((part_maps(model.pattern, apart, part.deviations.name, model.options.weight), normal))
    return found


@dataclass(frozen=True, eq=False)
class SurfaceCorrection:
    """The corrected surface, and the corrected program where one was given; `further` faces that it cuts, without it.

    `in_force_mm`: how far the correction that had cut the measured parts moves the surface at most, 0: none had.
    """

    model: SurfaceModel
    surface: CorrectedSurface
    program: CorrectedProgram | None
    in_force_mm: float = 0.0
    further: tuple["SurfaceCorrection", ...] = ()

    @property
    def faces(self) -> tuple["SurfaceCorrection", ...]:
        """Returns the corrections of all faces."""
        return (self, *self.further)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Returns the findings of the patterns and of the program."""
        models = [face.model for face in self.faces]
        of_all = [one for one in models[0].own_findings if all(one in model.own_findings for model in models[1:])]
        of_each = [
            named
            for model in models
            for own, named in zip(model.own_findings, model.findings, strict=True)
            if own not in of_all
        ]
        return (*of_all, *of_each, *(() if self.program is None else self.program.findings))


def deviations_of(
    surface: Surface,
    parts: Sequence[MeasuredPoints],
    options: SurfaceOptions,
    *,
    trim: Trim | None = None,
    fits: Sequence[Alignment] = (),
    work: Work = HERE,
) -> Iterator[SurfaceDeviations]:
    """Deviations of every part, one after the other.

    fits: how each part was fitted by all its faces, where it was measured on several. trim: which places (u, v) of the
    surface are cut away; the CAD kernel, which knows, stays in this process.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> given = replace(job.inputs, parts=job.inputs.parts[:3])
    >>> for part in trueloop.deviations_of(given.surface, given.parts, given.options):
    ...     print(f"{part.name}: {1e3 * part.error_mm.std():.1f} µm")
    S01: 4.3 µm
    S02: 4.3 µm
    S03: 4.2 µm
    """
    of_parts = fits or (None,) * len(parts)
    tasks = [_Task(surface, points, options, fit) for points, fit in zip(parts, of_parts, strict=True)]
    for points, deviations in zip(parts, work.done(_deviations, tasks, "deviations"), strict=True):
        yield deviations if trim is None else inside_trim(points, deviations, trim)


def model_of(
    surface: Surface,
    parts: Sequence[MeasuredPoints],
    options: SurfaceOptions,
    *,
    trim: Trim | None = None,
    fits: Sequence[Alignment] = (),
    work: Work = HERE,
) -> list[Part]:
    """Takes every part's deviations apart. Parts measured at the same places of a grid share their neighbourhood.

    trim, fits: as in `deviations_of`.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> given = replace(job.inputs, parts=job.inputs.parts[:3])
    >>> for part in trueloop.model_of(given.surface, given.parts, given.options):
    ...     print(f"{part.separation.chosen.size}, random {1e3 * part.separation.sigma_mm:.1f} µm")
    9 × 9, degree 3, random 2.1 µm
    9 × 9, degree 3, random 2.2 µm
    9 × 9, degree 3, random 2.1 µm
    """
    found = list(deviations_of(surface, parts, options, trim=trim, fits=fits, work=work))
    placed = [_placed(surface, points, deviations, options) for points, deviations in zip(parts, found, strict=True)]
    shared = same_places([places for places, _ in placed])
    near = [Neighbourhood(places, options.exponent) for places in dict.fromkeys(shared)]
    of = {id(n.places): n for n in near}
    tasks = [
        _Apart(of[id(places)], errors, options, points.name, points.file)
        for places, (_, errors), points in zip(shared, placed, parts, strict=True)
    ]
    apart = work.done(_separation, tasks, "what repeats")
    # What comes back from another process has places of its own: those of this one are put back, to be shared again.
    return [
        _part(points, deviations, replace(separation, near=task.near), permutation_p, options)
        for points, deviations, (separation, permutation_p), task in zip(parts, found, apart, tasks, strict=True)
    ]


def _part(
    points: MeasuredPoints,
    deviations: SurfaceDeviations,
    separation: Separation,
    permutation_p: float,
    options: SurfaceOptions,
) -> Part:
    worst = worst_touch(points, deviations, separation)
    findings = (*separation.findings, *touch_findings(worst, options.confidence))
    return Part(deviations, replace(separation, findings=findings), worst, permutation_p)


def pattern_model(
    surface: Surface,
    parts: Sequence[Part],
    options: SurfaceOptions,
    *,
    trim: Trim | None = None,
    left_out: tuple[Finding, ...] = (),
    field: FaceField | None = None,
    face: int | None = None,
) -> SurfaceModel:
    """Returns the machining pattern of the parts that are not excluded. Raises SRF-PARTS for none, and for fewer than
    three whose location counts: that of one part is as much its set-up's.

    trim: which places (u, v) of the surface are cut away, as in `deviations_of`. left_out: reports of excluded parts.
    field: the pattern's, where the job names several faces.
    """
    kept = kept_parts(parts, options)
    names = [part.deviations.name for part in kept]
    apart = [part.separation for part in kept]
    if field is None and len(kept) < LEAST_PARTS:
        (field,) = few_parts_field([FaceParts(surface, apart)], names, options)
    pattern = pattern_of(apart, names, confidence=options.confidence, field=field)
    there, needed = on_face(surface, trim), parts_needed(pattern, options.target_mm)
    return SurfaceModel(
        surface=surface,
        options=options,
        parts=tuple(kept),
        pattern=pattern,
        parts_needed=needed,
        figures=figures_of(surface, pattern, there),
        on_face=there,
        left_out=left_out,
        face=face,
    )


def kept_parts(parts: Sequence[Part], options: SurfaceOptions) -> list[Part]:
    """Returns the parts that are not excluded."""
    return [part for part in parts if part.deviations.name not in options.exclude]


def few_parts_field(faces: Sequence[FaceParts], names: Sequence[str], options: SurfaceOptions) -> list[FaceField]:
    """Returns the field on every face; of fewer than three parts, where form alone counts. Raises SRF-PARTS."""
    few = len(names) < LEAST_PARTS
    if few:
        require_form_alone(names, options)
    return fields_of(faces, options.own_mm, seen=not few)


def require_form_alone(names: Sequence[str], options: SurfaceOptions) -> None:
    """Raises SRF-PARTS for no part, or few by their datums: how each was set up shows beside others only."""
    if names and options.best_fit:
        return
    raise Code.SRF_PARTS.refusal(
        f"{len(names)} parts ({', '.join(map(repr, names)) or 'none'}) make no pattern with location and orientation; "
        f"{LEAST_PARTS} are the least, 10 were used in the published experiment",
        hint='gauging.alignment = "best-fit" corrects form alone, by one part too; else measure more parts cut with '
        "the given program, none with a corrected one: `trueloop surface add` keeps each in a store, and a pattern "
        "is made of all in it",
    )


@dataclass(frozen=True, eq=False)
class FaceToCorrect:
    """A further face that the program cuts: its model, which of its places are cut away, and, as `correct` has it, what
    is in force.
    """

    model: SurfaceModel
    trim: Trim | None
    in_force: Sequence[SplineSurface] = ()


def correct(
    model: SurfaceModel,
    program: Program | None = None,
    job: SurfaceJob | None = None,
    record_id: str = "",
    *,
    beside: Sequence[NextFace] = (),
    in_force: Sequence[SplineSurface] = (),
    trim: Trim | None = None,
    further: Sequence[FaceToCorrect] = (),
) -> SurfaceCorrection:
    """Returns the surface corrected by −w times the pattern, and the program that cuts it.

    in_force: displacements that had been taken off when the measured parts were cut; they stay taken off. further:
    faces of the part that the program cuts too; `trim` says then where this one ends.

    Raises SRF-PARTS for a pattern that the parts do not determine, CMP-SLOPE for a step towards one of the faces
    `beside` it that the program cuts on.
    """
    options, own = model.options, _corrected_face(model, in_force)
    others = tuple(_corrected_face(face.model, face.in_force) for face in further)
    if program is None or job is None:
        return replace(own, further=others)
    written = corrected_program(
        program,
        model.surface,
        own.surface.surface,
        job,
        record_id,
        steps=Steps(tuple(beside), options.limits),
        trim=trim if further else None,
        further=[
            MovedFace(face.model.surface, done.surface.surface, face.trim, face.model.face)
            for face, done in zip(further, others, strict=True)
        ],
        number=model.face,
    )
    return replace(own, program=written, further=others)


def _corrected_face(model: SurfaceModel, in_force: Sequence[SplineSurface]) -> SurfaceCorrection:
    options, before = model.options, Displacement(tuple(in_force))
    require_known(model.figures, model.pattern, model.on_face, options.best_fit)
    corrected = corrected_surface(
        model.surface,
        Displacement((*before.terms, weighted(model))),
        tolerance_mm=options.tolerance_mm,
        limits=options.limits,
        there=model.on_face,
    )
    return SurfaceCorrection(model, corrected, None, before.largest_mm(model.on_face) if in_force else 0.0)


def weighted(model: SurfaceModel) -> SplineSurface:
    """Returns w times the pattern: what its correction takes off along the normal, mm."""
    mean = model.pattern.mean
    return SplineSurface(mean.size, model.options.weight * mean.coefficients_mm)


@dataclass(frozen=True, eq=False)
class _Task:
    surface: Surface
    points: MeasuredPoints
    options: SurfaceOptions
    fit: Alignment | None


@dataclass(frozen=True, eq=False)
class _Apart:
    near: Neighbourhood
    errors_mm: Array
    options: SurfaceOptions
    name: str
    file: str | None


def _deviations(task: _Task) -> SurfaceDeviations:
    options = task.options
    return surface_deviations(
        task.surface,
        task.points,
        fit=options.best_fit if task.fit is None else task.fit,
        farthest_mm=options.farthest_mm,
        setup_mm=options.setup_mm,
    )


def _placed(
    surface: Surface, points: MeasuredPoints, deviations: SurfaceDeviations, options: SurfaceOptions
) -> tuple[Places, Array]:
    with in_file(points.file):
        if options.cells is not None:
            return averaged_over_cells(surface, deviations, options.cells)
        return places_of(surface, deviations)


def _separation(task: _Apart) -> tuple[Separation, float]:
    """Returns a part taken apart, and the test by shuffling: the longest step, so the workers make it too."""
    with in_file(task.file):
        apart = separate(
            task.near.places,
            task.errors_mm,
            near=task.near,
            confidence=task.options.confidence,
            criterion=task.options.criterion,
            name=task.name,
        )
    findings = tuple(finding.in_file(task.file) for finding in apart.findings)
    return replace(apart, findings=findings), apart.permutation_p
