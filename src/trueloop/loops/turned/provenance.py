"""The sources and tools of a correction, as its record keeps them; and its size in all, and how much of it was in
force when the measured part was cut.
"""

from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import Final

import numpy as np

from trueloop import __version__
from trueloop.domain import values
from trueloop.domain.characteristic import Judged
from trueloop.domain.life import Ran
from trueloop.domain.option import Limits
from trueloop.domain.proposal import ToolOffset
from trueloop.domain.record import Component, Correction, CutWith, Product, Record, record_id, sha256_of
from trueloop.domain.tool import Tool
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Junction, JunctionKind, Profile, Side
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.correction import Composed, FromMemory, Inputs
from trueloop.loops.turned.error_sources import FeatureSources, Share, Source
from trueloop.loops.turned.finished_parts import finished_parts
from trueloop.loops.turned.made_parts import history_sha256, is_used
from trueloop.loops.turned.part_on_machine import CompMtg, PartOnMachine, Standing
from trueloop.loops.turned.paths import Shifts, whole_mm
from trueloop.loops.turned.programs import Programs
from trueloop.machine.model import model as machine_model
from trueloop.machine.model.chain import Axis, AxisKind, Chain, ErrorName
from trueloop.machine.model.history import Lag
from trueloop.machine.model.term import Part, PositionBasis, Term
from trueloop.memory.made_part import Expected
from trueloop.nc.program.unit import recorded_program, unit_of_path
from trueloop.turned.compensation.decide import AxisDecision, Decision, UnmovedDecision
from trueloop.turned.compensation.displaced import CentrePiece, Constant, DisplacedFeature, ShiftedFeature, Then
from trueloop.turned.compensation.shift import Shift
from trueloop.turned.compensation.targets import CorrectionTable, Prediction
from trueloop.turned.error_curve.bad_touches import SuspectTouch
from trueloop.turned.error_curve.curve import Budget, ErrorCurve
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.error_curve.junctions import DisplacedJunction, Tangency
from trueloop.turned.fit.between_cuts import BetweenCuts, NextCut
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.fit_chains import ModelChoice
from trueloop.turned.fit.options import BadTouches, FitOptions
from trueloop.turned.fit.spline import EndConditions, Spline
from trueloop.turned.options import Options
from trueloop.turned.program.by_tool import ByTool, MovedFeature, ToolAnswer
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.wording import Um, listed, wording


def id_of(inputs: Inputs) -> str:
    """Returns the record's id, from the data read and the options alone: the program carries it."""
    return record_id(dict(inputs.inputs_sha256), _options(inputs))


def record_of(
    inputs: Inputs,
    matched: Commanded,
    model: ProfileErrorModel,
    decision: Decision,
    programs: Programs,
    touches: ErrorVectors,
    composed: Composed | None,
    by_tool: ByTool | None,
    characteristics: tuple[Judged, ...],
    memory: FromMemory | None,
    finished: tuple[ErrorVectors, ...],
) -> Record:
    """Returns the record of a correction, complete."""
    known = Tool() if inputs.edge is None else inputs.edge.tool
    tool = replace(known, number=inputs.options.tool, corner_radius_mm=inputs.nose_radius_mm)
    unit, program = unit_of_path(inputs.program.unit, matched.path), inputs.program
    return Record(
        id=id_of(inputs),
        made_at=inputs.made_at.isoformat(timespec="seconds"),
        made_by=inputs.made_by,
        trueloop_version=__version__,
        inputs_sha256=dict(inputs.inputs_sha256),
        options=_options(inputs) | {"unit": unit},
        model=_model(model) | _memory(memory) | finished_parts(finished, inputs.profile),
        decision=[
            *decision.words,
            *(() if inputs.no_offset or inputs.machine is not None else (_offset_words(decision, programs),)),
            *(() if memory is None else memory.words(inputs.profile)),
            *(
                ()
                if by_tool is None
                else (_by_tool_words(decision, by_tool), by_tool.beyond_words, by_tool.moved_words)
            ),
        ],
        changes=programs.changes,
        components=_components(inputs.profile, touches, composed),
        product=Product.TURNED,
        edits=len(programs.changes),
        part_type=inputs.part,
        machine=inputs.machine_tool if inputs.machine is None else inputs.machine.machine,
        tool=tool,
        edge=None if inputs.edge is None else replace(inputs.edge, tool=tool),
        edge_set_at=inputs.edge_set_at,
        program=recorded_program(program.file or "", program.dialect.name, sha256_of(program.source), unit),
        inspections=inputs.inspections,
        tool_offset=None
        if inputs.machine is not None or inputs.no_offset
        else _tool_offset(inputs, decision, programs),
        cut_with=inputs.in_force.cut_with if inputs.measured_finished else None,
        characteristics=characteristics,
    )


def _offset_words(decision: Decision, programs: Programs) -> str:
    if decision.by_offset:
        return wording("As a tool offset: {wear}.", wear=programs.wear.words)
    return wording("As a tool offset, instead of the corrected contour: {wear}.", wear=programs.wear.words)


def _by_tool_words(decision: Decision, by_tool: ByTool) -> str:
    if decision.by_offset:
        return f"{by_tool.words}."
    return wording("Instead of the corrected contour, not with it: {answer}.", answer=by_tool.words)


def _tool_offset(inputs: Inputs, decision: Decision, programs: Programs) -> ToolOffset:
    measured = inputs.inspections[-1].sha256 if inputs.inspections else ""
    return programs.wear.as_offset(decision.by_offset, measured, inputs.held)


def _options(inputs: Inputs) -> dict[str, object]:
    machine = {} if inputs.machine is None else {"machine": inputs.machine.as_record()}
    stated = {"weight": inputs.options.weight, **asdict(inputs.options), "parameters": dict(inputs.parameters)}
    del stated["straight"]  # follows from the data
    edge = {} if inputs.called is None else {"edge": inputs.called.words, "features": list(inputs.profile.names)}
    frame = inputs.setup
    setup = {} if frame is None else {"setup": asdict(frame) | {"z_of_program": frame.words}}
    cut = inputs.in_force.cut_with
    force = {"cut_with": asdict(cut)} if cut.corrected else {}
    return {**stated, **machine, **edge, **setup, **force, **_memory_options(inputs)}


def _memory_options(inputs: Inputs) -> dict[str, object]:
    """Returns how earlier parts take part, and which; nothing without; a finished series: by the one in force."""
    if is_used(inputs):
        return {"memory": asdict(inputs.memory) | {"history_sha256": history_sha256(inputs.history)}}
    goes_on = inputs.measured_finished and inputs.in_force.record is not None
    return {"memory": asdict(inputs.memory)} if goes_on else {}


def _memory(memory: FromMemory | None) -> dict[str, object]:
    """Returns the prediction from earlier parts, in mm and rad, so that it can be judged by the next inspection."""
    if memory is None or memory.expected is None:
        return {}
    expected = memory.expected
    return {
        "memory": {
            "applied": memory.applied,
            "contact_angle_rad": expected.contact_angle_rad.tolist(),
            "mean_mm": expected.mean_mm.tolist(),
            "memory_mm": expected.memory_mm.tolist(),
            "standard_u_mm": np.sqrt(np.diag(expected.covariance_mm2)).tolist(),
            "gain": expected.gain,
            "parts": expected.parts,
            "points": list(memory.points),
            "enough_touches": expected.enough_touches,
        }
    }


def _model(model: ProfileErrorModel) -> dict[str, object]:
    """Returns the curves as polynomial pieces about their own beginnings, mm [6517 Eq. 29-33], and the notes."""
    curves = [
        {
            "feature": curve.feature,
            "knot_every": curve.knot_every,
            "begins_mm": curve.pieces[0].tolist(),
            "coefficients_mm": curve.pieces[1].tolist(),
        }
        for curve in model.curves
    ]
    return {
        "tangent_policy": str(model.options.junctions),
        "scatter_mm": model.scatter_mm,
        "degrees_of_freedom": model.degrees_of_freedom,
        "curves": curves,
        "suspect_touches": [suspect.as_dict() for suspect in model.suspects],
        "notes": list(model.notes),
    }


def _components(profile: Profile, touches: ErrorVectors, composed: Composed | None) -> list[Component]:
    if composed is None:
        return []
    names = [profile.names[i] for i in touches.feature_index]
    pairs = zip(composed.comp_mtg_mm.tolist(), composed.comp_proc_mm.tolist(), strict=True)
    return [Component.of(name, point, *pair) for name, point, pair in zip(names, touches.point, pairs, strict=True)]


def cumulative_words(inputs: Inputs, matched: Commanded, decision: Decision, shifts: Shifts) -> Iterator[str]:
    """Describes the whole correction of a part that was cut with a correction in force; nothing where none was."""
    cut = inputs.in_force.cut_with
    if not cut.corrected:
        return
    whole = (
        _whole_offset_words(cut, decision) if decision.by_offset else _contour_words(inputs, matched, decision, shifts)
    )
    yield wording(
        "The measured part was cut with {what}; this correction takes its place and is the whole one: {whole}.",
        what=cut.words,
        whole=whole,
    )
    if inputs.machine is not None:
        yield wording("COMP_MTG of the machine comes on top of these: they are of the process, COMP_PROC.")
    if cut.wear_mm != (0.0, 0.0):
        x, z = (Um(value, "+.1f") for value in cut.wear_mm)
        yield wording(
            "X {x} (radius), Z {z} stand in the control's wear table and stay there: what is written or to be entered "
            "comes on top of them.",
            x=x,
            z=z,
        )


def _whole_offset_words(cut: CutWith, decision: Decision) -> str:
    whole = [Um(value, "+.1f") for value in decision.whole_offset_mm]
    before = [Um(value, "+.1f") for value in cut.offset_mm]
    of = wording("of which X {x}, Z {z} were in force", x=before[0], z=before[1])
    if cut.ran is Ran.CORRECTED:
        of = wording("in place of the contour that was in force")
    return wording("tool offset X {x} (radius), Z {z}, {of}", x=whole[0], z=whole[1], of=of)


def _contour_words(inputs: Inputs, matched: Commanded, decision: Decision, shifts: Shifts) -> str:
    """At the middle of every feature that was measured, along its normal."""
    kept = np.array(inputs.in_force.cut_with.offset_mm)
    offset = kept + np.array(whole_mm(decision))
    found = []
    for index in dict.fromkeys(inputs.touches.feature_index.tolist()):
        feature = inputs.profile.features[index]
        s = feature.length_mm / 2
        total = float(shifts.contour[index].value_mm(s) + feature.outward_normal(s) @ offset)
        before = float(feature.outward_normal(s) @ kept)
        before += float(matched.in_force[index].value_mm(s)) if matched.in_force else 0.0
        found.append(
            wording(
                "{feature} {total}, of which {before} were in force",
                feature=feature.name,
                total=Um(total, "+.1f"),
                before=Um(before, "+.1f"),
            )
        )
    return listed(found)


CODEC: Final = values.CODEC.with_more(
    *(Correction, Limits),
    *(Line, Arc, Curve, Junction, JunctionKind, Profile, Side, ErrorVectors, Seen, Options, BetweenCuts, EndConditions),
    *(ProfileErrorModel, FitOptions, TangentPolicy, BadTouches, ErrorCurve, Spline, SuspectTouch, DisplacedJunction),
    *(
        Tangency,
        ModelChoice,
        Decision,
        AxisDecision,
        UnmovedDecision,
        Prediction,
        Budget,
        WearOffset,
        CorrectionTable,
        turned.Composed,
    ),
    *(ByTool, MovedFeature, ToolAnswer, NextCut, FromMemory, Expected, FeatureSources, Share, Source),
    *(CentrePiece, ShiftedFeature, DisplacedFeature, Shift, Constant, Then, CompMtg, Standing, PartOnMachine),
    *(machine_model.MachineModel, Chain, Axis, AxisKind, Term, ErrorName, PositionBasis, Lag),
    TurnedCorrection=turned.Correction,
    MachineOfModel=machine_model.Machine,
    PartOfTerm=Part,
)


def enveloped(correction: turned.Correction) -> Correction[turned.Correction]:
    """Puts the correction in the envelope that all products share."""
    return Correction(correction.record, asdict(correction.options.limits), correction)
