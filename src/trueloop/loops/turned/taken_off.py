"""How much a recorded correction took off a part, by the way in which it was carried out.

Memory, diagnoses and charts count by it: E = F + C is the error of the finish cut had nothing been corrected [6811
§3.2]. C is of the process alone: what a program moves for the machine's errors is not in it. A tool offset D moves
every surface of the tool by D, so that it takes −D·n off along the normal and nothing off lengths between its faces; a
corrected program moves each surface as its contour was changed.
"""

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Ran
from trueloop.errors import Code, TrueloopError
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.in_force import cut_with
from trueloop.loops.turned.paths import whole_mm
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.observed import RepeatedReading, corrected, datum_of, seen_by
from trueloop.turned.touches.error_vectors import ErrorVectors


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
