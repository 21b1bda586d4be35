"""What a probing program does when the probe is off, a touch is missed, or something stands in the way: it stops.

Judged by a small control written apart (`tests/support/macro_control.py`), and for LinuxCNC by LinuxCNC itself.
"""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from tests.support.macro_control import Contact, Point, Ran, run_fanuc, run_siemens
from tests.support.probing import STEP, STYLUS, plan_of
from trueloop.arrays import Array
from trueloop.controllers.probing import WRITERS, Settings, probing_program
from trueloop.errors import Code, TrueloopError
from trueloop_lab.linuxcnc.session import ProbedPart, probe

PLAN = plan_of(STEP, {"cylinder": 3, "face": 1})
BALL_MM = STYLUS.ball_radius_mm
RUN: dict[str, Callable[[str, Contact], Ran]] = {
    "fanuc": lambda text, contact: run_fanuc(text, contact, 2),
    "haas": lambda text, contact: run_fanuc(text, contact, 3),
    "haas, skip kept": lambda text, contact: run_fanuc(text, contact, 3, skip_kept=True),
    "siemens": run_siemens,
}
MISSED = {"fanuc": 101, "haas": 101, "siemens": 65000}
OBSTRUCTED = {"fanuc": 102, "haas": 102, "siemens": 65001}


def run(control: str, contact: Contact, settings: Settings | None = None) -> Ran:
    text = probing_program(PLAN, control.split(",", maxsplit=1)[0], settings or Settings())
    ran = RUN[control](text, contact)
    assert settings is not None or not ran.other, ran.other
    return ran


def part(start: Point, end: Point) -> Point | None:
    """STEP: a cylinder of 40 mm radius and a face at z = 0, met by the ball's centre a radius away."""
    for share in np.linspace(0.0, 1.0, 2001):
        x, z = (a + share * (b - a) for a, b in zip(start, end, strict=True))
        if math.hypot(max(x - 40.0, 0.0), max(z, 0.0)) <= BALL_MM:
            return float(x), float(z)
    return None


def dead(start: Point, end: Point) -> Point | None:
    """A probe that is off."""
    return None


@pytest.mark.parametrize("control", RUN)
def test_every_touch_is_logged_and_no_alarm_comes(control: str) -> None:
    ran = run(control, part)
    assert ran.alarm is None and ran.ended
    assert len(ran.logged) == len(PLAN.touches)
    for logged, touch in zip(ran.logged, PLAN.touches, strict=True):
        assert math.dist(logged, touch.contact_mm) < 0.005


@pytest.mark.parametrize("control", RUN)
def test_a_probe_that_is_off_stops_at_the_first_touch(control: str) -> None:
    ran = run(control, dead)
    assert ran.alarm == MISSED[control.split(",", maxsplit=1)[0]]
    assert math.dist(ran.moves[-1][1], PLAN.touches[0].target_mm) < 1e-3
    assert not ran.logged


@pytest.mark.parametrize("control", RUN)
def test_a_touch_missed_later_stops_as_well(control: str) -> None:
    """The third is missed, also where the control leaves the touch before in its variables."""
    missed = PLAN.touches[2]

    def holed(start: Point, end: Point) -> Point | None:
        return None if math.dist(end, missed.target_mm) < 1e-3 else part(start, end)

    ran = run(control, holed)
    assert ran.alarm == MISSED[control.split(",", maxsplit=1)[0]] and len(ran.logged) == 2
    assert math.dist(ran.moves[-1][1], missed.target_mm) < 1e-3


@pytest.mark.parametrize("control", RUN)
def test_an_obstructed_way_stops_where_it_was_touched(control: str) -> None:
    """A chip stands on the cylinder between the first and the second touch, in the way of the ball."""

    def chip(start: Point, end: Point) -> Point | None:
        stop = (PLAN.touches[0].start_mm[0], -21.0)
        positioning = math.dist(end, PLAN.touches[1].start_mm) < 1e-3
        return stop if positioning else part(start, end)

    ran = run(control, chip)
    assert ran.alarm == OBSTRUCTED[control.split(",", maxsplit=1)[0]]
    assert ran.moves[-1][1] == (PLAN.touches[0].start_mm[0], -21.0) and len(ran.logged) == 1


@pytest.mark.parametrize("control", [name for name in WRITERS if name not in ("ge2000t", "linuxcnc")])
def test_no_way_between_touches_is_unprotected(control: str) -> None:
    """Only the way back from a touch to where it began is a plain feed move. LinuxCNC protects these by itself."""
    text = probing_program(PLAN, control, Settings())
    plain = [line for line in text.splitlines() if line.startswith("G1 ")]
    assert len(plain) == (0 if control == "renishaw" else len(PLAN.touches))


@pytest.mark.parametrize("control", WRITERS)
def test_codes_of_probe_and_spindle_stand_where_they_belong(control: str) -> None:
    """The spindle is held before anything moves; the probe is on before the first touch, and off after the way back."""
    settings = Settings(orient=("M19",), probe_on=("M51", "G4 P0.5"), probe_off=("M52",))
    text = probing_program(PLAN, control, settings)
    lines = [line.split(" ", 1)[-1] if control == "ge2000t" else line for line in text.splitlines()]
    found = [lines.index(code) for code in ("M19", "M51", "G4 P0.5", "M52")]
    moving = [k for k, line in enumerate(lines) if line.startswith(("G0 ", "G00 "))]
    touching = [
        k
        for k, line in enumerate(lines)
        if line.startswith(("G1 ", "G31", "G38", "MEAS", "G65 P9810", "G65 P9811", "G01 "))
    ]
    assert found == sorted(found)
    assert found[0] < moving[0] and found[2] < touching[0] and touching[-1] < found[3]
    assert "turns the probe on" not in text.lower()


@pytest.mark.parametrize("control", ["fanuc", "haas", "renishaw"])
def test_the_program_number_is_below_the_protected_ones(control: str) -> None:
    assert "\nO8100\n" in probing_program(PLAN, control, Settings())
    assert "\nO0123\n" in probing_program(PLAN, control, Settings(program_number=123))


def surface(*corners: Point) -> Array:
    """A surface through corners, points 0.05 mm apart."""
    pieces = [np.linspace(a, b, max(int(math.dist(a, b) / 0.05), 2)) for a, b in pairwise(corners)]
    return np.vstack(pieces)


WHOLE = ((40.0, -30.0), (40.0, 0.0), (0.0, 0.0))
CHIP = ((40.0, -30.0), (40.0, -21.5), (43.0, -21.2), (43.0, -20.8), (40.0, -20.5), (40.0, 0.0), (0.0, 0.0))
THIN = ((30.0, -30.0), (30.0, 0.0), (0.0, 0.0))


def linuxcnc(*corners: Point) -> str:
    text = probing_program(PLAN, "linuxcnc", Settings(probe_feed_mm_per_min=300.0))
    return probe(text.encode(), ProbedPart(surface(*corners), BALL_MM), "touches.txt")


def test_linuxcnc_logs_every_touch_of_a_clear_way() -> None:
    """And nothing else."""
    assert len(linuxcnc(*WHOLE).splitlines()) == len(PLAN.touches)


def test_linuxcnc_stops_where_a_way_is_obstructed() -> None:
    with pytest.raises(TrueloopError, match=r"(?i)probe tripped during non-probe move") as caught:
        linuxcnc(*CHIP)
    assert caught.value.code is Code.CTL_PROGRAM


def test_linuxcnc_stops_where_a_touch_is_missed() -> None:
    with pytest.raises(TrueloopError, match="without making contact") as caught:
        linuxcnc(*THIN)
    assert caught.value.code is Code.CTL_PROGRAM
