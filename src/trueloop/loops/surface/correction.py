"""Measured parts to the correction of their surface and the record of it: refused where it must not be applied."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from typing import Any, Final

import numpy as np

from trueloop import __version__
from trueloop.domain import values
from trueloop.domain.inspection import Inspection
from trueloop.domain.option import Limits, check_scatter
from trueloop.domain.part import PartType
from trueloop.domain.record import GIVEN, Correction, CutWith, Product, Record, record_id, sha256_of
from trueloop.domain.record import Program as RecordedProgram
from trueloop.domain.tool import Tool
from trueloop.errors import Code, Finding, Place, Severity, Unseen
from trueloop.geometry.surface import Surface
from trueloop.loops.batch import refuse_misuse
from trueloop.loops.surface.figures import SurfaceFigures, check_support, headline, support_record
from trueloop.loops.surface.over_parts import without_outliers
from trueloop.loops.surface.surface import (
    HERE,
    FaceToCorrect,
    Part,
    SurfaceCorrection,
    SurfaceModel,
    Work,
    WorstTouch,
    correct,
    few_parts_field,
    kept_parts,
    model_of,
    pattern_model,
)
from trueloop.nc.program.program import Program
from trueloop.nc.program.unit import recorded_program
from trueloop.surface.compensation.program import CorrectedProgram
from trueloop.surface.compensation.shift import CorrectedSurface, SurfaceJob
from trueloop.surface.deviations.alignment import Alignment
from trueloop.surface.deviations.deviations import SurfaceDeviations, fit_of_faces
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.on_face import NextFace, OnFace, Trim
from trueloop.surface.options import SurfaceOptions
from trueloop.surface.pattern.field import FaceParts
from trueloop.surface.pattern.kriging import FieldProcess, Process
from trueloop.surface.pattern.pattern import Outlier, Pattern
from trueloop.surface.pattern.support import Support
from trueloop.surface.separation.moran import Normality, Null
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.separate import OutlyingPoint, Separation, Trial, scattering_part
from trueloop.surface.separation.spline_surface import Places, Size, SplineSurface
from trueloop.units import UM_PER_MM

MOSTLY: Final = 0.5
"""Share of the scatter's variance that all parts have alike, from which on it is the pattern and no scatter."""


def check_surface_scatter(model: SurfaceModel, limits: Limits) -> None:
    """Refuses parts that scatter by more than the limit, naming touch and part where one stands out (CMP-SCATTER).

    Raises SRF-SUPPORT where all parts have most of the scatter alike: the points are too far apart for the pattern.
    """
    pattern = model.pattern
    if pattern.sigma_mm > limits.scatter_mm and pattern.missed_mm**2 > MOSTLY * pattern.sigma_mm**2:
        raise Code.SRF_SUPPORT.refusal(
            f"the points are too far apart for the pattern: of {pattern.sigma_mm * UM_PER_MM:.1f} µm that touches lie "
            f"off what was fitted, {pattern.missed_mm * UM_PER_MM:.1f} µm are alike on all {pattern.parts} parts; "
            f"the limit is {limits.scatter_mm * UM_PER_MM:.1f} µm",
            hint="measure with points no farther apart than a quarter of the shortest wave",
            override="compensation.max_scatter_um in the job",
        )
    check_scatter(pattern.sigma_mm, limits, scatter_cause(model))


def scatter_cause(model: SurfaceModel) -> str:
    """Returns the part that scatters most, and the touch that is worst, with their probabilities."""
    unlikely = 1.0 - model.options.confidence
    part = scattering_part([part.separation for part in model.parts])
    touch = min((part.worst for part in model.parts), key=lambda worst: worst.found.p_value)
    causes = []
    if part.p_value < unlikely:
        own, others = part.sigma_mm * UM_PER_MM, part.others_mm * UM_PER_MM
        name = model.parts[part.index].deviations.name
        causes.append(f"{name!r} scatters by {own:.1f} µm, the others by {others:.1f} µm (p {part.p_value:.2g})")
    if touch.found.p_value < unlikely:
        causes.append(touch.words)
    return ", and ".join(causes) or f"all {len(model.parts)} parts scatter alike, and no touch stands out"


@dataclass(frozen=True, eq=False)
class SurfaceInputs:
    """Everything that a surface is corrected by. `sha256`: hashes of what was read, by name; `trim`: which points of
    the surface its face's trimming curves cut away; `beside`: the other faces of its model; `program_sha256`: of the
    program that cut the parts, if known. The first `earlier` of the parts and inspections come from a store: their age
    is not held against them. `leave_out`: parts that are outlying beyond doubt do not count for the pattern.
    `cut_with`: the correction in force when the parts were cut, and `in_force` what it takes off along the normal.
    `further`: other faces of the same parts that the job names, each with its own surface, points, trim and what is in
    force there; `face` is this one's number then, and `group` alike for faces that run on into each other.
    """

    name: str
    surface: Surface
    parts: tuple[MeasuredPoints, ...]
    options: SurfaceOptions
    program: Program | None
    cutter: SurfaceJob | None
    sha256: Mapping[str, str]
    trim: Trim | None = None
    beside: tuple[NextFace, ...] = ()
    inspections: tuple[Inspection, ...] = ()
    program_sha256: str | None = None
    earlier: int = 0
    leave_out: bool = True
    cut_with: CutWith = GIVEN
    in_force: tuple[SplineSurface, ...] = ()
    further: tuple["SurfaceInputs", ...] = ()
    face: int | None = None
    group: int = 0

    @property
    def faces(self) -> tuple["SurfaceInputs", ...]:
        """Returns the inputs of all faces."""
        return (self, *self.further)

    @property
    def measured_at(self) -> datetime | None:
        """Returns the time at which today's parts were measured, where that is known: the first of them."""
        today = self.inspections[self.earlier :]
        return min((inspection.measured_at for inspection in today if inspection.measured_at is not None), default=None)


@dataclass(frozen=True, eq=False)
class RecordedCorrection:
    """A correction, its record, which names nobody yet, and notes on what could not be checked."""

    correction: SurfaceCorrection
    record: Record
    notes: tuple[str, ...]


def correct_parts(inputs: SurfaceInputs, now: datetime, *, work: Work = HERE) -> RecordedCorrection:
    """Corrects by measured parts, never another program's or old ones. Raises SRF, NC and CMP errors."""
    limits = inputs.options.limits
    ran = None if inputs.cut_with.corrected else inputs.program_sha256
    notes = refuse_misuse(inputs.program, ran, inputs.measured_at, now, limits)
    model, *further = models = _models(inputs, work)
    inputs = replace(inputs, options=model.options)
    for face in models:
        check_support(face.figures, inputs.options.least_supported)
        check_surface_scatter(face, limits)
    options = {**asdict(inputs.options), "cutter": asdict(inputs.cutter) if inputs.cutter else None}
    if further:
        options |= {"faces": [face.face for face in models]}
    identity = record_id(dict(inputs.sha256), options)
    correction = correct(
        model,
        inputs.program,
        inputs.cutter,
        identity,
        beside=inputs.beside,
        in_force=inputs.in_force,
        trim=inputs.trim,
        further=[
            FaceToCorrect(face, given.trim, given.in_force) for face, given in zip(further, inputs.further, strict=True)
        ],
    )
    record = Record(
        id=identity,
        made_at=now.isoformat(timespec="seconds"),
        made_by="",
        trueloop_version=__version__,
        inputs_sha256=dict(inputs.sha256),
        options=options | ({"unit": correction.program.unit} if correction.program else {}),
        model=_model_record(correction, inputs),
        decision=_decision(correction, inputs.cut_with),
        changes=correction.program.changes if correction.program else [],
        product=Product.SURFACE,
        edits=len(correction.program.changes) if correction.program else 0,
        part_type=PartType(inputs.name),
        tool=_tool(inputs),
        program=_program(inputs, correction),
        inspections=inputs.inspections,
        cut_with=inputs.cut_with,
    )
    return RecordedCorrection(correction, record, tuple(notes))


def _models(inputs: SurfaceInputs, work: Work) -> list[SurfaceModel]:
    """Returns the model of every face. Several faces have one alignment a part, and one field over all."""
    faces, options = inputs.faces, inputs.options
    if not inputs.further:
        parts = model_of(inputs.surface, inputs.parts, options, trim=inputs.trim, work=work)
        return [pattern_of_inputs(inputs, parts)]
    fits = []
    if options.best_fit:
        of_parts = zip(*(face.parts for face in faces), strict=True)
        fits = [fit_of_faces([face.surface for face in faces], points, options.setup_mm) for points in of_parts]
    apart = [model_of(face.surface, face.parts, options, trim=face.trim, fits=fits, work=work) for face in faces]
    left_out = list[tuple[Finding, ...]]()
    for parts in apart:
        options, odd = without_outliers(parts, options) if inputs.leave_out else (options, ())
        left_out.append(odd)
    kept = [kept_parts(parts, options) for parts in apart]
    measured = [
        FaceParts(face.surface, [part.separation for part in parts], face.group)
        for face, parts in zip(faces, kept, strict=True)
    ]
    fields = few_parts_field(measured, [part.deviations.name for part in kept[0]], options)
    return [
        pattern_model(face.surface, parts, options, trim=face.trim, left_out=odd, field=field, face=face.face)
        for face, parts, odd, field in zip(faces, apart, left_out, fields, strict=True)
    ]


def pattern_of_inputs(inputs: SurfaceInputs, parts: Sequence[Part]) -> SurfaceModel:
    """Returns the pattern of the parts, less those that are outlying beyond doubt. Raises SRF-PARTS for too few."""
    options, odd = without_outliers(parts, inputs.options) if inputs.leave_out else (inputs.options, ())
    return pattern_model(inputs.surface, parts, options, trim=inputs.trim, left_out=odd)


def _tool(inputs: SurfaceInputs) -> Tool | None:
    if inputs.cutter is None:
        return None
    cutter = inputs.cutter.cutter
    return Tool(corner_radius_mm=cutter.corner_mm, radius_mm=cutter.radius_mm)


def _program(inputs: SurfaceInputs, correction: SurfaceCorrection) -> RecordedProgram | None:
    program = inputs.program
    if program is None or correction.program is None:
        return None
    return recorded_program(
        program.file or "", program.dialect.name, sha256_of(program.source), correction.program.unit
    )


def _model_record(correction: SurfaceCorrection, inputs: SurfaceInputs) -> dict[str, object]:
    """Returns the record of the pattern with its control values, and the tests' results on every part; of all faces."""
    first, *further = (
        {**_pattern_record(done), IN_FORCE: [_term(term) for term in given.in_force]}
        for done, given in zip(correction.faces, inputs.faces, strict=True)
    )
    return (
        first
        | {"findings": [f"{one.code}: {one.message}" for one in correction.findings]}
        | ({FURTHER: further} if further else {})
    )


def _pattern_record(correction: SurfaceCorrection) -> dict[str, object]:
    model, pattern = correction.model, correction.model.pattern
    return {
        "size": asdict(pattern.size),
        "control_size": asdict(pattern.mean.size),
        "control_um": (pattern.mean.coefficients_mm * UM_PER_MM).tolist(),
        "random_sigma_um": pattern.sigma_mm * UM_PER_MM,
        "not_followed_um": pattern.missed_mm * UM_PER_MM,
        "support": support_record(model.figures, pattern),
        "outlying": [odd.name for odd in pattern.outlying],
        "parts": [
            {
                "name": part.deviations.name,
                "alignment": part.deviations.alignment.kind,
                "left_with_datums": list(part.deviations.alignment.left),
                "size": asdict(part.separation.chosen.size),
                "moran_p": part.separation.chosen.moran_p,
                "lilliefors_p": part.separation.chosen.normality.lilliefors_p,
            }
            for part in model.parts
        ],
    } | ({} if model.face is None else {"face": model.face})


IN_FORCE: Final = "in_force"
"""Key of a record's model: the terms that earlier corrections take off, each with its `size` and `control_um`."""


FURTHER: Final = "further"
"""Key of a record's model: the patterns of the other faces that were corrected together."""


def faces_of(record: Record) -> list[object]:
    """Returns the numbers of the faces that a record corrects together; [None] for a single one."""
    model: Any = record.model
    return [one.get("face") for one in (model, *model.get(FURTHER, ()))]


def _term(term: SplineSurface) -> dict[str, object]:
    return {"size": asdict(term.size), "control_um": (term.coefficients_mm * UM_PER_MM).tolist()}


def displacements_of(record: Record, face: int = 0) -> tuple[SplineSurface, ...]:
    """Returns all that a surface's correction takes off along the normal, mm: earlier corrections and its own; of the
    face of that place, from 0, in the record.

    Raises LookupError, TypeError and ValueError for a record whose model is not a surface's.
    """

    def term(size: Any, control_um: Any, weight: float) -> SplineSurface:
        shape = Size(int(size["rows"]), int(size["columns"]), int(size["degree"]))
        values_mm = weight * np.array(control_um, float).reshape(shape.rows, shape.columns) / UM_PER_MM
        return SplineSurface(shape, values_mm)

    of_all: Any = record.model
    model = (of_all, *of_all.get(FURTHER, ()))[face]
    earlier = [term(one["size"], one["control_um"], 1.0) for one in model.get(IN_FORCE, ())]
    weight: Any = record.options["weight"]
    return *earlier, term(model["control_size"], model["control_um"], float(weight))


def _face_decision(face: SurfaceCorrection) -> list[str]:
    pattern, figures, of_face = face.model.pattern, face.model.figures, face.model.of_face
    return [
        f"{of_face}the pattern of {pattern.of_parts} is known to ± {figures.uncertainty_mm * UM_PER_MM:.2f} µm (95 %, "
        f"mean over the face)",
        *([of_face + headline(figures)] if headline(figures) else []),
        f"{of_face}the surface is moved by up to {face.surface.largest_shift_mm * UM_PER_MM:.2f} µm, refitted to "
        f"{face.surface.worst_mm * UM_PER_MM:.3f} µm",
    ]


def _decision(correction: SurfaceCorrection, cut_with: CutWith) -> list[str]:
    words = [word for face in correction.faces for word in _face_decision(face)]
    if cut_with.corrected:
        words.append(
            f"of which correction {cut_with.correction}, up to {correction.in_force_mm * UM_PER_MM:.2f} µm, was in "
            "force when the parts were cut"
        )
    if correction.program is not None:
        words.append(
            f"{correction.program.cutting_moves} moves of the program follow, with {correction.program.new_blocks} "
            f"blocks put in"
        )
    return words


CODEC: Final = values.CODEC.with_more(
    *(Correction, Limits, Finding, Severity, Unseen, Code, Place, Surface, SurfaceOptions, SurfaceDeviations),
    *(Alignment,),
    *(Separation, Trial, Neighbourhood, Places, SplineSurface, Size, Null, Normality, WorstTouch, OutlyingPoint),
    *(Pattern, Outlier, Support, Process, FieldProcess, OnFace, SurfaceFigures, SurfaceModel, SurfaceCorrection),
    *(CorrectedSurface, CorrectedProgram),
    PartOfSurface=Part,
)


def enveloped(done: RecordedCorrection) -> Correction[SurfaceCorrection]:
    """Puts the correction in the envelope that all products share."""
    return Correction(done.record, asdict(done.correction.model.options.limits), done.correction)
