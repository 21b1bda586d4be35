"""The corrected surface and the corrected program: they take away what the pattern says was left on."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import interpret
from tests.support.surfaces import ball_centres, left_on_mm, random_surface, sphere, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import closest, fit_grid
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import Program, read_program
from trueloop.surface.compensation.cutter import Cutter, contacts
from trueloop.surface.compensation.program import corrected_program, depths_mm
from trueloop.surface.compensation.shift import CorrectedSurface, SurfaceJob, corrected_surface
from trueloop.surface.separation.spline_surface import Size, SplineSurface
from trueloop_lab.simulator.zigzag import ZigzagOptions, program_text, zigzag

RNG = np.random.default_rng(41)
NOMINAL = wavy_surface(20.0, 1.5)
PATTERN = random_surface(RNG, 7, 0.025)
SCALLOP_MM, CHORD_MM, RADIUS_MM = 0.002, 0.001, 3.0
OPTIONS = ZigzagOptions(RADIUS_MM, SCALLOP_MM, CHORD_MM)
BALL = SurfaceJob(Cutter(RADIUS_MM, RADIUS_MM))
U, V = RNG.uniform(0.06, 0.94, (2, 400))


@cache
def corrected() -> CorrectedSurface:
    return corrected_surface(NOMINAL, PATTERN)


@cache
def source() -> Program:
    text = program_text(zigzag(NOMINAL, OPTIONS), dialect_named("linuxcnc"), OPTIONS)
    return read_program(text.encode(), "linuxcnc")


@cache
def written() -> bytes:
    return corrected_program(source(), NOMINAL, corrected().surface, BALL, "0123456789abcdef").source


def test_a_dome_is_corrected_up_to_its_pole() -> None:
    """10 µm evenly off a ball of 20 mm is a ball of 19.99 mm; one that changes around the pole is not steep there."""
    even = SplineSurface(Size(4, 4), np.full((4, 4), 0.01))
    lower, at = corrected_surface(sphere(20.0), even).surface, np.linspace(0, 1, 23)
    np.testing.assert_allclose(np.linalg.norm(lower.grid_mm(at, at), axis=2), 19.99, atol=1e-4)
    uneven = SplineSurface(Size(4, 4), 0.002 * np.add.outer(np.arange(4), 0 * np.arange(4)))
    assert corrected_surface(sphere(20.0), uneven).largest_shift_mm == pytest.approx(0.006)


def left_by(program: bytes) -> Array:
    centres = ball_centres(program, RADIUS_MM)
    return left_on_mm(centres, RADIUS_MM, NOMINAL.point_mm(U, V), NOMINAL.normal(U, V))


@pytest.mark.parametrize("weight", [0.5, 1.0])
def test_the_corrected_surface_stands_off_the_nominal_by_minus_w_times_the_pattern(weight: float) -> None:
    found = corrected_surface(NOMINAL, PATTERN, weight=weight, tolerance_mm=1e-4)
    shift = closest(found.surface, NOMINAL.point_mm(U, V)).distance_mm
    # Nominal above the corrected surface where material was left on. The foot is not on the same normal: second order.
    np.testing.assert_allclose(shift, weight * PATTERN.value_mm(U, V), atol=2e-4)
    assert found.worst_mm <= 1e-4


def test_turned_over_normals_turn_the_correction_over() -> None:
    up, down = (corrected_surface(s, PATTERN).surface for s in (NOMINAL, NOMINAL.turned_over()))
    np.testing.assert_allclose(
        up.grid_mm(U[:5], V[:5]) + down.grid_mm(U[:5], V[:5]), 2 * NOMINAL.grid_mm(U[:5], V[:5]), atol=3e-4
    )


def test_a_zigzag_leaves_ridges_below_the_scallop_height() -> None:
    left = left_by(source().source)
    assert np.max(left) <= SCALLOP_MM + CHORD_MM
    assert np.max(left) > 0.5 * SCALLOP_MM  # and not far below: passes would be wasted
    assert np.min(left) >= -1.2 * CHORD_MM


def test_the_corrected_program_cuts_the_pattern_s_negative_within_the_scallop_height() -> None:
    left = left_by(written()) + PATTERN.value_mm(U, V)
    assert np.max(np.abs(PATTERN.value_mm(U, V))) > 8 * SCALLOP_MM
    assert np.max(left) <= SCALLOP_MM + CHORD_MM + BALL.tolerance_mm
    assert np.min(left) >= -(CHORD_MM + BALL.tolerance_mm)


def test_linuxcnc_runs_the_corrected_program_where_we_say() -> None:
    ours = read_program(written(), "linuxcnc").run()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "corrected.ngc"
        path.write_bytes(written())
        theirs = interpret(path, startup="G17 G21 G40 G90 G94")
    lines = [move for move in theirs if move.kind == "line"]
    wanted = ours.end_mm[ours.motion == 1]
    np.testing.assert_allclose(np.array([move.end_mm for move in lines]), wanted, atol=1e-9)


@pytest.mark.parametrize("ending", ["G91 G28 X0. Y0.", "G91 G28 Z0.\nG28 X0. Y0.", "G91 G00 X5. Y5. Z20."])
def test_increments_behind_the_last_cut_start_where_it_ends_displaced(ending: str) -> None:
    """As post-processors end a program; the words stay, and what they move is as far off as the cut before them."""
    text = program_text(zigzag(NOMINAL, OPTIONS), dialect_named("fanuc-mill"), OPTIONS)
    given = read_program(text.replace("\nM5\n", f"\n{ending}\nM5\n").encode(), "fanuc-mill")
    found = corrected_program(given, NOMINAL, corrected().surface, BALL, "0123456789abcdef").source
    assert f"\n{ending}\n".encode() in found
    before, after = (program.run().end_mm[-1] for program in (given, given.rewritten(found)))
    if "G28" not in ending:
        assert 1e-4 < float(np.max(np.abs(after - before)[:2])) < 0.025


def test_feeds_stay_and_long_moves_are_split_where_the_correction_bends() -> None:
    flat = wavy_surface(20.0, 0.0)
    text = "G21 G90 G94 G17\nG0 X0 Y10 Z5\nN10 G1 Z0 F100\nN20 X20 F300\nN30 Y11\nN40 X0\nG0 Z5\nM2\n"
    job = SurfaceJob(Cutter(3.0, 3.0), tolerance_mm=5e-4)
    program = read_program(text.encode(), "linuxcnc")
    surface = corrected_surface(flat, PATTERN).surface
    done = corrected_program(program, flat, surface, job, "0123456789abcdef")
    assert done.new_blocks > 10
    path = read_program(done.source, "linuxcnc").run()
    assert set(path.feed[~path.rapid]) == {100.0, 300.0}
    tips = path.end_mm[path.motion == 1]
    gap = contacts(surface, job.cutter, tips, np.tile([0.0, 0, 1], (len(tips), 1))).gap_mm
    np.testing.assert_allclose(gap, 0.0, atol=2e-5)  # the control's resolution


@pytest.mark.parametrize(
    ("corner_mm", "axis"), [(1.0, (0.0, 0.0, 1.0)), (0.0, (0.1, 0.05, 1.0)), (3.0, (0.2, 0.0, 1.0))]
)
def test_bull_nose_flat_and_tilted_cutters_touch_where_the_surface_says(
    corner_mm: float, axis: tuple[float, float, float]
) -> None:
    cutter, up = Cutter(3.0, corner_mm), np.array(axis) / np.linalg.norm(axis)
    point, normal = NOMINAL.point_mm(U, V), NOMINAL.normal(U, V)
    lean = normal - (normal @ up)[:, None] * up
    lean /= np.linalg.norm(lean, axis=1, keepdims=True)
    tips = point + corner_mm * (normal - up) + cutter.ring_mm * lean
    found = contacts(NOMINAL, cutter, tips, np.tile(up, (len(tips), 1)))
    touched = found.feet.beyond_mm == 0
    assert np.mean(touched) > 0.9
    # A ring wider than the surface's hollows touches deeper elsewhere: never farther than the contact it was put on.
    assert np.max(found.gap_mm[touched]) < 1e-9
    if corner_mm == 3.0:
        np.testing.assert_allclose(found.gap_mm, 0.0, atol=1e-9)


@pytest.mark.parametrize("corner_mm", [1.0, 0.0])
def test_a_flat_bottom_in_a_hollow_narrower_than_the_cutter_is_a_gouge(corner_mm: float) -> None:
    """At the bottom of a trough of radius 8 mm the surface is level: the tool seems to touch with its middle alone."""
    x, y = np.meshgrid(np.linspace(-5, 5, 41), np.linspace(-5, 5, 41), indexing="ij")
    trough = fit_grid(np.stack([x, y, 8 - np.sqrt(64 - y**2)], axis=2)).surface
    up, tip = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, 0.0]])
    assert depths_mm(trough, Cutter(3.0, 3.0), tip, up)[0] == pytest.approx(0.0, abs=1e-6)
    ring = 3.0 - corner_mm
    across = np.hypot(ring, 8 - corner_mm) - (8 - corner_mm)
    assert depths_mm(trough, Cutter(3.0, corner_mm), tip, up)[0] == pytest.approx(across, abs=1e-4)
    lift = 8 - corner_mm - np.sqrt((8 - corner_mm) ** 2 - ring**2)
    assert depths_mm(trough, Cutter(3.0, corner_mm), tip + lift * up, up)[0] == pytest.approx(0.0, abs=1e-4)


def test_half_the_weight_corrects_by_half() -> None:
    half = corrected_surface(NOMINAL, PATTERN, weight=0.5)
    assert half.largest_shift_mm == pytest.approx(0.5 * corrected().largest_shift_mm, rel=1e-12)


FLAT = wavy_surface(20.0, 0.0)
WAY_OUT = "G21 G90 G94 G18\nG0 X2 Y10 Z5\nG1 Z0 F100\nX3\n{}\nG0 Z5\nM2\n"


def on_flat(text: str, dialect: str = "linuxcnc") -> bytes:
    surface = corrected_surface(FLAT, PATTERN).surface
    return corrected_program(read_program(text.encode(), dialect), FLAT, surface, BALL, "0123456789abcdef").source


@pytest.mark.parametrize(
    ("way", "line", "what"),
    [
        ("G2 X5 Z2 I0 K2", 5, "1 arcs begin, end or run on the surface"),
        ("G2 X5 Z2 R2", 5, "1 arcs begin, end or run on the surface"),
        ("X30\nG2 X32 Z2 I0 K2", 6, "µm from where it did"),
        ("X30\nG2 X32 Z2 R2", 6, "µm from where it did"),
    ],
)
def test_an_arc_whose_start_is_displaced_is_refused_at_its_line(way: str, line: int, what: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        on_flat(WAY_OUT.format(way))
    assert refused.value.code is Code.SRF_PROGRAM and what in refused.value.message
    assert refused.value.place.line == line


def test_an_arc_after_a_move_that_names_every_axis_stays() -> None:
    assert b"X30 Z0\nG2 X32 Z2 I0 K2\n" in on_flat(WAY_OUT.format("X30 Z0\nG2 X32 Z2 I0 K2"))


def test_klartext_is_corrected_by_lines_of_its_own() -> None:
    """The same cuts in G code are moved to the same places."""
    klartext = (
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1\n2 L X+2 Y+10 Z+5 FMAX\n3 L Z+0 F100\n4 L X+18 R0 F90\n5 L Z+5 FMAX\n"
    )
    ours = read_program(on_flat(klartext + "6 END PGM A MM\n", "heidenhain"), "heidenhain").run()
    same = read_program(on_flat(WAY_OUT.format("X18")), "linuxcnc").run()
    first, last = (path.end_mm[1:3] for path in (ours, same))
    np.testing.assert_allclose(first[0], last[0], atol=1e-4)
    assert len(ours) > 10 and set(ours.feed[2:-1]) == {90.0}
    assert np.abs(ours.end_mm[:, 1] - 10.0).max() < 1e-9


@pytest.mark.parametrize("way", ["APPR LT X+2 LEN5", "APPR CT X+2 CCA90 R+5"])
def test_a_way_to_the_contour_whose_end_the_correction_displaces_is_refused(way: str) -> None:
    """The control makes the way between its start and the contour: no block can be added there."""
    text = f"0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1\n2 L X-9 Y+10 Z+0 FMAX\n3 {way} Z+0 R0 F100\n4 L X+18\n5 L Z+5 FMAX\n"
    with pytest.raises(TrueloopError) as refused:
        on_flat(text, "heidenhain")
    assert "APPR" in refused.value.message and refused.value.place.line == 4
