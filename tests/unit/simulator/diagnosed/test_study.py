"""The study of diagnoses in small, and what it takes from the shop."""

from dataclasses import replace

import numpy as np
import pytest

from studies.diagnosed.axis_errors import CHUCK_MM
from studies.diagnosed.seen import machine_seen, seen_series
from studies.diagnosed.shop import Shop, cut_series
from studies.diagnosed.truth import Fault, Truth, Wrong
from studies.diagnosis_cases import process_case
from studies.diagnosis_causes_study import answer
from studies.diagnosis_terms_study import Measured, trial
from trueloop.diagnosis.causes.cause import SeenBy

EXACT = Shop(cut_mm=0.0, probe_mm=0.0, cmm_mm=0.0, cooled_k=0.0, parts=6, set_anew=())


@pytest.mark.parametrize("fault", [Fault.TOOL_OFFSET, Fault.CHATTER])
def test_a_cause_of_the_process_is_named_first(fault: Fault) -> None:
    assert answer(process_case((fault,), 300)).first


def test_a_sound_series_has_no_finding() -> None:
    found = answer(process_case((), 910_001))
    assert not found.refused and not found.found


def test_set_ups_that_scatter_along_z_are_no_axis_error() -> None:
    """Found as spindle growth where one variance is tried for all directions."""
    for seed in (5000, 5006):
        assert trial("", Measured(steady=True), seed).sets == ()


def test_one_wrong_axis_error_is_in_the_set() -> None:
    assert trial("EBZ", Measured(), 1).held


def test_a_standard_part_shows_what_the_model_has_wrong_at_the_reference_against_its_sign() -> None:
    wrong = Wrong(Fault.AXIS_ERROR, 0.004, error="EXX", signal="T cross slide", constant=1.0)
    series = cut_series(Truth((wrong,)), replace(EXACT, standard_at=(0,)))
    shaft = series.points.is_of(["shaft 1"]).astype(bool)
    share = (20.0 - 40.0 + 65.0) / 115.0  # the slide stands at the radius less X_T
    read = series.made[0].read_mm[SeenBy.MACHINE][shaft]
    assert read == pytest.approx(-0.004 * (0.2 + share), abs=1e-9)


def test_a_correction_of_faces_is_recorded_as_what_it_takes_off_their_length() -> None:
    """Errors and what was taken off them add up to those of the parts before."""
    truth = Truth((Wrong(Fault.TWO_TOOLS, 0.009, "T2"), Wrong(Fault.WEAR, 0.2)))
    series = cut_series(truth, replace(EXACT, tools=("T1", "T2"), corrected_from=4))
    part = seen_series(series).parts[4]
    taken = series.made[4].corrected_mm
    assert abs(taken["shoulder 1"]) > 0.002
    assert part.correction_mm[("end face", "length")] == pytest.approx(taken["end face"] - taken["shoulder 1"])


def test_axes_stand_where_the_tool_point_is_at_the_gauging_point() -> None:
    series = cut_series(Truth(), EXACT)
    seen, rows = machine_seen(series), series.points.angle_rad == 0.0
    point = seen.positions + seen.tool_mm[:, [0, 2]]
    nominal = np.tile(series.points.at_mm[rows] + np.array([0.0, CHUCK_MM]), (6, 1))
    assert point == pytest.approx(nominal) and np.abs(seen.tool_mm[:, 1]).max() == 0.0
