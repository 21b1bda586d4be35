"""Two touches a point: what is recorded is the second one, slow, from as far away as the probe file says.

Judged by the small control of `tests/support/macro_control.py`, and for LinuxCNC by LinuxCNC itself. The part latches
late in a fast touch: a log that held the first one would be wrong by that.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.macro_control import Contact, Point, Ran
from tests.support.probing import APPROACH, STEP, STYLUS, plan_of
from tests.unit.controllers.test_probing_alarms import RUN, THIN, WHOLE, part, surface
from trueloop.arrays import Array
from trueloop.controllers.probing import Settings, probing_program
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.touches_csv import LoggedTouch, parse_probe_log
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.validate import checked_profile
from trueloop.probing.calibration import BallCalibration
from trueloop.probing.probe_match import match_touches
from trueloop.probing.probe_plan import ProbePlan, SecondTouch
from trueloop_lab.linuxcnc.session import ProbedPart, probe

BACK_OFF_MM, SLOW = 0.4, 30.0
SECOND = SecondTouch(BACK_OFF_MM, SLOW)
ROUND = checked_profile(
    [
        Line("cylinder", (40.0, -30.0), (40.0, -10.0)),
        Arc("ball", (40.0, -10.0), (30.0, 0.0), (30.0, -10.0), math.pi / 2),
        Line("face", (30.0, 0.0), (0.0, 0.0)),
    ]
)
PLAN = plan_of(STEP, {"cylinder": 3, "face": 1}, replace(APPROACH, second=SECOND))
ROUND_PLAN = plan_of(ROUND, {"cylinder": 2, "ball": 3, "face": 1}, replace(APPROACH, second=SECOND))
LATE_MM = 0.03
STILL = {"fanuc": 103, "haas": 103, "siemens": 65002}
MISSED = {"fanuc": 101, "haas": 101, "siemens": 65000}


def run(control: str, contact: Contact, plan: ProbePlan = PLAN) -> Ran:
    ran = RUN[control](probing_program(plan, name_of(control), Settings(probe_feed_mm_per_min=600.0)), contact)
    assert not ran.other, ran.other
    return ran


def name_of(control: str) -> str:
    return control.split(",", maxsplit=1)[0]


def late(start: Point, end: Point) -> Point | None:
    """A first touch, from far away, is latched 30 µm too deep."""
    met = part(start, end)
    if met is None or math.dist(start, met) < 2 * BACK_OFF_MM:
        return met
    share = LATE_MM / math.dist(start, end)
    return met[0] + share * (end[0] - start[0]), met[1] + share * (end[1] - start[1])


@pytest.mark.parametrize("control", RUN)
def test_the_slow_touch_is_recorded(control: str) -> None:
    ran = run(control, late)
    assert ran.alarm is None and ran.ended and len(ran.logged) == len(PLAN.touches)
    for logged, touch in zip(ran.logged, PLAN.touches, strict=True):
        assert math.dist(logged, touch.contact_mm) < 0.005


@pytest.mark.parametrize("control", RUN)
def test_the_ball_backs_off_along_the_normal_from_where_it_touched(control: str) -> None:
    """Also on a ball, where both axes move: fast touch, back, slow touch, back to where the approach began."""
    ran = run(control, rounded, ROUND_PLAN)
    assert ran.alarm is None and len(ran.logged) == len(ROUND_PLAN.touches)
    feeds = [float(line.rpartition("F")[2]) if "F" in line else 0.0 for line in ran.lines]
    for touch in ROUND_PLAN.touches:
        first = next(k for k, (_, end) in enumerate(ran.moves) if math.dist(end, touch.contact_mm) < 0.005)
        fast, back, slow, away = ran.moves[first : first + 4]
        assert feeds[first : first + 4] == [600.0, 2000.0, SLOW, 2000.0]
        np.testing.assert_allclose(
            np.subtract(back[1], fast[1]), BACK_OFF_MM * np.array(touch.normal), rtol=0.0, atol=2e-4
        )
        assert math.dist(slow[1], touch.contact_mm) < 0.005 and math.dist(away[1], touch.start_mm) < 2e-4


def rounded(start: Point, end: Point) -> Point | None:
    """`ROUND`, met by the ball's centre a radius away."""
    for share in np.linspace(0.0, 1.0, 2001):
        x, z = (a + share * (b - a) for a, b in zip(start, end, strict=True))
        if math.hypot(max(x - 30.0, 0.0), max(z + 10.0, 0.0)) <= 10.0 + STYLUS.ball_radius_mm:
            return float(x), float(z)
    return None


@pytest.mark.parametrize("control", RUN)
def test_a_probe_that_stays_triggered_stops_and_records_nothing(control: str) -> None:
    """It would trip at once, off the part by the way backed off."""

    def stuck(start: Point, end: Point) -> Point | None:
        return start if part(start, end) and math.dist(start, PLAN.touches[0].contact_mm) < 0.5 else part(start, end)

    ran = run(control, stuck)
    assert ran.alarm == STILL[name_of(control)] and not ran.logged
    away = np.subtract(ran.moves[-1][1], PLAN.touches[0].contact_mm)
    np.testing.assert_allclose(away, BACK_OFF_MM * np.array(PLAN.touches[0].normal), rtol=0.0, atol=2e-3)


@pytest.mark.parametrize("missed", ["first", "second"])
@pytest.mark.parametrize("control", RUN)
def test_a_missed_touch_stops_and_shifts_nothing(control: str, missed: str) -> None:
    """At the third point: the two before it are recorded as touched, the others named when the log is read."""
    target = PLAN.touches[2].target_mm

    def holed(start: Point, end: Point) -> Point | None:
        slow = math.dist(start, end) < APPROACH.stand_off_mm + APPROACH.overtravel_mm - 0.1
        return None if math.dist(end, target) < 1e-3 and slow == (missed == "second") else part(start, end)

    ran = run(control, holed)
    assert ran.alarm == MISSED[name_of(control)] and math.dist(ran.moves[-1][1], target) < 1e-3
    assert len(ran.logged) == 2
    for logged, touch in zip(ran.logged, PLAN.touches, strict=False):
        assert math.dist(logged, touch.contact_mm) < 0.005
    with pytest.raises(TrueloopError, match="2 of 4 points have no touch: '3', '4'"):
        match_touches(PLAN, ran.logged, [1, 2], BallCalibration(STYLUS.ball_radius_mm))


def linuxcnc(settings: Settings, *corners: Point) -> list[LoggedTouch]:
    text = probing_program(PLAN, "linuxcnc", settings)
    log = probe(text.encode(), ProbedPart(surface(*corners), STYLUS.ball_radius_mm), settings.log)
    return parse_probe_log(log, settings.log, "linuxcnc", inch=settings.inch, diameter=settings.diameter)


@pytest.mark.parametrize(("inch", "diameter"), [(False, True), (True, False), (True, True)])
def test_linuxcnc_logs_the_slow_touch_alone(inch: bool, diameter: bool) -> None:
    """A touch at 1200 mm/min is latched up to 20 µm deep, one at 30 mm/min 0.5 µm. X of a log is a radius always."""
    logged = linuxcnc(Settings(inch=inch, diameter=diameter, probe_feed_mm_per_min=1200.0), *WHOLE)
    assert len(logged) == len(PLAN.touches)
    for found, touch in zip(logged, PLAN.touches, strict=True):
        assert math.dist(found.position_mm, touch.contact_mm) < 0.0015


def test_linuxcnc_stops_where_a_touch_is_missed() -> None:
    with pytest.raises(TrueloopError, match="without making contact") as caught:
        linuxcnc(Settings(probe_feed_mm_per_min=300.0), *THIN)
    assert caught.value.code is Code.CTL_PROGRAM


def test_a_log_that_holds_both_touches_is_refused_with_its_rows() -> None:
    """As LinuxCNC's PROBEOPEN would write it."""
    normal = np.array([touch.normal for touch in PLAN.touches])
    contact: Array = np.array([touch.contact_mm for touch in PLAN.touches])
    both = np.repeat(contact, 2, axis=0)
    both[::2] -= LATE_MM * normal
    rows = [(float(x), float(z)) for x, z in both]
    with pytest.raises(TrueloopError, match="point '1' was touched 2 times, in lines 1, 2") as caught:
        match_touches(PLAN, rows, range(1, 9), BallCalibration(STYLUS.ball_radius_mm))
    assert caught.value.code is Code.PRB_TWICE
