"""A shaft that came out bowed, from its touches to the surface that the corrected program cuts.

Under G42 in `test_contour_under_g42`, whose lines are bowed; here the short line whose bow such moves cannot follow.
"""

from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import WITHIN_MM, intended_mm, moved_mm
from tests.support.cli import run
from tests.support.correction import NOW
from tests.support.linuxcnc import Tool, interpret
from trueloop.arrays import Array
from trueloop.domain.part import PartType
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.paths import bends_lines
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.fit.prior.remembered_fit import Remembered
from trueloop.turned.options import Options
from trueloop.turned.touches.error_vectors import ErrorVectors

LENGTH, RADIUS, NOSE = 100.0, 20.0, 0.8

PROGRAM = """G21 G18 G7 G40 G90 G94
T1 M6
G97 S900 M3
G0 X46 Z5
G0 X41.6 Z2
G1 X41.6 Z-100 F100
G1 X44 Z-100
G0 X60
M2
"""

JOB = """[part]
name = "Bar"
x_is = "diameter"
start = [40, -100]
feature = [{ name = "cylinder", to = [40, 0] }]

[tool]
nose_radius_mm = 0.8
number = 1

[programs]
dialect = "linuxcnc"
finish = "finish.ngc"

[gauging]
touches = "touches.csv"

[output]
folder = "out"
"""


def left_on_mm(z_mm: Array, size_mm: float) -> Array:
    """What the lathe leaves on: the shaft yields in its middle, or, with the other sign, is pulled in."""
    return np.asarray(size_mm * np.sin(-np.pi * z_mm / LENGTH))


def cut_radius_mm(program: Path, z_mm: Array) -> Array:
    """The surface under the circles of the nose, whose centre LinuxCNC's own interpreter moves."""
    lowest = np.full(len(z_mm), np.inf)
    for move in interpret(program, tools=[Tool(1, NOSE)]):
        if move.kind == "rapid":
            continue
        assert move.kind == "line"
        (x0, _, z0), (x1, _, z1) = move.start_mm, move.end_mm
        for x, z in ((x0, z0), (x1, z1)):
            under = np.abs(z_mm - z) < NOSE
            lowest[under] = np.minimum(lowest[under], x - np.sqrt(NOSE**2 - (z_mm[under] - z) ** 2))
        if z0 != z1:
            slope = (x1 - x0) / (z1 - z0)
            z = z_mm - NOSE * slope / np.hypot(1.0, slope)
            within = (z > min(z0, z1)) & (z < max(z0, z1))
            below = x0 + slope * (z - z0) - NOSE / np.hypot(1.0, slope)
            lowest[within] = np.minimum(lowest[within], below[within])
    return lowest


@pytest.mark.parametrize("size_um", [15.0, 30.0, -30.0])
def test_the_next_shaft_is_straight(tmp_path: Path, size_um: float) -> None:
    """Six touches that scatter by 0.7 µm: of 15 or 30 µm at most 2 µm are left, with the sign the right way round."""
    rng, size = np.random.default_rng(4), size_um * 1e-3
    z = np.linspace(-95.0, -5.0, 6)
    radius = RADIUS + left_on_mm(z, size) + rng.normal(0.0, 0.0007, len(z))
    rows = [
        f"{k},cylinder,40.0,{at:.4f},{2.0 * r:.5f},{at:.4f}" for k, (at, r) in enumerate(zip(z, radius, strict=True))
    ]
    header = "point,feature,nominal_x_diameter_mm,nominal_z_mm,measured_x_diameter_mm,measured_z_mm"
    (tmp_path / "touches.csv").write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    (tmp_path / "finish.ngc").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "job.toml").write_text(JOB, encoding="utf-8")
    run("compensate", tmp_path / "job.toml")
    at = np.linspace(-98.0, -2.0, 97)
    given = cut_radius_mm(tmp_path / "finish.ngc", at) + left_on_mm(at, size) - RADIUS
    assert np.max(np.abs(given)) == pytest.approx(abs(size), abs=1e-5)
    left = cut_radius_mm(tmp_path / "out" / "corrected.ngc", at) + left_on_mm(at, size) - RADIUS
    assert np.sqrt(np.mean(left**2)) < 0.002


def collar(length_mm: float, bow_mm: float) -> Correction:
    """A collar between two shoulders, finished under G42 by a nose of 0.8 mm; its touches lie on a bow."""
    source = f"""G21 G7 G18 G40 G90 G94 F100 T1 M6
G0 X60 Z3
G0 G42 X30
G1 Z-10
X40
Z-{10 + length_mm:g}
X50
G0 G40 X60
M2
"""
    program = read_program(source.encode(), "linuxcnc")
    profile = contour_of_program(feed_moves(program.run()), NOSE).profile
    cylinder = [feature.start_mm[0] for feature in profile.features].index(20.0)
    s = np.linspace(NOSE + 0.2, profile.features[cylinder].length_mm - 0.1, 8)  # the nose leaves a fillet before that
    nominal = np.array([profile.features[cylinder].point_mm(at) for at in s])
    error = 0.02 + bow_mm * np.sin(np.pi * s / profile.features[cylinder].length_mm)
    error += np.tile([0.0003, -0.0003], 4)
    normal, u, no = np.tile([1.0, 0.0], (8, 1)), np.full(8, 5e-4), np.zeros(8, bool)
    names, index = tuple(map(str, range(8))), np.full(8, cylinder)
    touches = ErrorVectors(names, index, s, error, u, no, nominal, normal)
    options = Options(by="contour")
    return compensate(Inputs(PartType("collar"), profile, NOSE, program, touches, options, NOW))


def bow_from_memory(inputs: Inputs, own: ProfileErrorModel) -> tuple[Remembered, None]:
    """The collar's bow as earlier parts of an edge tell it, to within 0.1 µm."""
    collar = int(own.vectors.feature_index[0])
    length_mm = inputs.profile.features[collar].length_mm
    s = np.linspace(0.0, length_mm, 41)
    bow = 0.02 + 0.012 * np.sin(np.pi * s / length_mm)
    return Remembered(np.full(41, collar), s, bow, 1e-4**2 * np.eye(41), bow), None


@pytest.mark.parametrize(("length_mm", "follows"), [(4.0, False), (30.0, True)])
@pytest.mark.parametrize("remembered", [False, True], ids=["touched", "remembered"])
def test_a_line_too_short_for_the_nose_to_follow_its_bow_stays_straight_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, length_mm: float, follows: bool, remembered: bool
) -> None:
    """A bow of 12 µm bends by 1.4 µm over the 1.2 mm that the nose needs before a shoulder, where the line is 4 mm;
    so does one that earlier parts of the edge tell.
    """
    if remembered:
        monkeypatch.setattr("trueloop.loops.turned.process_intermittent.remembering", bow_from_memory)
    found = collar(length_mm, 0.012)
    stays = [note for note in found.notes if "which stays: under G41 or G42" in note]
    assert len(stays) == (0 if follows else 1)
    assert max(curve.spline.degree for curve in found.model.curves) > 1 if follows else not bends_lines(found.model)
    moved = moved_mm(found, found.corrected_program.decode(), tmp_path)
    assert np.abs(moved - intended_mm(found)).max() < WITHIN_MM + 0.0005
    left_mm = found.touches.error_mm + moved
    assert float(np.std(left_mm)) < 0.001 if follows else 0.002 < float(np.std(left_mm)) < 0.006
