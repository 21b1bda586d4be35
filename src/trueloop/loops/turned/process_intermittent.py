"""The process-intermittent loop: touches after the semi-finish cut to a corrected finish program.

One correction in order: match the programs with the profile, take the machine's errors out of the touches, fit error
curves to what is left, decide between contour and tool offset, move the contour, write it into the program and read
that back, predict what it leaves.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.inspection import Reading
from trueloop.domain.option import Limits, allowed_by, check_scatter
from trueloop.domain.record import MARKED
from trueloop.errors import Code, Place, in_file
from trueloop.geometry.profile import Profile
from trueloop.loops.batch import refuse_misuse
from trueloop.loops.turned.characteristics import Corrected
from trueloop.loops.turned.commanded import Commanded, commanded
from trueloop.loops.turned.correction import Composed, Correction, FromMemory, Inputs
from trueloop.loops.turned.error_sources import FeatureSources, MachineShare, error_sources
from trueloop.loops.turned.finished_parts import finished_series, next_finished
from trueloop.loops.turned.made_parts import remembering, semifinish_errors, today_of
from trueloop.loops.turned.outcome import expected_uncorrected_mm, prediction_at_touches
from trueloop.loops.turned.part_on_machine import (
    CutBefore,
    InMachine,
    PartOnMachine,
    Surface,
    Zero,
    comp_mtg_at,
    model_u_mm,
    of_process,
    placed,
    surface_of,
    zero_of,
)
from trueloop.loops.turned.paths import Paths, bends_lines, corrected_paths, corrected_shifts, cramped_bows
from trueloop.loops.turned.programs import ContourTools, contour_tools, not_in_force, require_in_force, write_programs
from trueloop.loops.turned.provenance import cumulative_words, id_of, record_of
from trueloop.loops.turned.written import Writing
from trueloop.memory.edge.predict import latest, remembered
from trueloop.memory.made_part import MadePart
from trueloop.turned.compensation.decide import Decision, decide, decide_unmoved
from trueloop.turned.compensation.shift import Shift
from trueloop.turned.compensation.targets import Fitting, Prediction, correction_table
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.prior.part_state import SeriesState
from trueloop.turned.fit.prior.remembered_fit import angles_along
from trueloop.turned.options import By
from trueloop.turned.program.by_tool import ByTool, answer_by_tool
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.readings.of_this_part import check_neighbours, neighbour_words
from trueloop.turned.readings.vectors import z_zero
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import check_loop_sign
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording


def compensate(inputs: Inputs, *, sources: bool = True) -> Correction:
    """Makes one correction. Raises TCH, FIT, GEO, NC, MCH and CMP errors for what cannot or must not be corrected.

    They name the file that the refused value was read from, where the value knows it. `sources`: with the share of
    every source in the errors, on which nothing else depends.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> correction = trueloop.compensate(job.inputs)
    >>> correction.name_to_run, len(correction.corrected_program.splitlines())
    ('corrected.nc', 59)
    >>> print(correction.wear.words)  # the tool offset that a constant correction would be
    tool 1: wear X −0.00469 (diameter), Z +0.00000 inch (X ± 0.00135, Z not determined by what was measured)
    >>> for error_mm in (correction.prediction.before_mm, correction.prediction.after_mm):
    ...     print(f"{1e3 * error_mm.max():.1f} µm")
    94.2 µm
    2.9 µm
    """
    with in_file(inputs.file):
        inputs.in_force.require_stated()
        inputs.in_force.require_held(inputs.held)
    # Refuses a program or touches that this correction is not for; what could not be checked, as notes
    with in_file(inputs.file):
        limits, sha256 = inputs.options.limits, inputs.program_sha256
        unchecked = refuse_misuse(inputs.program, sha256, inputs.measured_at, inputs.made_at, limits)
    if inputs.finish_touches is not None:
        with in_file(inputs.finish_touches.file):
            check_loop_sign(inputs.touches, inputs.finish_touches)
    with in_file(inputs.touches.file):
        return _corrected(inputs, unchecked, sources)


def _corrected(inputs: Inputs, unchecked: list[str], sources: bool) -> Correction:
    cut = inputs.in_force.cut_with
    matched, machine = _matched(inputs)
    inputs = _with_offset_in_force(inputs, matched)
    surface = _surface(inputs, machine)
    tools = contour_tools(inputs.program, matched, inputs.called is not None)
    own, model, memory, finished = _error_model(inputs, matched, surface)
    decision = _decision(inputs, model, matched, tools.by(_asked(inputs)))
    shifts = corrected_shifts(inputs.profile, model, decision, matched, inputs.options)
    paths = corrected_paths(inputs, matched, shifts, decision, machine)
    to_write = writing(inputs, matched, bends_lines(model))
    if cramped := cramped_bows(matched, model, paths, to_write.fitting):
        options = replace(inputs.options, straight=(*inputs.options.straight, *cramped))
        return _corrected(replace(inputs, options=options), [*unchecked, *cramped.values()], sources)
    programs = write_programs(inputs, to_write, decision, paths)
    given_up = _given_up_mm(inputs, matched, decision, surface.touches)
    prediction = prediction_at_touches(surface.touches, model, decision, shifts, inputs.options.weight, given_up)
    by_tool = _by_tool(inputs, matched, model, decision, paths, programs.wear, tools)
    if by_tool is None:
        programs = replace(programs, wear=replace(programs.wear, blocks=()))
    composed, of_machine = None, None
    if machine is not None:
        before_mm = _in_program_mm(inputs, matched, surface.touches)
        composed = _composed(machine, surface, model, prediction, nose_mm=inputs.nose_radius_mm, before_mm=before_mm)
        u_mm = model_u_mm(machine, surface.touches, inputs.nose_radius_mm)
        prediction = replace(prediction, budget=prediction.budget.with_more(u_mm))
        of_machine = MachineShare(-composed.comp_mtg_mm, u_mm)
    judged = Corrected(
        inputs=inputs,
        matched=matched,
        surface=surface,
        own=own,
        model=model,
        decision=decision,
        shifts=shifts,
        machine=machine,
    ).characteristics()
    shares: tuple[FeatureSources, ...] = ()
    if sources:
        earlier = _earlier(inputs, model, memory) if memory is not None and memory.applied else None
        shares = error_sources(model, inputs.options.between_cuts, earlier, of_machine)
    return Correction(
        part=inputs.part.name,
        profile=inputs.profile,
        nose_radius_mm=inputs.nose_radius_mm,
        touches=surface.touches,
        options=inputs.options,
        model=model,
        decision=decision,
        by_offset=shifts.by_offset,
        unasked=shifts.unasked,
        commanded=paths.commanded,
        corrected=paths.corrected,
        prediction=prediction,
        source_program=inputs.program.source,
        corrected_program=programs.corrected,
        offsets_program=programs.offsets,
        dialect=inputs.program.dialect.name,
        source_name=inputs.program.file_name,
        wear=programs.wear,
        table=correction_table(
            paths.commanded,
            paths.corrected,
            cut.still_to_do(decision.whole_offset_mm) if decision.by_offset else (0.0, 0.0),
        ),
        record=record_of(
            inputs, matched, model, decision, programs, surface.touches, composed, by_tool, judged, memory, finished
        ),
        notes=(
            *cumulative_words(inputs, matched, decision, shifts),
            *(suspect.words for suspect in model.suspects),
            *neighbour_words(*_beside_others(inputs, own)),
            *(() if memory is None else memory.words(inputs.profile)),
            *inputs.notes,
            *([inputs.no_offset] if inputs.no_offset else []),
            *unchecked,
            *tools.notes,
            *programs.notes,
            *matched.notes,
        ),
        composed=composed,
        characteristics=judged,
        by_tool=by_tool,
        memory=memory,
        in_force=matched.in_force,
        sources=shares,
    )


def _with_offset_in_force(inputs: Inputs, matched: Commanded) -> Inputs:
    """Returns inputs that let no offset be entered where none is in force; a job that wants one gets the program that
    shifts its contour. Raises OFS-TOOL where the control's programs cannot.
    """
    of = inputs.program, matched.path, matched.cuts[0].move
    left_out = not_in_force(*of)
    if inputs.options.by == "offset":
        if inputs.program.dialect.contour_shift in ("", "UPD"):
            require_in_force(*of)
        left_out = ""
    if matched.by_other and inputs.options.by != "contour":
        raise Code.OFS_TOOL.refusal(
            matched.by_other.removesuffix("."),
            hint="measure a surface that the finishing tool cut",
            place=Place(inputs.program.file),
            override='compensation.by = "contour" takes the errors of the other tool\'s cut out of the contour',
            values={"tool": float(inputs.options.tool or 0)},
        )
    return replace(inputs, no_offset=inputs.no_offset or left_out or matched.by_other)


def process_errors(inputs: Inputs) -> ErrorVectors:
    """Returns touches and readings without the shares of machine and programs. Raises NC, GEO and MCH errors."""
    matched, machine = _matched(inputs)
    return _of_process(inputs, matched, _surface(inputs, machine))


def series_known(inputs: Inputs) -> SeriesState | None:
    """Returns the finished parts' state for the next one; None: this part alone. Raises NC, GEO, MCH, FIT errors."""
    matched, machine = _matched(inputs)
    process = _of_process(inputs, matched, _surface(inputs, machine))
    return finished_series(inputs, matched, fit_profile(inputs.profile, process, inputs.options, inputs.nose)).known


def _matched(inputs: Inputs) -> tuple[Commanded, InMachine | None]:
    """Returns the programs matched with the profile, and the part as it stands in a machine whose errors are known."""
    matched = commanded(
        *(inputs.program, inputs.semifinish, inputs.profile, inputs.nose_radius_mm, inputs.allowance_mm, inputs.run),
        force=inputs.in_force,
    )
    machine = None if inputs.machine is None else placed(inputs.machine, matched)
    if machine is not None and inputs.in_force.composed:
        kept = of_process(machine, inputs.profile, matched.in_force, inputs.nose_radius_mm)
        matched = replace(matched, in_force=kept)
    return matched, machine


def _of_process(inputs: Inputs, matched: Commanded, surface: Surface) -> ErrorVectors:
    touches = surface.touches
    seen = tuple(
        observation.less(matched.measured_along(observation.feature_index, observation.arc_length_mm) + cut_in_mm)
        for observation, cut_in_mm in zip(touches.seen, surface.cut_in_seen_mm, strict=True)
    )
    error_mm = touches.error_mm - surface.cut_in_mm - matched.measured_at(touches)
    return replace(touches, error_mm=error_mm, seen=seen)


def _asked(inputs: Inputs) -> By:
    """Returns how to correct, where open. A contour in force is kept, unless an offset is wanted in its place."""
    if inputs.machine is not None or inputs.no_offset:
        return "contour"
    return "contour" if inputs.options.by == "auto" and inputs.in_force.program is not None else inputs.options.by


def _surface(inputs: Inputs, machine: InMachine | None) -> Surface:
    """Returns the touches, corrected by E(T_probing) where the part stands in a machine whose errors are known."""
    if machine is None:
        return Surface.plain(inputs.touches)
    return surface_of(machine, inputs.profile, inputs.touches, _cut_before(inputs, machine.part), inputs.zero)


def _cut_before(inputs: Inputs, part: PartOnMachine) -> CutBefore:
    before, force = inputs.semifinish, inputs.in_force
    carried = part.semifinish_cut == "uncompensated" and not force.composed
    carried = carried or (before is not None and bool(MARKED.search(before.source)))
    return CutBefore(inputs.nose_radius_mm, inputs.allowance_mm, carried)


def zero_in_machine(inputs: Inputs) -> Zero | None:
    """Returns the machine's errors where z counts from, if among these measurements. Raises NC, GEO and MCH errors."""
    _, machine = _matched(inputs)
    if machine is None:
        return None
    return zero_of(machine, inputs.profile, inputs.touches, _cut_before(inputs, machine.part))


def _error_model(
    inputs: Inputs, matched: Commanded, surface: Surface
) -> tuple[ProfileErrorModel, ProfileErrorModel, FromMemory | None, tuple[ErrorVectors, ...]]:
    """Returns the error curves of the touches alone, without the shares of machine and programs; those to correct by;
    memory's share of them; and the finished parts of the series, of which this is the last.
    """
    process, options = _of_process(inputs, matched, surface), inputs.options
    own = fit_profile(inputs.profile, process, options, inputs.nose)
    # A vague reading beside better ones counts by its weight; all of them vague are refused.
    read_sigma_mm = np.delete(own.touch_sigma_mm(own.vectors), z_zero(own.vectors))
    scatter_mm = min(own.scatter_mm, float(np.min(read_sigma_mm, initial=np.inf)))
    check_neighbours(*_beside_others(inputs, own))
    check_scatter(scatter_mm, options.limits, own.farthest_words)
    finished: tuple[ErrorVectors, ...] = ()
    if inputs.measured_finished:
        remembered, memory, finished = next_finished(inputs, matched, own)
    else:
        remembered, memory = remembering(inputs, own)
    model = own if remembered is None else fit_profile(inputs.profile, process, options, inputs.nose, remembered)
    return own, model, memory, finished


def _beside_others(inputs: Inputs, own: ProfileErrorModel) -> tuple[Profile, ErrorVectors, Sequence[Reading], Limits]:
    """Returns what readings are compared in with those beside them: the errors with weight, and what was read."""
    readings = [reading for inspection in inputs.inspections for reading in inspection.readings]
    return inputs.profile, own.vectors.chosen(np.flatnonzero(own.weight)), readings, inputs.options.limits


def _earlier(inputs: Inputs, model: ProfileErrorModel, memory: FromMemory) -> tuple[Sequence[MadePart], MadePart]:
    """Returns the edge's earlier parts that take part, and this one before its finish cut with its touches."""
    touches = semifinish_errors(model)
    used = [k for k, point in enumerate(touches.point) if point in memory.points]
    today = today_of(inputs, touches.chosen(used))
    return latest(remembered(inputs.history, inputs.memory), today.part_type), today


def _decision(inputs: Inputs, model: ProfileErrorModel, matched: Commanded, by: str) -> Decision:
    options = inputs.options
    error_mm, outward_normal, sigma_mm, places, correlated = _decided_on(model)
    contour = _along(matched.in_force, *places) if matched.in_force else None
    decided = decide(
        error_mm,
        outward_normal,
        sigma_mm,
        model.degrees_of_freedom or float("inf"),
        matched.resolution_mm,
        options.weight,
        by,
        any(curve.from_memory for curve in model.curves),
        correlated,
        inputs.in_force.cut_with.offset_mm,
        contour,
        cuts_zero=bool(len(z_zero(inputs.touches))),
        vague_mm=options.limits.scatter_mm,
        common_u_mm=options.between_cuts.common_difference_mm,
        known=by == "contour" and all(curve.from_memory for curve in model.curves),
    )
    best_mm, limit_mm = float(np.min(sigma_mm)), options.limits.scatter_mm
    if best_mm > limit_mm and decided.offset_is_enough and not decided.unit_covariance.any():
        raise Code.CMP_SCATTER.refusal(
            wording(
                "the best of {n} measurements is known to {best} (one standard deviation, along the normal), and "
                "together they determine no offset to {limit}: they deviate by no more than they scatter, and "
                "nothing would be corrected",
                n=len(sigma_mm),
                best=Um(best_mm),
                limit=Um(limit_mm),
            ),
            hint=wording(
                "measure with a better gauge or more often; state the gauge's own uncertainty where it is smaller"
            ),
            override=allowed_by("scatter_mm"),
            values={"scatter_um": UM_PER_MM * best_mm, "limit_um": UM_PER_MM * limit_mm},
        )
    unmoved = decide_unmoved(model, float(np.min(sigma_mm)), matched.resolution_mm, by)
    return replace(decided, unmoved=unmoved)


def _decided_on(
    model: ProfileErrorModel,
) -> tuple[Array, Array, Array, tuple[NDArray[np.intp], Array], tuple[NDArray[np.intp], Array]]:
    """Process errors (n,), normals (n, 2), standard deviations (n,), features and arc lengths (n,) of touches with
    weight, and of places along features that memory corrects; the positions and the correlation of touches that have
    some.

    Three touches of an arc that earlier parts tell say little of whether an offset is enough; its curve does. What is
    zero by definition, because z counts from there, says nothing of it.
    """
    zero = np.isin(np.arange(len(model.weight)), z_zero(model.vectors))
    by_definition = np.setdiff1d(model.vectors.feature_index[zero], model.vectors.feature_index[~zero])
    from_memory = [i for i, curve in enumerate(model.curves) if curve.from_memory and i not in by_definition]
    on_others = ~np.isin(model.vectors.feature_index, from_memory)
    used = np.flatnonzero((model.weight > 0.0) & on_others & ~zero)
    touched = model.vectors.chosen(used)
    errors, normals, sigmas = [touched.error_mm], [touched.outward_normal], [model.touch_sigma_mm(touched)]
    lowest = float(np.min(sigmas[0], initial=np.inf))
    index, along = [touched.feature_index], [touched.arc_length_mm]
    for i in from_memory:
        s, _ = angles_along(model.profile, i)
        errors.append(model.curves[i].value_mm(s[2::5]))
        normals.append(model.profile.features[i].outward_normal(s[2::5]))
        index.append(np.full(len(s[2::5]), i, dtype=np.intp))
        sigmas.append(np.full(len(s[2::5]), lowest if np.isfinite(lowest) else model.scatter_mm))
        along.append(s[2::5])
    close = np.arange(len(model.weight)) if model.correlated is None else model.correlated
    kept = np.isin(close, used)
    correlated = np.searchsorted(used, close[kept]), model.correlation[np.ix_(kept, kept)]
    places = np.concatenate(index), np.concatenate(along)
    return np.concatenate(errors), np.concatenate(normals), np.concatenate(sigmas), places, correlated


def _along(shifts: Sequence[Shift], feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
    pairs = zip(feature_index.tolist(), arc_length_mm, strict=True)
    return np.array([float(shifts[i].value_mm(s)) for i, s in pairs])


def _given_up_mm(inputs: Inputs, matched: Commanded, decision: Decision, touches: ErrorVectors) -> Array:
    """Returns at the touches the part of a correction in force that an offset in its place gives up, (n,)."""
    if not decision.by_offset:
        return np.zeros(len(touches.error_mm))
    offset = np.array(inputs.in_force.cut_with.offset_mm) - np.array(decision.in_force_mm)
    moved = np.asarray(touches.outward_normal @ offset)
    if not matched.in_force:
        return moved
    return moved + _along(matched.in_force, touches.feature_index, touches.arc_length_mm)


def _by_tool(
    inputs: Inputs,
    matched: Commanded,
    model: ProfileErrorModel,
    decision: Decision,
    paths: Paths,
    wear: WearOffset,
    tools: ContourTools,
) -> ByTool | None:
    """Returns each tool's offset; before any T word that of the tool which gets one. None: none can carry it, as where
    the program shifts its contour by itself because a number entered at the control would move nothing.
    """
    cannot = inputs.no_offset or not_in_force(inputs.program, matched.path, matched.cuts[0].move)
    if inputs.machine is not None or cannot:
        return None
    cut_by = [number or wear.tool for number in tools.cut_by]
    weight, others = inputs.options.weight, [number for number in tools.others if number != wear.tool]
    cut, profile = inputs.in_force.cut_with, inputs.profile

    def in_force(index: int, s: Array) -> Array:
        moved = profile.features[index].outward_normal(s) @ np.array(cut.offset_mm)
        return np.asarray(moved + (matched.in_force[index].value_mm(s) if matched.in_force else 0.0))

    before = in_force if cut.corrected else None
    return answer_by_tool(
        *(profile, model, decision, weight, paths.commanded, wear, cut_by, others), in_force=before, wear_mm=cut.wear_mm
    )


def writing(inputs: Inputs, matched: Commanded, bent: bool = False) -> Writing:
    """Returns the inputs from which the programs are written, with the marks that the results carry."""
    machine, options = inputs.machine, inputs.options
    nose_mm = inputs.nose_radius_mm if matched.match.on_contour else 0.0
    fitting = Fitting(options.chord_tolerance_mm, options.arcs, bent or machine is not None, nose_mm)
    mark = "" if machine is None else machine.mark
    return Writing(
        program=inputs.program,
        matched=matched,
        run=inputs.run,
        record_id=id_of(inputs),
        fitting=fitting,
        composed=mark,
        roughing_stays=options.roughing == "stays",
    )


def _in_program_mm(inputs: Inputs, matched: Commanded, touches: ErrorVectors) -> Array:
    """Returns the in-force correction at the touches that the program keeps, (n,): without table wear and COMP_MTG."""
    cut = inputs.in_force.cut_with
    moved = np.asarray(touches.outward_normal @ np.array(cut.still_to_do(cut.offset_mm)))
    return moved + _along(matched.in_force, touches.feature_index, touches.arc_length_mm) if matched.in_force else moved


def _composed(
    machine: InMachine,
    surface: Surface,
    model: ProfileErrorModel,
    prediction: Prediction,
    *,
    nose_mm: float,
    before_mm: Array,
) -> Composed:
    """Returns the components at the touches: COMP_PROC is the prediction's, on top of `before_mm` of the program."""
    gain = np.array([curve.gain for curve in model.curves])[model.vectors.feature_index]
    process_mm = before_mm + (prediction.after_mm - expected_uncorrected_mm(model)) / gain
    comp_mtg_mm = comp_mtg_at(machine, surface.touches, process_mm, nose_mm)
    return Composed(surface.reported_mm, surface.cut_in_mm, comp_mtg_mm, process_mm)
