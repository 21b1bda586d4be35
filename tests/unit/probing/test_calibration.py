"""Ball radius and lobing from touches on a sphere or in a ring."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trueloop.errors import Code, TrueloopError
from trueloop.probing.calibration import BallCalibration, calibrate
from trueloop_lab.simulator.machine import VirtualProbe

EVERYWHERE = np.radians(np.linspace(-45.0, 135.0, 31))


@settings(max_examples=50)
@given(
    pre_travel=st.floats(0.0, 0.02),
    lobing=st.floats(0.0, 0.005),
    phase=st.floats(-2.0, 2.0),
    x=st.floats(-100.0, 100.0),
    ring=st.booleans(),
)
def test_an_exact_probe_is_found_exactly(pre_travel: float, lobing: float, phase: float, x: float, ring: bool) -> None:
    probe = VirtualProbe(1.5, pre_travel, lobing, lobing_phase_rad=phase)
    size = -25.0 if ring else 12.5
    found = calibrate(probe.touch_sphere((x, 3.0), size, EVERYWHERE, np.random.default_rng(0)), abs(size), ring=ring)
    normal = np.column_stack([np.sin(EVERYWHERE), np.cos(EVERYWHERE)])
    assert np.allclose(found.radius_mm(normal), 1.5 - probe.trip_mm(normal), atol=1e-9)
    assert math.isclose(found.lobing_mm, lobing, abs_tol=1e-9)


def test_the_radius_is_that_in_the_direction_of_the_touch() -> None:
    """Three lobes: none along x, the whole amplitude along z."""
    assert np.allclose(BallCalibration(1.495, cosine_mm=0.001).radius_mm(np.eye(2)), [1.495, 1.496])


def test_scatter_is_reported_as_it_was_drawn() -> None:
    probe = VirtualProbe(1.5, range_x_mm=0.0015, range_z_mm=0.0015)
    angles = np.tile(EVERYWHERE, 40)
    found = calibrate(probe.touch_sphere((0.0, 0.0), 12.5, angles, np.random.default_rng(1)), 12.5)
    assert math.isclose(found.scatter_mm, 0.0015 / math.sqrt(12), rel_tol=0.05)


@pytest.mark.parametrize(("span_deg", "narrow"), [(90.0, True), (110.0, True), (180.0, False), (351.0, False)])
def test_what_is_not_known_of_the_ball_is_told(span_deg: float, narrow: bool) -> None:
    """Repeated calibrations differ by as much, in the direction that they know worst."""
    probe = VirtualProbe(1.5, 0.005, 0.001, range_x_mm=0.0015, range_z_mm=0.0015)
    angles, rng = np.radians(np.linspace(0.0, span_deg, 21)), np.random.default_rng(3)
    made = [calibrate(probe.touch_sphere((0.0, 0.0), 12.5, angles, rng), 12.5) for _ in range(400)]
    normal = np.column_stack([np.sin(angles), np.cos(angles)])
    spread = np.std([one.radius_mm(normal) for one in made], axis=0)
    told = np.sqrt(np.mean([one.radius_u_mm**2 for one in made]))
    assert told == pytest.approx(spread.max(), rel=0.1)
    assert np.mean([bool(one.findings) for one in made]) == narrow


@pytest.mark.parametrize(
    ("centres", "radius_mm", "says"),
    [
        (np.zeros((5, 2)), 12.5, "5 touches"),
        (14.0 * np.column_stack([np.sin(EVERYWHERE / 3), np.cos(EVERYWHERE / 3)]), 12.5, "span 60°"),
        (14.0 * np.column_stack([np.sin(EVERYWHERE), np.cos(EVERYWHERE)]), 25.0, "ball radius of -11"),
    ],
)
def test_what_is_no_calibration_is_refused(centres: np.ndarray, radius_mm: float, says: str) -> None:
    with pytest.raises(TrueloopError, match=says) as refused:
        calibrate(centres, radius_mm)
    assert refused.value.code is Code.PRB_CALIBRATION


def _calibrated(degrees: np.ndarray) -> BallCalibration:
    probe = VirtualProbe(1.5, 0.005, 0.001)
    return calibrate(probe.touch_sphere((0.0, 0.0), 12.5, np.radians(degrees), np.random.default_rng(0)), 12.5)


def _covered(calibration: BallCalibration, *degrees: float) -> list[bool]:
    angle = np.radians(degrees)
    return calibration.covers(np.column_stack([np.sin(angle), np.cos(angle)])).tolist()


def test_a_calibration_holds_where_it_was_touched() -> None:
    quarter = _calibrated(np.linspace(0.0, 90.0, 12))
    assert _covered(quarter, -0.9, 0.0, 45.0, 90.0, 90.9) == [True] * 5
    assert _covered(quarter, -1.1, 91.1, 180.0, -90.0) == [False] * 4


def test_a_range_may_lie_across_the_half_turn() -> None:
    behind = _calibrated(np.linspace(120.0, 240.0, 12))
    assert _covered(behind, 120.0, 180.0, -170.0, -120.0, 0.0, 90.0) == [True] * 4 + [False] * 2


@pytest.mark.parametrize(("touches", "whole"), [(8, True), (6, False)])
def test_touches_less_than_half_a_lobe_apart_calibrate_every_direction(touches: int, whole: bool) -> None:
    """Three lobes are 120° each: eight touches, 45° apart, follow them; six, 60° apart, may all miss its slopes."""
    found = _calibrated(np.arange(touches) * 360.0 / touches)
    assert math.isclose(found.highest_rad - found.lowest_rad, 2 * math.pi) is whole
    assert all(_covered(found, *range(-180, 181, 5))) is whole
