"""S, F and C of a made part: C against the programs read back, and E = F + C against a cut that was not corrected."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tests.loops.test_simulated import exact, trial
from tests.support.correction import example_correction, example_inputs, size_error_correction
from trueloop.arrays import Array
from trueloop.domain.life import Cut, CuttingConditions, Ran, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.errors import TrueloopError
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.made_parts import made_part, program_that_ran, taken_off_mm
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.matching import match_contour
from trueloop.nc.program.along import feed_moves
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import (
    Trial,
    corrected_paths,
    finish_along,
    finishing_machine,
    semifinish_and_probe,
    true_errors_mm,
)

UM = 1 / UM_PER_MM
EDGE = Edge(Tool(1, "PCLNL"), "CNMG 120408", "2")
CUT = Cut(
    Part(PartType("MODBAS2", "B"), "2511.161"),
    Stage.FINISH,
    Setting(EDGE, datetime(2026, 1, 5, tzinfo=UTC)),
    order=4,
    conditions=CuttingConditions(0.25, 0.1),
)


def off_nominal_mm(inputs: Inputs, source: bytes, at: ErrorVectors) -> Array:
    """Where a program's contour lies from the nominal, as its text is read and matched with the profile."""
    path = inputs.run.of(inputs.program.rewritten(source))
    match = match_contour(feed_moves(path), inputs.profile, inputs.nose_radius_mm)
    found = np.empty(len(at.point))
    for index, feature in enumerate(match.features):
        rows = at.of_feature(index)
        found[rows] = feature.deviation_mm(at.arc_length_mm[rows])
    return found


def cut_by(correction: Correction, program: bytes | None = None) -> Cut:
    sha256 = "" if program is None else sha256_of(program)
    return replace(CUT, correction=correction.record.id, program_sha256=sha256)


@pytest.mark.parametrize("name", ["modbas2", "piecs11", "facetst"])
def test_what_a_corrected_program_takes_off_is_what_its_text_says(name: str) -> None:
    """To what the control resolves and to the chords of arcs."""
    inputs, correction = example_inputs(name), example_correction(name)
    at = replace(correction.touches, at_reference=np.zeros(len(correction.touches.point), dtype=np.bool_))
    found = taken_off_mm(correction, at, Ran.CORRECTED)
    read = -off_nominal_mm(inputs, correction.corrected_program, at)
    assert np.max(np.abs(found)) > 20 * UM
    assert found == pytest.approx(read, abs=2.5 * UM)


def test_a_part_too_large_is_made_smaller_by_the_correction() -> None:
    """The largest error of MODBAS2's dome, +78.4 µm at point 20: the corrected program takes 78 µm more off."""
    correction = example_correction("modbas2")
    touches = correction.touches
    part = made_part(correction, cut_by(correction), touches)
    k = part.semifinish.point.index("20")
    assert part.semifinish.error_mm[k] == pytest.approx(78.4 * UM, abs=0.1 * UM)
    assert part.finish is not None and part.correction_mm is not None
    assert part.correction_mm[part.finish.point.index("20")] == pytest.approx(78 * UM, abs=3 * UM)


def test_every_place_but_the_reference_by_its_contact_angle() -> None:
    correction = example_correction("modbas2")
    part = made_part(correction, cut_by(correction), correction.touches)
    assert part.finish is not None and part.part_type == "MODBAS2 B" and part.serial == "2511.161"
    touches = correction.touches
    touched = {correction.profile.names[i] for i in touches.feature_index[~touches.at_reference]}
    assert set(part.semifinish.feature) == set(part.finish.feature) == touched
    rows = [correction.touches.point.index(name) for name in part.finish.point]
    normal = correction.touches.outward_normal[rows]
    assert np.column_stack([np.sin(part.finish.contact_angle_rad), np.cos(part.finish.contact_angle_rad)]) == (
        pytest.approx(normal, abs=1e-12)
    )
    assert part.order == 4.0 and part.feed_mm == 0.1 and part.depth_of_cut_mm == 0.25
    assert part.setting == "PCLNL CNMG 120408 2 2026-01-05T00:00:00+00:00"


def test_without_an_inspection_there_is_nothing_that_was_obtained() -> None:
    correction = example_correction("piecs11")
    part = made_part(correction, replace(cut_by(correction), order=None), None)
    assert part.finish is None and part.correction_mm is None and part.uncorrected_mm is None
    assert math.isnan(part.order)
    assert len(part.semifinish.point) == np.count_nonzero(~correction.touches.at_reference)


def test_an_offset_takes_off_what_it_moves_along_the_normal() -> None:
    """10 µm too large on the radius: −10 µm on X, by hand 10 µm · n_x at every place."""
    correction = size_error_correction()
    assert correction.decision.by_offset and correction.offsets_program is not None
    at = replace(correction.touches, at_reference=np.zeros(len(correction.touches.point), dtype=np.bool_))
    by_hand = 10 * UM * at.outward_normal[:, 0]
    own = taken_off_mm(correction, at, Ran.AS_PROGRAMMED)
    for ran in (Ran.OFFSETS, Ran.CORRECTED):
        assert taken_off_mm(correction, at, ran) - own == pytest.approx(by_hand, abs=0.05 * UM)


@pytest.mark.parametrize("weight", [1.0, 0.5])
def test_half_the_weight_takes_off_half(weight: float) -> None:
    inputs = example_inputs("modbas2")
    whole = example_correction("modbas2")
    correction = compensate(replace(inputs, options=replace(inputs.options, weight=weight)))
    at = correction.touches
    own = taken_off_mm(correction, at, Ran.AS_PROGRAMMED)
    full = taken_off_mm(whole, at, Ran.CORRECTED) - own
    assert taken_off_mm(correction, at, Ran.CORRECTED) - own == pytest.approx(weight * full, abs=1e-6)


def test_which_program_ran() -> None:
    correction = example_correction("modbas2")
    assert program_that_ran(correction, cut_by(correction)) is Ran.CORRECTED
    assert program_that_ran(correction, cut_by(correction, correction.corrected_program)) is Ran.CORRECTED
    assert program_that_ran(correction, cut_by(correction, correction.offsets_program)) is Ran.OFFSETS
    assert program_that_ran(correction, cut_by(correction, correction.source_program)) is Ran.AS_PROGRAMMED
    assert program_that_ran(correction, CUT) is Ran.AS_PROGRAMMED
    offset = size_error_correction()
    assert program_that_ran(offset, cut_by(offset)) is Ran.OFFSETS
    for other in (cut_by(correction, b"M30"), replace(CUT, correction="0" * 16)):
        with pytest.raises(TrueloopError, match="STO-PROGRAM"):
            program_that_ran(correction, other)


def obtained_mm(given: Trial, correction: Correction, ran: Ran) -> tuple[Array, Array]:
    """True errors of one simulated part finished as said, and of the same part finished as programmed."""
    workshop = exact()
    stock, _ = semifinish_and_probe(given, workshop, 3)
    machine = workshop.machine if ran is Ran.AS_PROGRAMMED else finishing_machine(workshop, correction)
    paths = given.finish if ran is Ran.AS_PROGRAMMED else corrected_paths(given, correction)
    made = finish_along(workshop, machine, paths, stock, 3)
    plain = finish_along(workshop, workshop.machine, given.finish, stock, 3)
    return true_errors_mm(given, made), true_errors_mm(given, plain)


@pytest.mark.parametrize("reference", [None, "1"])
@pytest.mark.parametrize("ran", [Ran.CORRECTED, Ran.AS_PROGRAMMED])
def test_error_left_and_correction_are_the_error_uncorrected(ran: Ran, reference: str | None) -> None:
    """On the simulated lathe, whose nose and stock know nothing of shifts: E = F + C on the arcs.

    To 1 µm: a correction that slopes by 3 µm/mm is cut 3 mrad further on the nose, whose form changes 200 µm/rad.
    """
    given = replace(trial("piecs11"), z_reference=reference)
    _, touches = semifinish_and_probe(given, exact(), 3)
    correction = compensate(replace(given.inputs, touches=touches))
    left_mm, uncorrected_mm = obtained_mm(given, correction, ran)
    cut = cut_by(correction, correction.source_program if ran is Ran.AS_PROGRAMMED else None)
    part = made_part(correction, cut, replace(touches, error_mm=left_mm))
    rows = [touches.point.index(name) for name in part.semifinish.point]
    assert np.max(np.abs(uncorrected_mm[rows])) > 20 * UM
    assert part.uncorrected_mm == pytest.approx(uncorrected_mm[rows], abs=1.0 * UM)


def test_an_offset_and_a_face_from_which_z_counts() -> None:
    """z taken from a face that the offset moves too: what the offset takes off counts from there."""
    given = replace(trial("piecs11"), z_reference="1")
    _, touches = semifinish_and_probe(given, exact(), 3)
    asked = replace(given.inputs, touches=touches)
    correction = compensate(replace(asked, options=replace(asked.options, by="offset")))
    assert max(map(abs, correction.decision.offset_mm)) > 5 * UM
    left_mm, uncorrected_mm = obtained_mm(given, correction, Ran.OFFSETS)
    part = made_part(correction, cut_by(correction), replace(touches, error_mm=left_mm))
    rows = [touches.point.index(name) for name in part.semifinish.point]
    assert part.uncorrected_mm == pytest.approx(uncorrected_mm[rows], abs=0.3 * UM)
