"""A corrected part as recorded in the memory of an edge: S, F and C of the model of `memory`, from stored data.

What a program commands off the nominal is not an error of the process: it is taken out of S as of F, so that E = F + C
is the error of the finish cut had nothing been corrected [6811 §3.2], whichever program ran.
"""

import math

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Cut, Ran
from trueloop.domain.part import PartType
from trueloop.errors import Code, TrueloopError
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.cut_errors import cut_errors
from trueloop.loops.turned.paths import whole_mm
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.touches.error_vectors import ErrorVectors


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
    removes.

    C = −(commanded contour − nominal)·n, of the process alone: what the program moves for the machine's errors is no
    part of it. A tool offset D moves the contour by D, so C = −(own deviation + D·n). Where z was taken from a face, C
    counts from what was taken off there, as the errors do. To first order in the deviation: good to D²/2ρ on an arc of
    radius ρ, 0.05 µm for 50 µm on 25 mm.
    """
    off_mm = at.outward_normal @ np.array(_whole_mm(correction, ran))
    pieces = correction.corrected if ran is Ran.CORRECTED else correction.commanded
    for index, piece in enumerate(pieces):
        rows = at.of_feature(index)
        off_mm[rows] += piece.shifted.undisplaced.off_nominal_mm(at.arc_length_mm[rows])
    reference = np.flatnonzero(at.at_reference)
    if len(reference):
        off_mm -= np.where(at.at_reference, 1.0, at.z_share) * off_mm[reference[0]]
    return np.asarray(0.0 - off_mm)


def from_memory_mm(correction: Correction, at: ErrorVectors, ran: Ran) -> Array:
    """Returns the share of C that came from memory and not from the part's own touches, (n,); an offset has none."""
    if correction.memory is None or ran is not Ran.CORRECTED or correction.decision.offset_is_enough:
        return np.zeros(len(at.point))
    share = correction.memory.taken_off_mm(at.feature_index, at.arc_length_mm)
    return correction.options.weight * share


def _whole_mm(correction: Correction, ran: Ran) -> tuple[float, float]:
    """Returns the displacement of the whole contour for the process: by the tool offset, or within the contour."""
    decision = correction.decision
    if ran is Ran.AS_PROGRAMMED:
        return 0.0, 0.0
    by_offset = ran in (Ran.OFFSETS, Ran.WEAR) or decision.by_offset
    if by_offset:
        return decision.whole_offset_mm
    kept, change = correction.cut_with.offset_mm, whole_mm(decision)
    return kept[0] + change[0], kept[1] + change[1]


def _other_program(correction: Correction, cut: Cut, ran: str) -> TrueloopError:
    return Code.STO_PROGRAM.refusal(
        f"the finish cut of part {cut.part.serial!r} ran {ran}, which is not of correction {correction.record.id}",
        hint="name the correction that the cut was made with, or say that it ran as programmed",
        values={"serial": cut.part.serial, "correction": correction.record.id},
    )
