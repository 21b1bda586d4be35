"""What a control logged, back to part errors: by position, never by count."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.probing import APPROACH, STEP, example_plan, log_of, plan_of
from trueloop.arrays import Array
from trueloop.controllers.probing import Settings
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.touches_csv import parse_probe_log
from trueloop.probing.calibration import BallCalibration
from trueloop.probing.probe_match import MatchedTouches, match_touches
from trueloop.probing.probe_plan import ProbePlan

CALIBRATION = BallCalibration(1.4946, cosine_mm=-0.0005)


def reported(plan: ProbePlan, error_mm: Array) -> Array:
    """Ball centres as a probe with that calibration reports surfaces of these errors."""
    normal = np.array([touch.normal for touch in plan.touches])
    nominal = np.array([touch.nominal_mm for touch in plan.touches])
    off = plan.approach.allowance_mm + error_mm + CALIBRATION.radius_mm(normal)
    centres: Array = nominal + off[:, None] * normal
    return centres


def read(plan: ProbePlan, text: str, control: str = "fanuc", diameter: bool = True) -> MatchedTouches:
    logged = parse_probe_log(text, "touches.txt", control, diameter=diameter)
    return match_touches(plan, [t.position_mm for t in logged], [t.line for t in logged], CALIBRATION)


def errors(matched: MatchedTouches) -> list[float]:
    return [touch.error_mm for touch in matched.touches if touch.error_mm is not None]


@pytest.mark.parametrize("diameter", [True, False])
@pytest.mark.parametrize("name", ["facetst", "modbas2", "piecs11"])
def test_errors_come_back_whatever_the_order_and_the_diameter_mode(name: str, diameter: bool) -> None:
    plan = example_plan(name)
    rng = np.random.default_rng(1)
    error = rng.normal(0.0, 0.05, len(plan.touches))
    rows = rng.permutation(len(plan.touches))
    matched = read(
        plan, log_of(plan, reported(plan, error), list(rows), program=Settings(diameter=diameter)), diameter=diameter
    )
    assert [touch.point for touch in matched.touches] == [touch.point for touch in plan.touches]
    assert np.allclose(errors(matched), error, atol=1.5e-4)
    turned = int(np.sum(np.diff(rows) < 0))
    (order,) = matched.findings
    assert order.code is Code.PRB_ORDER and order.message.endswith(f", and {turned - 1} more") and turned > 1


def test_linuxcnc_logs_radii_even_in_diameter_mode() -> None:
    plan = plan_of(STEP, {"cylinder": 2})
    rows = "".join(f"{x:.6f} 0.0 {z:.6f} 0 0 0 0 0 0\n" for x, z in reported(plan, np.array([0.01, -0.02])))
    matched = read(plan, rows, "linuxcnc")
    assert np.allclose(errors(matched), [0.01, -0.02], atol=1e-6)
    assert matched.findings == ()


def test_a_wrong_diameter_mode_is_another_job_s_log() -> None:
    plan = plan_of(STEP, {"cylinder": 2})
    with pytest.raises(TrueloopError, match=r"2 of 2 touches .* the nearest") as refused:
        read(plan, log_of(plan, reported(plan, np.zeros(2))), diameter=False)
    assert refused.value.code is Code.PRB_OTHER


def test_a_touch_that_a_control_left_out_is_named() -> None:
    plan = example_plan("modbas2")
    error = np.zeros(len(plan.touches))
    with pytest.raises(TrueloopError, match="1 of 32 points have no touch: '7'") as refused:
        read(plan, log_of(plan, reported(plan, error), [k for k in range(32) if k != 6]))
    assert refused.value.code is Code.PRB_MISSING


def test_all_touches_at_the_retract_plane_are_a_probe_that_was_triggered_already() -> None:
    plan = plan_of(STEP, {"cylinder": 3, "face": 2})
    starts = np.array([touch.start_mm for touch in plan.touches])
    with pytest.raises(TrueloopError, match=r"5 of 5 touches are where the approach began, 2\.000 mm off") as refused:
        read(plan, log_of(plan, starts))
    assert refused.value.code is Code.PRB_RETRACT


def test_a_move_that_went_to_its_end_is_no_touch() -> None:
    """A control that does not look whether its probe tripped logs where the move ended: 1 mm inside the part."""
    plan = example_plan("modbas2")
    logged = reported(plan, np.zeros(len(plan.touches)))
    logged[6] = plan.touches[6].target_mm
    with pytest.raises(
        TrueloopError, match=r"1 of 32 probing moves went to their end without a touch, .* at point '7'"
    ) as refused:
        read(plan, log_of(plan, logged))
    assert (refused.value.code, refused.value.place.line) == (Code.PRB_MISSED, 7)


def test_a_touch_in_a_direction_that_was_not_calibrated_is_refused() -> None:
    plan = plan_of(STEP, {"cylinder": 2, "face": 2})
    logged = [(float(x), float(z)) for x, z in reported(plan, np.zeros(4))]
    towards_z = replace(CALIBRATION, lowest_rad=np.radians(-45.0), highest_rad=np.radians(45.0))
    with pytest.raises(
        TrueloopError, match=r"-45\.0° to 45\.0° .*: 2 of 4 touches .* on 'cylinder', at 90\.0°"
    ) as refused:
        match_touches(plan, logged, range(1, 5), towards_z)
    assert refused.value.code is Code.PRB_CALIBRATION
    both = replace(towards_z, highest_rad=np.radians(90.0))
    assert np.allclose(errors(match_touches(plan, logged, range(1, 5), both)), 0.0, atol=1e-9)


def test_fanuc_pads_numbers_with_blanks() -> None:
    plan = plan_of(STEP, {"cylinder": 1})
    ((x, z),) = reported(plan, np.array([0.0]))
    matched = read(plan, f"%\nX   {2 * x:.3f}Z  {z:.3f}\n%\n")
    assert abs(matched.touches[0].error_mm or 0.0) < 1e-3
    assert APPROACH.stand_off_mm == 2.0
