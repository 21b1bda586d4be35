"""The process-intermittent loop: touches after the semi-finish cut to a corrected finish program.

This module only strings pieces together: match the program with the profile, fit error curves to the touches, turn
them into a compensated contour, check it, write it into the program, read that back.
"""

from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from trueloop import __version__
from trueloop.arrays import Array
from trueloop.domain.record import ChangedWord, Component, Record, record_id
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.loops.misuse import refuse_misuse
from trueloop.loops.turned.commanded import Commanded, Run, commanded
from trueloop.loops.turned.composed import Surface, check_composed, comp_mtg_at, model_u_mm, surface_of
from trueloop.loops.turned.correction import Composed, Correction, Inputs, Options
from trueloop.loops.turned.part_on_machine import InMachine, placed
from trueloop.loops.turned.shifts import Shifts, corrected_shifts, whole_mm
from trueloop.loops.turned.written import Driven, Writing, write_contour
from trueloop.loops.turned.written_offsets import write_offsets
from trueloop.nc.program.unit import unit_of_path
from trueloop.turned.compensation.contour import centre_pieces, shifted_contour
from trueloop.turned.compensation.decide import Decision, decide
from trueloop.turned.compensation.displaced import along_normal, constant, displaced_pieces, then
from trueloop.turned.compensation.limits import check_limits, check_nose, check_scatter
from trueloop.turned.compensation.prediction import Prediction, predict
from trueloop.turned.compensation.shift import weighted_sum
from trueloop.turned.compensation.table import correction_table
from trueloop.turned.compensation.targets import Fitting
from trueloop.turned.error_curve.budget import Budget, joined
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.chain import TangentPolicy
from trueloop.turned.fit.options import BadTouches, FitOptions
from trueloop.turned.program.wear import WearOffset, offset_number, wear_offset
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.plausibility import check_loop_sign


def compensate(inputs: Inputs, now: datetime | None = None) -> Correction:
    """One correction. Raises TCH, FIT, NC and CMP errors for what cannot or must not be corrected."""
    now = now or datetime.now(UTC)
    notes = refuse_misuse(inputs.program, inputs.program_sha256, inputs.measured_at, now, inputs.options.limits)
    if inputs.finish_touches is not None:
        check_loop_sign(inputs.touches, inputs.finish_touches)
    options, profile, nose = inputs.options, inputs.profile, inputs.nose_radius_mm
    run = Run(inputs.parameters, inputs.execute_deleted_blocks, inputs.lines)
    told = commanded(inputs.program, inputs.semifinish, profile, nose, inputs.allowance_mm, run)
    machine = None if inputs.machine is None else placed(inputs.machine, told)
    surface = _surface(inputs, machine)
    touches = surface.touches
    process = replace(touches, error_mm=touches.error_mm - surface.cut_in_mm - told.measured_at(touches))
    model = fit_profile(profile, process, _fit_options(options), inputs.nose)
    check_scatter(model.scatter_mm, options.limits, model.farthest_words)
    decision = _decision(model, told, options, options.by if machine is None else "contour")
    shifts = corrected_shifts(profile, model, decision, told, options.weight, options.errors_follow)
    moved = whole = constant(whole_mm(decision))
    before = centre_pieces(profile, shifted_contour(profile, told.finish, nose))
    after = centre_pieces(profile, shifted_contour(profile, shifts.contour, nose))
    check_nose(after)
    check_limits(after, shifts.correction, options.limits)
    if machine is not None:
        moved = then(whole, machine.comp_mtg_mm)
        check_composed(after, shifts.correction, (machine.comp_mtg_mm, moved), options.limits)
    after = displaced_pieces(after, moved)
    ways, driven = (before, after), None
    if told.match.on_contour:  # written is the contour itself: the control keeps the nose off it
        old, new = (centre_pieces(profile, shifted_contour(profile, s, 0.0)) for s in (told.finish, shifts.contour))
        ways, driven = (old, displaced_pieces(new, moved)), Driven(nose, after)
    record = record_id(dict(inputs.inputs_sha256), _as_record(options, run, machine))
    fitting = Fitting(options.chord_tolerance_mm, options.arcs, lines=machine is not None)
    writing = Writing(inputs.program, told, run, record, fitting, machine.part.mark if machine is not None else "")
    wear, more = _wear(writing, decision, options)
    notes += more
    offsets, more = (None, _of_machine(machine)) if machine else _offset_variant(writing, decision, options, wear)
    notes += more
    if decision.by_offset:
        source, changed = offsets or (inputs.program.source, [])
    else:
        source, changed, more = write_contour(writing, profile, touches, *ways, driven)
        notes += more
    prediction = _prediction(touches, model, decision, shifts, options.weight)
    composed = None
    if machine is not None:
        composed = _composed(machine, surface, told, prediction, nose)
        prediction = replace(prediction, budget=prediction.budget.with_more(model_u_mm(machine, touches, nose)))
    return Correction(
        part=inputs.part,
        profile=profile,
        nose_radius_mm=nose,
        touches=touches,
        options=options,
        model=model,
        decision=decision,
        commanded_shift=told.finish,
        corrected_shift=tuple(
            weighted_sum(((1.0, shift), (1.0, along_normal(feature, nose, moved))))
            for feature, shift in zip(profile.features, shifts.contour, strict=True)
        ),
        by_offset=shifts.by_offset,
        unasked_u_mm=shifts.unasked_u_mm,
        commanded=before,
        corrected=after,
        prediction=prediction,
        source_program=inputs.program.source,
        corrected_program=source,
        offsets_program=offsets[0] if offsets is not None else None,
        dialect=inputs.program.dialect.name,
        source_name=Path(inputs.program.file or "program.nc").name,
        wear=wear,
        table=correction_table(before, after, decision.offset_mm if decision.by_offset else (0.0, 0.0)),
        record=Record(
            id=record,
            made_at=now.isoformat(timespec="seconds"),
            made_by=inputs.made_by,
            trueloop_version=__version__,
            inputs_sha256=dict(inputs.inputs_sha256),
            options=_as_record(options, run, machine) | {"unit": unit_of_path(inputs.program.unit, told.path)},
            model=_model_record(model),
            decision=[decision.x.words, decision.z.words, f"As a tool offset: {wear.words}."],
            changes=changed,
            components=_components(profile, touches, composed),
        ),
        notes=(*(one.words for one in model.suspects), *notes, *told.notes),
        composed=composed,
    )


def _surface(inputs: Inputs, machine: InMachine | None) -> Surface:
    """The touches, corrected by E(T_probing) where the part stands in a machine whose errors are known."""
    reported = inputs.touches
    if machine is None:
        return Surface(reported, reported.error_mm, np.zeros(len(reported.error_mm)))
    return surface_of(machine, reported, inputs.semifinish, inputs.nose_radius_mm, inputs.allowance_mm)


def _of_machine(machine: InMachine) -> list[str]:
    """What to know of a composed correction."""
    cut = machine.part
    where = "corrected by COMP_MTG(T_probing)" if cut.touched_on == "machine" else "taken as they are: by a CMM"
    return [
        f"The contour carries COMP_MTG of {cut.model.machine.name!r} at the finish cut's temperatures and COMP_PROC; "
        f"the touches were {where}; the touched surface was cut {cut.semifinish_cut}.",
        "There is no variant with tool offsets alone: it would leave the machine's error.",
    ]


def _composed(
    machine: InMachine, surface: Surface, told: Commanded, prediction: Prediction, nose_radius_mm: float
) -> Composed:
    """The components at the touches: COMP_PROC is what the prediction takes out of the process error."""
    touches = surface.touches
    process_mm = prediction.after_mm - (touches.error_mm - surface.cut_in_mm - told.measured_at(touches))
    comp_mtg_mm = comp_mtg_at(machine, surface.touches, process_mm, nose_radius_mm)
    return Composed(surface.reported_mm, surface.cut_in_mm, comp_mtg_mm, process_mm)


def _components(profile: Profile, touches: ErrorVectors, composed: Composed | None) -> list[Component]:
    if composed is None:
        return []
    names = [profile.names[i] for i in touches.feature_index]
    pairs = zip(composed.comp_mtg_mm.tolist(), composed.comp_proc_mm.tolist(), strict=True)
    return [Component.of(name, point, *pair) for name, point, pair in zip(names, touches.point, pairs, strict=True)]


def _fit_options(options: Options) -> FitOptions:
    return FitOptions(
        tangent_policy=TangentPolicy(options.junctions),
        knot_every=options.knot_every,
        knot_every_on=options.knot_every_on,
        prescribed=options.prescribed,
        repeatability_mm=options.repeatability_mm,
        between_cuts=options.between_cuts,
        bad_touches=BadTouches(options.bad_touches),
    )


def _decision(model: ProfileErrorModel, told: Commanded, options: Options, by: str) -> Decision:
    vectors = model.vectors.chosen(np.flatnonzero(model.weight))
    floor_mm = float(np.max(vectors.standard_u_mm))
    return decide(
        vectors.error_mm,
        vectors.outward_normal,
        max(model.scatter_mm, floor_mm),
        model.degrees_of_freedom or float("inf"),
        told.resolution_mm,
        options.weight,
        by,
    )


def _wear(writing: Writing, decision: Decision, options: Options) -> tuple[WearOffset, list[str]]:
    """The offset as numbers to enter, of the tool that the job names, else that of the program's T word."""
    program, path, cut = writing.program, writing.told.path, writing.told.cuts[0].move
    own = offset_number(program, path, cut)
    tool = next((number for number in (options.tool, own) if number is not None), 1)
    notes = [] if options.by == "auto" else [f"The job wants the correction by {options.by}, whatever the test says."]
    if own is not None and own != tool:
        notes += [f"The job says tool {tool}; the finish pass in line {path.line[cut]} runs with offset {own}."]
    return wear_offset(program, path, cut, decision.offset_mm, tool, options.offset_is_diameter), notes


def _offset_variant(
    writing: Writing, decision: Decision, options: Options, wear: WearOffset
) -> tuple[tuple[bytes, list[ChangedWord]] | None, list[str]]:
    """The program with offsets alone. It may be left out, which a note says: the offset can be entered by hand."""
    try:
        variant = write_offsets(writing, decision.offset_mm, options.limits, wear.tool, options.offset_is_diameter)
    except TrueloopError as refused:
        if refused.code is not Code.NC_OFFSET and (decision.by_offset or refused.code is not Code.CMP_SIZE):
            raise
        note = f"There is no variant with tool offsets alone: {refused.message}."
        if decision.by_offset:
            note += f" Enter the offset at the control ({wear.words}) and run the program as it is, once."
        return None, [note]
    return variant, []


def _prediction(
    touches: ErrorVectors, model: ProfileErrorModel, decision: Decision, shifts: Shifts, weight: float
) -> Prediction:
    """What the correction that was chosen leaves: a curve where the contour moves, a constant where an offset does.

    The constant comes from all touches together, so that it is known better than a curve and has an uncertainty of its
    own. A touch left out as bad says nothing of the part: there, the error is what was fitted.
    """
    left_out_as_bad = model.weight == 0.0
    fitted = model.vectors.error_mm - model.residual_mm
    process = np.where(left_out_as_bad, fitted, model.vectors.error_mm)
    left_out = process - np.where(left_out_as_bad, 0.0, model.leave_one_out_mm)
    constant = -np.asarray(touches.outward_normal @ np.array(decision.offset_mm)) / weight
    leverage = decision.leverage(touches.outward_normal)
    without = process - (process - constant) / np.where(leverage < 1.0 - 1e-9, 1.0 - leverage, np.nan)
    by_offset = np.array(shifts.by_offset)[touches.feature_index]
    return predict(
        measured_mm=touches.error_mm,
        process_mm=process,
        fitted_mm=np.where(by_offset, constant, fitted),
        left_out_fitted_mm=np.where(by_offset, without, left_out),
        budget=joined([_budget(touches, model, shifts, leverage, i) for i in range(len(model.curves))]),
        weight=weight,
    )


def _budget(touches: ErrorVectors, model: ProfileErrorModel, shifts: Shifts, leverage: Array, index: int) -> Budget:
    """Uncertainties at the touches of one feature."""
    rows, curve = touches.of_feature(index), model.curves[index]
    s = touches.arc_length_mm[rows]
    if shifts.by_offset[index]:
        return curve.budget_of(np.sqrt(leverage[rows]) * curve.scatter_mm, s).with_more(shifts.unasked_u_mm[index](s))
    return curve.budget(s).with_more(shifts.unasked_u_mm[index](s))


def _as_record(options: Options, run: Run, machine: InMachine | None) -> dict[str, object]:
    of_machine = {} if machine is None else {"machine": machine.part.told()}
    return {**asdict(options), "parameters": dict(run.parameters), **of_machine}


def _model_record(model: ProfileErrorModel) -> dict[str, object]:
    """The error curves as polynomial pieces about their own beginnings, in mm [6517 Eq. 29-33], and what was noted."""
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
        "tangent_policy": str(model.options.tangent_policy),
        "scatter_mm": model.scatter_mm,
        "degrees_of_freedom": model.degrees_of_freedom,
        "curves": curves,
        "suspect_touches": [one.as_dict() for one in model.suspects],
        "notes": list(model.notes),
    }
