"""A correction as JSON: all that its page says, for machines. The shapes are those of `shapes.py`."""

import json
from collections.abc import Iterator

from trueloop.domain.record import CutWith
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.error_sources import FeatureSources, Share
from trueloop.loops.turned.outcome import between_cuts_words
from trueloop.report.program_diff import changed_lines, diff
from trueloop.report.shape import known
from trueloop.report.turned.characteristic_table import characteristics_as_dicts
from trueloop.report.turned.remembered import memory_as_dict
from trueloop.report.turned.shapes import (
    AxesShape,
    ByToolShape,
    CharacteristicShape,
    ComponentShape,
    CorrectionShape,
    CutWithShape,
    FeatureShape,
    JunctionShape,
    LeftShape,
    LineShape,
    MemoryShape,
    OffsetShape,
    ProgramShape,
    SourceShape,
    SuspectShape,
)
from trueloop.report.turned.summary import FeatureSummary, feature_summaries, header, headline, worst_of
from trueloop.report.turned.touch_table import by_tool_as_dict, touch_rows
from trueloop.statistics import rms
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.units import UM_PER_MM


def json_text(correction: Correction) -> str:
    """Returns the text of `report.json`."""
    return json.dumps(correction_as_dict(correction), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def correction_as_dict(correction: Correction) -> dict[str, object]:
    """A correction; numbers that are not known are None.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> trueloop.correction_as_dict(trueloop.compensate(job.inputs))["program_to_run"]
    'corrected.nc'
    """
    return _shape(correction).model_dump(mode="json")


def _shape(correction: Correction) -> CorrectionShape:
    model, record, decision = correction.model, correction.record, correction.decision
    remembered = memory_as_dict(correction)
    judged, by_tool = characteristics_as_dicts(correction.characteristics), by_tool_as_dict(correction)
    return CorrectionShape(
        header=header(record),
        part=correction.part,
        record_id=record.id,
        program_to_run=correction.name_to_run,
        carried_out_by=correction.recommended.value,
        cut_with=_cut_with(record.cut_with),
        headline=headline(correction),
        characteristics=[CharacteristicShape.model_validate(one) for one in judged],
        features=[
            _feature(summary, sources)
            for summary, sources in zip(feature_summaries(correction), correction.sources, strict=True)
        ],
        predicted_is="a prediction, not a measurement; expanded uncertainties hold 95 %",
        between_cuts=between_cuts_words(correction.options.between_cuts),
        components=[ComponentShape.from_values(component) for component in record.components],
        by_tool=None if by_tool is None else ByToolShape.model_validate(by_tool),
        tool_offset=OffsetShape.model_validate(
            {**correction.wear.as_dict(), "leaves": list(_left_by_offset(correction))}
        ),
        decision=AxesShape(x=decision.words[0], z=decision.words[1], readings="".join(decision.words[2:])),
        suspect_touches=[SuspectShape.model_validate(suspect.as_dict()) for suspect in model.suspects],
        notes=list(correction.notes),
        model_notes=list(model.notes),
        scatter_um=model.scatter_mm * UM_PER_MM,
        degrees_of_freedom=model.degrees_of_freedom,
        coverage_factor=coverage_factor(model.degrees_of_freedom or None),
        touches=touch_rows(correction),
        junctions=list(_junctions(correction)),
        programs=list(_programs(correction)),
        inputs_sha256=record.inputs_sha256,
        options=record.options,
        memory=None if remembered is None else MemoryShape.model_validate(remembered),
    )


def _cut_with(cut: CutWith | None) -> CutWithShape | None:
    if cut is None:
        return None
    offset_x_um, offset_z_um, wear_x_um, wear_z_um = (UM_PER_MM * one for one in (*cut.offset_mm, *cut.wear_mm))
    lengths = {"offset_x_um": offset_x_um, "offset_z_um": offset_z_um, "wear_x_um": wear_x_um, "wear_z_um": wear_z_um}
    return CutWithShape.from_values(cut, **lengths)


def _feature(of: FeatureSummary, sources: FeatureSources) -> FeatureShape:
    return FeatureShape.from_values(
        *(of, of.figures),
        predicted_worst_um=known(of.expected_um),
        predicted_expanded_u_um=known(of.expanded_u_um),
        sources=[_source(share) for share in sources.shares],
    )


def _source(of: Share) -> SourceShape:
    return SourceShape(
        source=of.source.value,
        mean_um=of.mean_mm * UM_PER_MM,
        expanded_u_um=coverage_factor() * of.standard_u_mm * UM_PER_MM,
        low_um=of.low_mm * UM_PER_MM,
        high_um=of.high_mm * UM_PER_MM,
    )


def _junctions(correction: Correction) -> Iterator[JunctionShape]:
    names = correction.profile.names
    for junction in correction.model.junctions:
        x_um, z_um = (length * UM_PER_MM for length in junction.displacement_mm)
        yield JunctionShape(
            before=None if junction.before is None else names[junction.before],
            after=None if junction.after is None else names[junction.after],
            kind=None if junction.kind is None else str(junction.kind),
            error_before_um=None if junction.error_before_mm is None else junction.error_before_mm * UM_PER_MM,
            error_after_um=None if junction.error_after_mm is None else junction.error_after_mm * UM_PER_MM,
            displacement_x_um=x_um,
            displacement_z_um=z_um,
            note=junction.note,
        )


def _programs(correction: Correction) -> Iterator[ProgramShape]:
    """Those that the page shows: the corrected one, and the variant that changes tool offsets alone."""
    source = correction.source_program
    corrected = None if correction.decision.by_offset else correction.corrected_program
    for name, program in (
        (correction.corrected_name, corrected),
        (correction.offsets_name, correction.offsets_program),
    ):
        if program is not None:
            gone, come = changed_lines(source, program)
            lines = [[LineShape.from_values(line) for line in hunk] for hunk in diff(source, program)]
            yield ProgramShape(name=name, lines_gone=gone, lines_new=come, diff=lines)


def _left_by_offset(correction: Correction) -> Iterator[LeftShape]:
    """Returns the error that the tool offset alone would leave at each feature's touches."""
    left_um = correction.left_by_offset_mm * UM_PER_MM
    for i, name in enumerate(correction.profile.names):
        left = left_um[correction.touches.of_feature(i)]
        if len(left):
            yield LeftShape(feature=name, rms_um=rms(left), worst_um=worst_of(left))
