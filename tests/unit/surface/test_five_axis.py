"""Programs that turn the tool as it cuts, ball end and bull nose, by rotary words and vectors, to the simulated cut."""

from functools import cache

import numpy as np
import pytest

from tests.support.surfaces import left_on_mm, random_surface, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import Motion
from trueloop.surface.compensation.cutter import Cutter, ToolAxes, tool_axes
from trueloop.surface.compensation.program import corrected_program
from trueloop.surface.compensation.shift import SurfaceJob, corrected_surface
from trueloop_lab.simulator.zigzag import ZigzagOptions, scallop_step_mm

RNG = np.random.default_rng(43)
SIDE_MM, PLACES = 20.0, 17
NOMINAL = wavy_surface(SIDE_MM, 0.6)
PATTERN = random_surface(RNG, 6, 0.018)
BALL, BULL = Cutter(3.0, 3.0), Cutter(3.0, 1.0)
SCALLOP_MM = ZigzagOptions(3.0).scallop_mm
CHORD_MM, TOLERANCE_MM = 0.001, SurfaceJob(BALL).tolerance_mm
U, V = RNG.uniform(0.15, 0.85, (2, 150))


@cache
def corrected() -> Surface:
    return corrected_surface(NOMINAL, PATTERN).surface


def directions(first_deg: Array, second_deg: Array) -> Array:
    """R_z(C) R_x(A) z, written out."""
    a, c = np.radians(first_deg), np.radians(second_deg)
    return np.stack([np.sin(c) * np.sin(a), -np.cos(c) * np.sin(a), np.cos(a)], axis=1)


def source(cutter: Cutter, letters: str) -> Program:
    """A zig-zag of contacts; the tool leans by 15 to 25 degrees and turns by 40 along every pass."""
    passes = int(SIDE_MM / float(scallop_step_mm(3.0, SCALLOP_MM, np.array(0.02)))) + 1
    lines = ["G17 G21 G40 G90 G94", "G0 Z20"]
    for k, v in enumerate(np.linspace(0.0, 1.0, passes)):
        u = np.linspace(0.0, 1.0, PLACES)[:: -1 if k % 2 else 1]
        point, normal = NOMINAL.point_mm(u, np.full(PLACES, v)), NOMINAL.normal(u, np.full(PLACES, v))
        angles = np.stack([15 + 10 * u, 100 + 40 * u], axis=1).round(4)
        axis = directions(*angles.T)
        lean = normal - np.sum(normal * axis, axis=1, keepdims=True) * axis
        lean /= np.linalg.norm(lean, axis=1, keepdims=True)
        tips = point + cutter.corner_mm * (normal - axis) + cutter.ring_mm * lean
        for tip, turned, vector in zip(tips, angles, axis, strict=True):
            said = zip("AC" if letters == "CA" else letters, turned if letters == "CA" else vector, strict=True)
            place = " ".join(f"{name}{value:.6f}" for name, value in (*zip("XYZ", tip, strict=True), *said))
            lines.append(f"G1 {place} F300")
    return read_program("\n".join([*lines, "G0 Z20", "M2", ""]).encode(), "linuxcnc")


def left_by(program: Program, cutter: Cutter, letters: str) -> Array:
    """What the cutter leaves at (U, V): a ball on every one of many places of its ring, swept as the tool turns."""
    path = program.run()
    axes = tool_axes(program, path, letters, (0.0, 0.0, 1.0))
    cuts = np.flatnonzero(path.motion == Motion.LINE)[1:]
    move, share = np.repeat(cuts, 8), np.tile(np.arange(1, 9) / 8, len(cuts))
    tips = path.start_mm[move] + share[:, None] * (path.end_mm - path.start_mm)[move]
    axis = axes.directions(move, share)
    centres = tips + cutter.corner_mm * axis
    side = np.cross(axis, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(axis, side)
    points, normal = NOMINAL.point_mm(U, V), NOMINAL.normal(U, V)
    left = np.full(len(U), np.inf)
    for angle in np.linspace(0, 2 * np.pi, 90 if cutter.ring_mm else 1, endpoint=False):
        ring = centres + cutter.ring_mm * (np.cos(angle) * side + np.sin(angle) * other)
        left = np.minimum(left, left_on_mm(ring, cutter.corner_mm, points, normal))
    return left


@pytest.mark.parametrize(("cutter", "letters"), [(BALL, "CA"), (BULL, "CA"), (BULL, "IJK")])
def test_a_corrected_program_leaves_of_the_corrected_surface_what_its_source_left_of_the_nominal(
    cutter: Cutter, letters: str
) -> None:
    """Ridges and chords apart, which both leave alike, the envelope is the corrected surface."""
    program = source(cutter, letters)
    before = left_by(program, cutter, letters)
    assert np.max(before) < SCALLOP_MM + CHORD_MM
    assert np.min(before) > -CHORD_MM
    job = SurfaceJob(cutter, rotary=letters, gouge_mm=0.005)
    done = corrected_program(program, NOMINAL, corrected(), job, "0123456789abcdef")
    assert done.new_blocks > 10
    after = left_by(read_program(done.source, "linuxcnc"), cutter, letters)
    wanted = PATTERN.value_mm(U, V)
    assert np.max(np.abs(wanted)) > 5 * SCALLOP_MM
    np.testing.assert_allclose(after + wanted, before, atol=CHORD_MM + TOLERANCE_MM)
    assert np.max(after + wanted) < SCALLOP_MM + CHORD_MM + TOLERANCE_MM


def test_the_tool_turns_evenly_through_new_blocks() -> None:
    program = source(BULL, "CA")
    job = SurfaceJob(BULL, rotary="CA", gouge_mm=0.005)
    done = read_program(corrected_program(program, NOMINAL, corrected(), job, "0123456789abcdef").source, "linuxcnc")
    was, now = (tool_axes(p, p.run(), "CA", (0.0, 0.0, 1.0)) for p in (program, done))
    assert len(now.end) > len(was.end)
    steps = [np.linalg.norm(np.diff(axes.end, axis=0), axis=1) for axes in (was, now)]
    assert np.max(steps[1]) <= np.max(steps[0]) + 1e-3
    assert np.sum(steps[1]) == pytest.approx(np.sum(steps[0]), rel=1e-4)


def axes_of(text: str, letters: str) -> ToolAxes:
    program = read_program(text.encode(), "linuxcnc")
    return tool_axes(program, program.run(), letters, (0.0, 0.0, 1.0))


def test_rotary_words_stay_in_force_and_turn_right_handed() -> None:
    found = axes_of("G21 G90\nG0 X1 A90\nG1 X2 F100\nC90\nX3 A0\n/X4 A7\nX5\nM2\n", "CA")
    ends, at = np.arange(len(found.end)), np.ones(len(found.end))
    np.testing.assert_allclose(found.directions(ends, at), [[0, -1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose(found.directions(ends[2:3], 0 * at[:1]), [[1, 0, 0]], atol=1e-15)
    half = found.directions(ends[2:3], 0.5 * at[:1])[0]
    np.testing.assert_allclose(half, [np.sqrt(0.5), 0, np.sqrt(0.5)], atol=1e-15)
    tilted = axes_of("G21 G90\nG0 X1 B30\nM2\n", "B").directions(ends[:1], at[:1])[0]
    np.testing.assert_allclose(tilted, [0.5, 0, np.sqrt(0.75)], atol=1e-15)


@pytest.mark.parametrize(
    ("text", "letters", "message"),
    [
        ("G0 X0 Y5 Z5 A10\nG1 Z0 F100\nX9 A12\n", "", "A10 turns the tool"),
        ("G0 X0 Y5 Z5 A10 C0\nG1 Z0 F100\nX9 B3\n", "CA", "B3 turns the tool"),
        ("G0 X0 Y5 Z5\nG1 Z0 F100\nX9 A[2+3]\n", "A", "is computed"),
        ("G0 X0 Y5 Z5\nG1 Z0 F100\nX9\nA0 X0\n", "A", "before the tool's direction was said"),
        ("G0 X0 Y5 Z5 A0\nG1 Z0 F100\nX9\nA5\nX0\n", "A", "turned where it stood"),
        ("G0 X0 Y5 Z5 A0\nG1 Z0 F100\nG93\nX9 F3\nX0 F3\n", "A", "inverse-time feed"),
        ("G0 X0 Y5 Z5\nG1 Z0 F100\nG93\nX9 F3\nX0 F3\n", "", "inverse-time feed"),
    ],
)
def test_what_would_leave_the_tool_s_direction_unknown_is_refused(text: str, letters: str, message: str) -> None:
    flat = wavy_surface(SIDE_MM, 0.0)
    program = read_program(f"G17 G21 G90 G94\n{text}G0 Z20\nM2\n".encode(), "linuxcnc")
    with pytest.raises(TrueloopError, match=message) as told:
        corrected_program(program, flat, flat, SurfaceJob(BALL, rotary=letters), "0123456789abcdef")
    assert told.value.code is Code.SRF_PROGRAM
    assert told.value.place is not None


def test_a_still_tool_said_to_stand_straight_needs_no_naming() -> None:
    flat = wavy_surface(SIDE_MM, 0.0)
    program = read_program(b"G17 G21 G90 G94\nG0 X0 Y5 Z5 A0 C0\nG1 Z0 F100\nX9\nG0 Z20\nM2\n", "linuxcnc")
    done = corrected_program(program, flat, flat, SurfaceJob(BALL), "0123456789abcdef")
    assert done.cutting_moves == 2


def test_a_whole_turn_counts_although_the_tool_ends_as_it_began() -> None:
    turned = axes_of("G21 G90\nG0 X1 A10 C0\nG1 X2 A30 C360 F100\nM2\n", "CA").turned_deg(np.array([1]))
    assert turned[0] == pytest.approx(380.0)
    tilted = axes_of("G21 G90\nG0 X1 I0 J0 K1\nG1 X2 I0.5 J0 K0.8660254 F100\nM2\n", "IJK").turned_deg(np.array([1]))
    assert tilted[0] == pytest.approx(30.0, abs=1e-5)
