"""How long a program takes: sums and integrals by hand, and a slow sum over small steps."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.along import lengths_mm
from trueloop.nc.program.machining_time import machining_time
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath


def run(text: str, dialect: str = "fanuc-lathe") -> ToolPath:
    return read_program(text.encode(), dialect).run()


def test_feed_a_minute_rapid_and_dwell() -> None:
    """100 mm at 200 mm/min: 30 s; 50 mm at 3000 mm/min: 1 s; half a turn of radius 10 at 200 mm/min."""
    path = run("G21 G94\nG00 X30. Y40.\nG01 Y140. F200.\nG02 X50. I10. J0.\nG04 P2000", "fanuc-mill")
    time = machining_time(path, 3000.0)
    assert time.move_s == pytest.approx([1, 30, math.pi * 10 / 200 * 60])
    assert (time.rapid_s, time.dwell_s) == (1, 2)
    assert time.total_s == pytest.approx(33 + 3 * math.pi)


def test_inverse_time_and_a_helix() -> None:
    path = run("G21 G17 G93\nG1 X5 F4\nG94 F100\nG3 X5 Y0 Z30 I-5 J0 P2", "linuxcnc")
    turn = math.hypot(20 * math.pi, 30)
    assert lengths_mm(path) == pytest.approx([5, turn])
    assert machining_time(path, 1.0).move_s == pytest.approx([15, turn / 100 * 60])


def test_feed_a_revolution() -> None:
    """100 mm at 0.2 mm/rev are 500 revolutions, at 1000 1/min half a minute; a thread runs by its lead."""
    path = run("G21 G99 G97 S1000\nG01 Z-100. F.2\nG32 Z-110. F2.")
    assert machining_time(path, 1.0).move_s == pytest.approx([30, 0.3])


@pytest.mark.parametrize(
    ("block", "revolutions"),
    [
        ("G32 X26. Z-40. F2.", 20.0),  # 40 mm along Z, 3 along the radius
        ("G32 X100. Z-30. F2.", 20.0),  # 40 mm along the radius, 80 of diameter, 30 along Z
        ("G32 X80. Z-31. F2.", 15.5),  # of 30 mm along the radius and 31 along Z the latter, whatever X counts
        ("G92 X20. Z-40. R-30. F2.", 20.0),
    ],
)
def test_the_lead_of_a_tapered_thread_counts_on_the_axis_of_the_longer_travel(block: str, revolutions: float) -> None:
    """At 600 1/min a revolution takes a tenth of a second. Haas on G32: of the two leads the larger."""
    path = run(f"G21 G99 G97 S600\nG00 X20. Z0.\n{block}")
    cut = np.flatnonzero(path.motion == Motion.THREAD)
    assert machining_time(path, 1.0).move_s[cut] == pytest.approx([revolutions / 10])


def test_the_lead_of_linuxcnc_counts_along_the_thread(tmp_path: Path) -> None:
    """30 by 40 mm are 50: 25 revolutions of a lead of 2 mm, 2.5 s; with Sinumerik 40, 20 and 2 s."""
    linuxcnc = "G21 G18 G97 S600\nG0 X0 Z0\nG33 X30 Z-40 K2\n"
    path = run(linuxcnc, "linuxcnc")
    assert machining_time(path, 1.0, lead_along_thread=True).cutting_s == pytest.approx(2.5)
    sinumerik = run("G71 G18 DIAMOF G97 S600\nG0 X0 Z0\nG33 X30 Z-40 K2", "siemens")
    assert machining_time(sinumerik, 1.0).cutting_s == pytest.approx(2.0)
    file = tmp_path / "taper.ngc"
    file.write_text(linuxcnc + "M2\n")
    said = invoke("nc", "time", file, "--dialect", "linuxcnc", "--rapid-mm-min", "1000", "--json", status=0)
    assert json.loads(said.stdout)["seconds"]["cutting"] == pytest.approx(2.5)


def test_a_cylinder_under_constant_surface_speed() -> None:
    """v = 120 m/min at diameter 40: n = 120000 / (40 pi) 1/min. X counts diameters: at radius 40 it would be half."""
    path = run("G21 G99 G96 S120\nG00 X40. Z0.\nG01 Z-50. F.25")
    speed = 120000 / (40 * math.pi)
    assert machining_time(path, 6000.0).move_s[1] == pytest.approx(50 / (0.25 * speed) * 60)
    inch = run("G20 G99 G96 S400\nG00 X2. Z0.\nG01 Z-1. F.01")
    assert machining_time(inch, 6000.0).move_s[1] == pytest.approx(100 / (400 * 12 / (2 * math.pi)) * 60)


def test_a_face_under_constant_surface_speed_and_its_limit() -> None:
    """From radius 50 to the axis: t = 2 pi / (v f) * (50^2 - r^2) / 2 down to r = v / (2 pi n), then r / (f n)."""
    path = run("G21 G99 G50 S2000\nG96 S200\nG00 X100. Z0.\nG01 X0. F.2")
    bound = 200000 / (2 * math.pi * 2000)
    minutes = 2 * math.pi / (200000 * 0.2) * (50**2 - bound**2) / 2 + bound / (0.2 * 2000)
    assert machining_time(path, 6000.0).move_s[1] == pytest.approx(60 * minutes, rel=1e-3)
    slower = machining_time(path, 6000.0, max_rpm=1000.0).move_s[1]
    assert slower > machining_time(path, 6000.0, max_rpm=5000.0).move_s[1] == pytest.approx(60 * minutes, rel=1e-3)


def test_an_arc_under_constant_surface_speed_against_small_steps() -> None:
    """From (x, z) = (20, 0) clockwise to (30, -10) about (30, 0): the radius at each of 100000 steps."""
    path = run("G21 G99 G96 S150\nG00 X40. Z0.\nG02 X60. Z-10. I10. K0. F.1")
    angle = np.linspace(0, math.pi / 2, 100_001)
    x = 30 - 10 * np.cos(angle)
    assert path.end_mm[1] == pytest.approx([30, 0, -10])
    x = np.abs(x)
    minutes = np.mean((x[1:] + x[:-1]) / 2) * 2 * math.pi / 150000 * (10 * math.pi / 2) / 0.1
    assert abs(path.sweep_rad[1]) == pytest.approx(math.pi / 2)
    assert machining_time(path, 1.0).move_s[1] == pytest.approx(60 * minutes, rel=1e-4)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("G21 G01 Z-1.", "a cut without a feed"),
        ("G21 G99 G01 Z-1. F.1", "a cut without a spindle speed"),
        ("G21 G99 G96 S100 G01 Z-1. F.1", "a cut without a spindle speed"),
    ],
)
def test_a_time_that_is_not_known(text: str, what: str) -> None:
    with pytest.raises(TrueloopError, match=what) as refused:
        machining_time(run(text), 1.0)
    assert refused.value.code == Code.NC_FEED


def test_a_dwell_in_revolutions_is_refused() -> None:
    with pytest.raises(TrueloopError, match="a dwell without a time"):
        machining_time(run("G71 G1 X1 F100\nG4 S30", "siemens"), 1.0)
