"""Measured parts to the correction of their surface and the record of it: refused where it must not be applied."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from datetime import datetime

from trueloop import __version__
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import PartType
from trueloop.domain.program import Program as RecordedProgram
from trueloop.domain.record import Product, Record, record_id, sha256_of
from trueloop.domain.tool import Tool
from trueloop.errors import Finding
from trueloop.geometry.surface import Surface
from trueloop.loops.misuse import refuse_misuse
from trueloop.loops.surface.figures import check_support, headline, support_record
from trueloop.loops.surface.over_parts import without_outliers
from trueloop.loops.surface.scatter import check_surface_scatter
from trueloop.loops.surface.surface import (
    HERE,
    SurfaceCorrection,
    SurfaceModel,
    Work,
    correct,
    model_of,
    pattern_model,
)
from trueloop.nc.program.program import Program
from trueloop.nc.program.unit import recorded_program
from trueloop.surface.compensation.samples import SurfaceJob
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.on_face import Trim
from trueloop.surface.options import SurfaceOptions
from trueloop.units import UM_PER_MM


@dataclass(frozen=True, eq=False)
class SurfaceInputs:
    """Everything that a surface is corrected by. `sha256`: hashes of what was read, by name; `trim`: which points of
    the surface its face's trimming curves cut away; `program_sha256`: of the program that cut the parts, if known.
    The first `earlier` of the parts and inspections come from a store: their age is not held against them.
    `leave_out`: parts that are outlying beyond doubt do not count for the pattern.
    """

    name: str
    surface: Surface
    parts: tuple[MeasuredPoints, ...]
    options: SurfaceOptions
    program: Program | None
    cutter: SurfaceJob | None
    sha256: Mapping[str, str]
    trim: Trim | None = None
    inspections: tuple[Inspection, ...] = ()
    program_sha256: str | None = None
    earlier: int = 0
    leave_out: bool = False

    @property
    def measured_at(self) -> datetime | None:
        """When today's parts were measured, where that is known: the first of them."""
        today = self.inspections[self.earlier :]
        return min((one.measured_at for one in today if one.measured_at is not None), default=None)


@dataclass(frozen=True, eq=False)
class RecordedCorrection:
    """A correction, its record, which names nobody yet, and notes on what could not be checked."""

    correction: SurfaceCorrection
    record: Record
    notes: tuple[str, ...]


def correct_parts(inputs: SurfaceInputs, now: datetime, *, work: Work = HERE) -> RecordedCorrection:
    """The correction by measured parts: never by another program's, never by old ones.

    Raises SRF, NC and CMP errors for what cannot or must not be corrected.
    """
    limits = inputs.options.limits
    notes = refuse_misuse(inputs.program, inputs.program_sha256, inputs.measured_at, now, limits)
    parts = model_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=work)
    odd: tuple[Finding, ...] = ()
    if inputs.leave_out:
        chosen, odd = without_outliers(parts, inputs.options)
        inputs = replace(inputs, options=chosen)
    model = pattern_model(inputs.surface, parts, inputs.options, trim=inputs.trim)
    check_support(model.figures, inputs.options.least_supported)
    check_surface_scatter(model, limits)
    options = {**asdict(inputs.options), "cutter": asdict(inputs.cutter) if inputs.cutter else None}
    identity = record_id(dict(inputs.sha256), options)
    correction = correct(model, inputs.program, inputs.cutter, identity)
    record = Record(
        id=identity,
        made_at=now.isoformat(timespec="seconds"),
        made_by="",
        trueloop_version=__version__,
        inputs_sha256=dict(inputs.sha256),
        options=options | ({"unit": correction.program.unit} if correction.program else {}),
        model=_model_record(model),
        decision=_decision(correction),
        changes=correction.program.changes if correction.program else [],
        product=Product.SURFACE,
        edits=len(correction.program.changes) if correction.program else 0,
        part_type=PartType(inputs.name),
        tool=_tool(inputs),
        program=_program(inputs, correction),
        inspections=inputs.inspections,
    )
    return RecordedCorrection(correction, record, (*notes, *map(str, odd)))


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


def _model_record(model: SurfaceModel) -> dict[str, object]:
    """The pattern with its control values, and what the tests said of every part."""
    pattern = model.pattern
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
        "findings": [f"{finding.code}: {finding.message}" for finding in model.findings],
    }


def _decision(correction: SurfaceCorrection) -> list[str]:
    pattern, figures = correction.model.pattern, correction.model.figures
    words = [
        f"the pattern of {pattern.parts} parts is known to ± {figures.uncertainty_mm * UM_PER_MM:.2f} µm (95 %, mean "
        f"over the face)",
        *([headline(figures)] if headline(figures) else []),
        f"the surface is moved by up to {correction.surface.largest_shift_mm * UM_PER_MM:.2f} µm, refitted to "
        f"{correction.surface.worst_mm * UM_PER_MM:.3f} µm",
    ]
    if correction.program is not None:
        words.append(
            f"{correction.program.cutting_moves} moves of the program follow, with {correction.program.new_blocks} "
            f"blocks put in"
        )
    return words
