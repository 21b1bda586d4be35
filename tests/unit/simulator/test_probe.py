"""The virtual ball, probe and measuring machine."""

import math

import numpy as np
import pytest

from trueloop.geometry.feature import Arc, Line
from trueloop_lab.simulator.machine import ErrorTerm, MachineError, Stock, VirtualProbe, ball_contact_mm, sweep
from trueloop_lab.simulator.mill import VirtualCmm
from trueloop_lab.simulator.nose import Nose, path_along

NOSE = Nose(0.8)
KNOB = Arc("knob", (30.8, 0.0), (0.0, 30.8), (0.0, 0.0), math.pi / 2)


def knob() -> Stock:
    return Stock((sweep(path_along([KNOB]).centre_mm, NOSE),))


def around(angle: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    normal = np.column_stack([np.sin(angle), np.cos(angle)])
    return radius * normal, normal


def test_a_ball_meets_a_knob_its_radius_outside() -> None:
    points, normal = around(np.linspace(0.2, 1.4, 25), 30.0)
    assert np.max(np.abs(ball_contact_mm(knob(), points, normal, 1.5) - 1.5)) < 3e-7  # the path's chords


def test_a_ball_on_a_slope_meets_it_beside_its_line() -> None:
    """A cone of 1 µm/mm probed square to the cylinder it was to be: contact at r·√(1 + slope²), to second order."""
    slope, ball = 0.05, 2.0
    cone = Line("", (20.8 - 0.5 * slope, -10.0), (20.8 + 0.5 * slope, 10.0))
    off = 0.8 * (math.hypot(1.0, slope / 20) - 1.0)
    stock = Stock((sweep(path_along([cone]).centre_mm, NOSE),))
    found = ball_contact_mm(stock, np.array([[20.0, 0.0]]), np.array([[1.0, 0.0]]), ball)
    assert abs(found[0] - (ball * math.hypot(1.0, slope / 20) - off)) < 1e-8


def test_a_ball_does_not_go_into_a_groove_it_is_too_large_for() -> None:
    """It rests on both edges: deeper by what its sphere bulges between them."""
    path = [
        Line("", (20.8, -10.0), (20.8, -1.0)),
        Line("", (20.8, -1.0), (19.8, -1.0)),
        Line("", (19.8, -1.0), (19.8, 1.0)),
    ]
    path += [Line("", (19.8, 1.0), (20.8, 1.0)), Line("", (20.8, 1.0), (20.8, 10.0))]
    stock = Stock((sweep(path_along(path).centre_mm, NOSE),))
    found = ball_contact_mm(stock, np.array([[19.5, 0.0]]), np.array([[1.0, 0.0]]), 3.0)
    edge = 1.8  # the nose's own radius widens the groove to z = ±1.8, its edges at x = 20
    assert abs(found[0] - (0.5 + math.sqrt(9.0 - edge**2))) < 1e-6


def test_pre_travel_and_lobing_are_reported_as_depth() -> None:
    probe = VirtualProbe(1.5, pre_travel_mm=0.004, lobing_mm=0.001, lobes=3, lobing_phase_rad=0.2)
    angle = np.linspace(0.2, 1.4, 13)
    points, normal = around(angle, 30.0)
    centres = probe.touch(knob(), points, normal, np.random.default_rng(0))
    late = 1.5 - np.einsum("ij,ij->i", centres - points, normal)
    assert np.allclose(late, 0.004 + 0.001 * np.cos(3 * (angle - 0.2)), atol=1e-6)


def test_repeated_touches_range_as_stated() -> None:
    probe = VirtualProbe(1.5, range_x_mm=0.0015, range_z_mm=0.0005)
    points, normal = around(np.full(2000, 0.8), 30.0)
    centres = probe.touch(knob(), points, normal, np.random.default_rng(0))
    assert np.allclose(np.ptp(centres, axis=0), [0.0015, 0.0005], rtol=0.02)
    assert np.allclose(centres.std(axis=0), np.array([0.0015, 0.0005]) / math.sqrt(12), rtol=0.05)


def test_the_control_reports_where_it_was_told_to_be_not_where_the_ball_is() -> None:
    """[6876 §3.3]: the reported position is the actual one less the machine's error."""
    error = MachineError((ErrorTerm(0, 0.001), ErrorTerm(1, -0.0004)))
    points, normal = around(np.array([0.8]), 30.0)
    probe = VirtualProbe(1.5)
    right, wrong = (probe.touch(knob(), points, normal, np.random.default_rng(0), e)[0] for e in (None, error))
    assert abs((wrong - right) @ normal[0] + np.array([0.001, -0.0004]) @ normal[0]) < 1e-7


def test_the_measuring_machine_errs_within_its_limits_and_its_frame() -> None:
    points, normal = around(np.linspace(0.2, 1.4, 400), 30.0)
    exact = VirtualCmm().measure(knob(), points, normal, np.random.default_rng(0))
    assert np.max(np.abs(exact)) < 1e-6
    limited = VirtualCmm(mpe_mm=0.001, mpe_per_mm=1e-5).measure(knob(), points, normal, np.random.default_rng(1))
    assert 0.0012 < np.max(np.abs(limited)) <= 0.0013
    framed = VirtualCmm(frame_mm=0.002).measure(knob(), points, normal, np.random.default_rng(2))
    shift = np.linalg.lstsq(normal, framed, rcond=None)[0]
    assert np.max(np.abs(framed - normal @ shift)) < 1e-6 and np.linalg.norm(shift) > 1e-4


def test_the_state_of_calibration_is_within_the_gauge() -> None:
    assert VirtualCmm(frame_mm=0.003, mpe_mm=0.003).standard_u_mm == pytest.approx(0.003 * math.sqrt(4 / 3))
