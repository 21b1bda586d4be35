"""A corrected part as recorded in the memory of an edge: S, F and C of the model of `memory`, from stored data.

What a program commands off the nominal is not an error of the process: it is taken out of S as of F, whichever program
ran.

Today's part by what earlier parts of its edge have shown: what its curves are made from, what is kept of it.

Earlier parts predict errors of all features; today's touches sharpen that, and are judged by it. Where they contradict
it, the part is corrected by its own touches alone.

How much a recorded correction took off a part, by the way in which it was carried out.

Memory, diagnoses and charts count by it: E = F + C is the error of the finish cut had nothing been corrected [6811
§3.2]. C is of the process alone: what a program moves for the machine's errors is not in it. A tool offset D moves
every surface of the tool by D, so that it takes −D·n off along the normal and nothing off lengths between its faces; a
corrected program moves each surface as its contour was changed.
"""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import astuple, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Ran, Stage
from trueloop.domain.part import PartType
from trueloop.domain.tool import Setting
from trueloop.errors import Code, TrueloopError
from trueloop.loops.turned.correction import Correction, FromMemory, Inputs, edge_words
from trueloop.loops.turned.deviations import cut_errors, places_along
from trueloop.loops.turned.in_force import cut_with
from trueloop.loops.turned.paths import whole_mm
from trueloop.memory.edge.predict import FEW, expect, is_seen
from trueloop.memory.made_part import CutErrors, Expected, MadePart
from trueloop.memory.noticing import PartChanges, notice_part
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.fit.chain_fit import Chain, chains_of
from trueloop.turned.fit.prior.remembered_fit import Remembered, angles_along
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.observed import RepeatedReading, corrected, datum_of, seen_by
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import all_of, wording


def program_that_ran(correction: Correction, cut: Cut) -> Ran:
    """Returns the program of a correction that made a cut; one without a hash ran the recommended program.

    A cut that names no correction ran as programmed, without an offset entered by hand. Raises STO-PROGRAM.
    """
    if not cut.correction:
        return Ran.AS_PROGRAMMED
    if cut.correction != correction.record.id:
        raise _other_program(correction, cut, f"correction {cut.correction}")
    if cut.offset_entered:
        return Ran.WEAR
    meant, hashes = correction.recommended, correction.programs_sha256
    ran = [one for one in (meant, *Ran) if hashes.get(one) == cut.program_sha256]
    if cut.program_sha256 and not ran:
        raise _other_program(correction, cut, f"program {cut.program_sha256[:16]}…")
    return ran[0] if ran else meant


def taken_off_mm(correction: Correction, at: ErrorVectors, ran: Ran) -> Array:
    """Returns C: the removal by the program that ran along the normals at places of the part, (n,), positive where it
    removes, counted from the nominal: the given program's own deviation is in it. Where z was taken from a face, C
    counts from what was taken off there, as the errors do.
    """
    off_mm = _off_nominal_mm(correction, ran, at.feature_index, at.arc_length_mm)
    reference = np.flatnonzero(at.at_reference)
    if len(reference):
        off_mm -= np.where(at.at_reference, 1.0, at.z_share) * off_mm[reference[0]]
    return np.asarray(0.0 - off_mm)


def moved_mm(correction: Correction, ran: Ran, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
    """Returns the surface's outward move against the given program, (n,): −C but for that program's deviation."""
    places = feature_index, arc_length_mm
    return _off_nominal_mm(correction, ran, *places) - _off_nominal_mm(correction, Ran.AS_PROGRAMMED, *places)


def taken_off_sizes_mm(correction: Correction, ran: Ran, inspection: Inspection) -> dict[str, float]:
    """Returns by how much a correction made each size of an inspection smaller, by characteristic: a diameter by twice
    as much as its radius, a length by what its far face moved less its near one. Sizes of no feature of the profile are
    left out, so are those read where their feature is not.
    """
    profile = correction.profile
    matched = corrected(match_inspection(profile, inspection).readings)
    readings = [reading for reading in matched if reading.reading.quantity.unit == "mm"]
    datum = datum_of(profile, readings)
    return {
        reading.reading.characteristic: -size_mm
        for reading in readings
        if (size_mm := _size_moved_mm(correction, ran, reading, datum)) is not None
    }


def _size_moved_mm(correction: Correction, ran: Ran, reading: MatchedReading, datum: int | None) -> float | None:
    try:
        seen = seen_by(correction.profile, RepeatedReading(reading, 1.0, 0.0, 1), datum)
    except TrueloopError:
        return None
    moved = seen.weight @ moved_mm(correction, ran, seen.feature_index, seen.arc_length_mm)
    return float(moved) / seen.value_mm  # of a deviation of 1: of a diameter half of it is the surface's


def from_memory_mm(correction: Correction, at: ErrorVectors, ran: Ran) -> Array:
    """Returns the share of C that came from memory and not from the part's own touches, (n,); an offset has none."""
    if correction.memory is None or ran is not Ran.CORRECTED or correction.decision.offset_is_enough:
        return np.zeros(len(at.point))
    share = correction.memory.taken_off_mm(at.feature_index, at.arc_length_mm)
    return correction.options.weight * share


def _off_nominal_mm(correction: Correction, ran: Ran, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
    """Returns the deviation of the contour that was commanded from the nominal, outwards, (n,): own deviation + D·n.

    To first order in the deviation: good to D²/2ρ on an arc of radius ρ, 0.05 µm for 50 µm on 25 mm.
    """
    offset_mm = np.array(_offset_mm(correction, ran))
    pieces = correction.corrected if ran is Ran.CORRECTED else correction.commanded
    off_mm = np.zeros(len(feature_index))
    for index in np.unique(feature_index).tolist():
        rows = np.flatnonzero(feature_index == index)
        along_mm = arc_length_mm[rows]
        normal = correction.profile.features[index].outward_normal(along_mm)
        off_mm[rows] = normal @ offset_mm + pieces[index].shifted.undisplaced.off_nominal_mm(along_mm)
    return off_mm


def _offset_mm(correction: Correction, ran: Ran) -> tuple[float, float]:
    """Returns the contour's whole displacement for the process: by the recorded offset, or within the contour."""
    if ran is Ran.AS_PROGRAMMED:
        return 0.0, 0.0
    decision = correction.decision
    if ran is Ran.CORRECTED and not decision.by_offset:
        kept, change = correction.cut_with.offset_mm, whole_mm(decision)
        return kept[0] + change[0], kept[1] + change[1]
    return cut_with(correction.record, Ran.OFFSETS if ran is Ran.CORRECTED else ran).offset_mm


def _other_program(correction: Correction, cut: Cut, ran: str) -> TrueloopError:
    return Code.STO_PROGRAM.refusal(
        f"the finish cut of part {cut.part.serial!r} ran {ran}, which is not of correction {correction.record.id}",
        hint="name the correction that the cut was made with, or say that it ran as programmed",
        values={"serial": cut.part.serial, "correction": correction.record.id},
    )


def made_part(correction: Correction, cut: Cut, finish: ErrorVectors | None) -> MadePart:
    """Returns one part with its correction, its finish cut and, where there is one, the inspection after it.

    `cut` says by its correction and the hash of its program which program ran; `finish` are the part errors that the
    inspection found. `order` is that of the cut, nan where it has none; the age of the edge is not known here.

    Raises STO-PROGRAM where the cut ran a program that is not of this correction.
    """
    profile, conditions = correction.profile, cut.conditions
    ran = program_that_ran(correction, cut)
    took_off = None if finish is None else taken_off_mm(correction, finish, ran)
    rows = None if finish is None else np.flatnonzero(~finish.at_reference)
    return MadePart(
        part_type=name_of(cut.part.part_type),
        serial=cut.part.serial,
        setting="" if cut.setting is None else " ".join(cut.setting.identity),
        order=math.nan if cut.order is None else float(cut.order),
        semifinish=semifinish_errors(correction.model),
        finish=None if finish is None else cut_errors(profile, finish),
        correction_mm=None if took_off is None else took_off[rows],
        from_memory_mm=None if finish is None or rows is None else from_memory_mm(correction, finish.chosen(rows), ran),
        depth_of_cut_mm=conditions.depth_of_cut_mm,
        feed_mm=conditions.feed_mm_per_rev,
        edge="" if cut.setting is None else " ".join(cut.setting.edge.identity),
    )


def name_of(part_type: PartType) -> str:
    """Returns the name by which memory knows parts of one drawing: another revision is another part type."""
    return " ".join(text for text in part_type.identity if text)


def semifinish_errors(model: ProfileErrorModel) -> CutErrors:
    """Returns S: the process errors that were touched; touches left out of the fit as bad are left out here too."""
    return cut_errors(model.profile, model.vectors.chosen(np.flatnonzero(model.weight)))


AS_CHECK: Final = 3
"""So few touches still judge whether a part is as earlier parts: level and form, with one that may be bad."""


def is_used(inputs: Inputs) -> bool:
    """Returns whether earlier parts take part in a correction."""
    return bool(inputs.history) and inputs.memory.memory != "off"


def remembering(inputs: Inputs, own: ProfileErrorModel) -> "tuple[Remembered | None, FromMemory | None]":
    """Returns memory's input to the fit, and its record; None where earlier parts take no part.

    `own` is the fit of today's touches alone. Raises MEM errors for what memory cannot tell and today's touches do not
    show either.
    """
    if not is_used(inputs):
        return None, None
    today = today_of(inputs, semifinish_errors(own))
    seen, left_out = _judged(inputs.history, today)
    today = replace(today, semifinish=_without(today.semifinish, left_out))
    # Features, by index, that memory may tell: all but arcs whose contact angles nobody has seen; of these, arcs with a
    # few touches (from one to `FEW`) are asked for, so that memory refuses them.
    chains = chains_of(inputs.profile)
    known = [i for chain in chains if not chain.curved or _is_asked(inputs, today, chain) for i in chain.features]
    features = tuple(sorted(known))
    index, along, at = places_along(inputs.profile, features, own.vectors)
    expected = expect(inputs.history, today, at, inputs.memory)
    expected = replace(expected, feature_index=index, arc_length_mm=along)
    alarmed = seen is not None and seen.own_fit
    kept = FromMemory(
        edge=edge_words(inputs.edge),
        use=inputs.memory.memory,
        applied=not (alarmed or expected.own_fit),
        features=features,
        points=today.semifinish.point,
        keep=points_to_keep(today.semifinish, expected.enough_touches),
        expected=expected,
        alarms=() if seen is None else tuple(alarm.says for alarm in seen.alarms),
        notes=(*expected.notes, *(() if seen is None else seen.notes), *_unknown_words(inputs, features)),
    )
    return (None if alarmed else _as_table(expected, index, along, kept.applied)), kept


def today_of(inputs: Inputs, touches: CutErrors) -> MadePart:
    """Returns the part in hand, before its finish cut, with these touches."""
    serials = [inspection.part.serial for inspection in inputs.inspections if inspection.part.serial]
    setting = None if inputs.edge is None else Setting(inputs.edge, inputs.edge_set_at)
    return MadePart(
        part_type=name_of(inputs.part),
        serial=serials[0] if serials else "",
        setting="" if setting is None else " ".join(setting.identity),
        order=max(part.order for part in inputs.history) + 1.0,
        semifinish=touches,
        edge="" if inputs.edge is None else " ".join(inputs.edge.identity),
    )


def points_to_keep(touches: CutErrors, enough: int) -> tuple[str, ...]:
    """Returns that many of the touches, by name, spread evenly over the part in their order: of twenty the 3rd, 10th
    and 17th.

    At least `AS_CHECK`. Placing three where they lower the predicted variance most was no better on NIST's parts, and
    worse at angles that had not been seen.
    """
    n = len(touches.point)
    enough = min(max(enough, AS_CHECK), n)
    places = [int((k + 0.5) * n / enough - 0.5) for k in range(enough)] if n else []
    return tuple(touches.point[k] for k in places)


def history_sha256(history: Sequence[MadePart]) -> str:
    """Returns the hash by which a record names the earlier parts that it was made from."""
    digest = hashlib.sha256()
    for part in history:
        for value in (astuple(part.semifinish), () if part.finish is None else astuple(part.finish)):
            for one in value:
                digest.update(one.tobytes() if isinstance(one, np.ndarray) else repr(one).encode())
        taken = b"" if part.correction_mm is None else part.correction_mm.tobytes()
        digest.update(taken + repr((part.part_type, part.serial, part.setting, part.order)).encode())
    return digest.hexdigest()


def _judged(history: Sequence[MadePart], today: MadePart) -> tuple[PartChanges | None, tuple[int, ...]]:
    """Returns the differences of today's touches from the earlier parts' prediction, and contradicted touches."""
    if not any(part.uncorrected_mm is not None or len(part.semifinish.error_mm) for part in history):
        return None, ()
    seen = notice_part(history, today).get(Stage.SEMIFINISH)
    return seen, () if seen is None else tuple(left_out.index for left_out in seen.left_out)


def _without(touches: CutErrors, left_out: Sequence[int]) -> CutErrors:
    return touches.chosen(np.setdiff1d(np.arange(len(touches)), np.array(left_out, dtype=np.intp)))


def _is_asked(inputs: Inputs, today: MadePart, chain: Chain) -> bool:
    names = {inputs.profile.names[i] for i in chain.features}
    touches = sum(feature in names for feature in today.semifinish.feature)
    if 0 < touches < FEW:
        return True
    angles = np.concatenate([angles_along(inputs.profile, i)[1] for i in chain.features])
    return bool(np.all(is_seen(inputs.history, today, angles, np.full(len(angles), touches), inputs.memory)))


def _as_table(expected: Expected, index: NDArray[np.intp], along_mm: Array, corrects: bool) -> Remembered:
    """As the fit takes it: E is what the correction takes off times what the machine makes of a correction of 1."""
    return Remembered(
        feature_index=index,
        arc_length_mm=along_mm,
        mean_mm=expected.gain * expected.mean_mm,
        covariance_mm2=expected.covariance_mm2,
        correct_mm=expected.weight * expected.mean_mm,
        gain=expected.gain,
        corrects=corrects,
    )


def _unknown_words(inputs: Inputs, words: tuple[int, ...]) -> tuple[str, ...]:
    """Arcs that memory does not tell."""
    curved = [i for chain in chains_of(inputs.profile) if chain.curved for i in chain.features]
    unknown = [inputs.profile.names[i] for i in curved if i not in words]
    if not unknown:
        return ()
    return (
        wording(
            "{features}: contact angles that earlier parts of the edge have not shown; corrected by own touches.",
            features=all_of(unknown),
        ),
    )
