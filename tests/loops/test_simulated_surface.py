"""The loop of a surface on the virtual mill: what it finds and what it leaves, held against the truth."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.support.surfaces import random_surface, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import read_program
from trueloop.statistics import rms
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.shift import SurfaceJob
from trueloop_lab.files.virtual_machine_toml import mill_and_trial
from trueloop_lab.loops.surface import SimulatedSurface, SurfaceTrial, simulate_surface, surface_trial
from trueloop_lab.simulator.machine import SurfaceProcess
from trueloop_lab.simulator.mill import EndMill, VirtualMill
from trueloop_lab.simulator.zigzag import ZigzagOptions, program_text, zigzag

EXAMPLE = Path(__file__).parents[2] / "examples" / "surface"


@cache
def example() -> tuple[VirtualMill, SurfaceTrial]:
    mill, trial = mill_and_trial(EXAMPLE / "simulate.toml", EXAMPLE / "mill.toml")
    # Whether points lie on the trimmed face is asked elsewhere, and takes the CAD kernel long.
    return mill, replace(trial, inputs=replace(trial.inputs, trim=None))


@cache
def made() -> SimulatedSurface:
    mill, trial = example()
    return simulate_surface(trial, mill, parts=6, seed=3)


def less_ridges_mm(deviation_mm: Array) -> Array:
    left: Array = deviation_mm - made().ridges_mm
    return left


def test_one_correction_leaves_little_but_the_ridges_of_the_program() -> None:
    before, after = rms(made().truth_mm), rms(made().corrected_truth_mm)
    assert after < 0.4 * before
    # The next part differs from the pattern by about 1 µm, of which the best fit takes some.
    assert after < np.hypot(rms(made().ridges_mm), 1.1e-3)


def test_the_pattern_found_is_what_the_parts_have_alike() -> None:
    """Ridges that the grid of touches misses are no part of it."""
    off_mm = less_ridges_mm(made().pattern_truth_mm) - made().pattern_mm
    assert rms(off_mm) < 0.6 * rms(made().pattern_u95_mm) < 0.6 * rms(made().pattern_truth_mm)
    assert np.mean(np.abs(off_mm) <= made().pattern_u95_mm) > 0.85


def test_the_loop_promises_what_the_next_part_is_measured_to_have() -> None:
    assert rms(made().corrected_measured_mm) == pytest.approx(rms(made().predicted_mm), rel=0.2)


def small() -> SurfaceTrial:
    """A surface of 16 mm, soon simulated."""
    surface, options = wavy_surface(side_mm=16.0), ZigzagOptions(8.0, scallop_mm=0.005, chord_mm=0.005)
    text = program_text(zigzag(surface, options), dialect_named("linuxcnc"), options)
    program = read_program(text.encode(), "linuxcnc")
    return surface_trial(replace(example()[1].inputs, surface=surface, program=program), (10, 10))


def test_the_same_seed_gives_the_same_parts_and_another_one_others() -> None:
    first, again, other = (simulate_surface(small(), example()[0], parts=3, seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(again.corrected_measured_mm, first.corrected_measured_mm)
    assert rms(other.measured_mm - first.measured_mm) > 1e-3
    assert rms(first.measured_mm[0] - first.measured_mm[1]) > 1e-3


def test_a_program_that_does_not_cut_the_surface_is_refused() -> None:
    _, trial = example()
    short = b"G17 G21 G90 G94\nG0 X0 Y0 Z9\nG1 X0 Y0 Z0 F300\nG1 X50\nG0 Z9\nM2\n"
    inputs = replace(trial.inputs, program=read_program(short, "linuxcnc"))
    with pytest.raises(TrueloopError, match="places are not cut") as refused:
        mill, _ = example()
        simulate_surface(surface_trial(inputs, (25, 25)), mill)
    assert refused.value.code is Code.SIM_MILL


@pytest.mark.parametrize(
    ("words", "program"),
    [
        ("0 of 1 moves are straight", b"G21 G0 X0\nM2\n"),
        ("1 of 2 moves are arcs", b"G17 G21 G1 X0 Y0 F9\nG2 X10 Y0 I5\nM2\n"),
    ],
)
def test_a_program_that_the_mill_cannot_follow_is_refused(words: str, program: bytes) -> None:
    _, trial = example()
    with pytest.raises(TrueloopError, match=words):
        surface_trial(replace(trial.inputs, program=read_program(program, "linuxcnc")), (25, 25))


LEAN = (0.25, 0.05, 0.95)


def leaning(cutter: Cutter, axis: tuple[float, float, float]) -> SurfaceTrial:
    """A zig-zag over a surface of 16 mm by a cutter whose tip is programmed, its axis fixed."""
    surface, job = (
        wavy_surface(side_mm=16.0, height_mm=0.8),
        SurfaceJob(cutter, axis, tolerance_mm=1e-4, gouge_mm=0.005),
    )
    u, rows = np.linspace(0.0, 1.0, 33), np.linspace(0.0, 1.0, 97)
    direction = np.asarray(axis) / np.linalg.norm(axis)
    lines = ["G17 G21 G40 G90 G94", "G0 Z20"]
    for k, v in enumerate(rows.tolist()):
        at = u[:: -1 if k % 2 else 1], np.full(len(u), v)
        mill = EndMill(cutter, (float(direction[0]), float(direction[1]), float(direction[2])))
        tips = mill.centres_mm(surface.point_mm(*at), surface.normal(*at)) - cutter.corner_mm * direction
        lines += [f"G1 X{x:.6f} Y{y:.6f} Z{z:.6f} F300" for x, y, z in tips.tolist()]
    program = read_program("\n".join([*lines, "G0 Z20", "M2", ""]).encode(), "linuxcnc")
    inputs = example()[1].inputs
    options = replace(inputs.options, best_fit=False)
    return surface_trial(replace(inputs, surface=surface, program=program, cutter=job, options=options), (20, 20))


@pytest.mark.parametrize(
    ("cutter", "axis"),
    [(Cutter(3.0, 3.0), LEAN), (Cutter(3.0, 1.0), (0.0, 0.0, 1.0)), (Cutter(3.0, 1.0), LEAN), (Cutter(2.0, 0.0), LEAN)],
    ids=["ball that leans", "bull nose", "bull nose that leans", "flat end that leans"],
)
def test_corrected_programs_of_every_cutter_leave_little_but_ridges(
    cutter: Cutter, axis: tuple[float, float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where parts do not differ and hardly anything scatters, what is wrong with them, ridges apart, is gone."""
    monkeypatch.setattr("trueloop_lab.loops.surface.JUDGED", (31, 29))
    trial = leaning(cutter, axis)
    process = SurfaceProcess(random_surface(np.random.default_rng(5), 5, 0.020), 0.0, 0.0, 1e-5)
    done = simulate_surface(trial, VirtualMill(process, grid=(20, 20)), parts=3, seed=1)
    before, after = (values - done.ridges_mm for values in (done.truth_mm[0], done.corrected_truth_mm))
    assert rms(after) < 0.1 * rms(before)


def turning_over(cutter: Cutter, letters: str) -> SurfaceTrial:
    """A zig-zag over a surface of 16 mm by a cutter that leans and turns by some 20° along every pass."""
    surface, job = (
        wavy_surface(side_mm=16.0, height_mm=0.8),
        SurfaceJob(cutter, tolerance_mm=1e-4, gouge_mm=0.005, rotary=letters),
    )
    u, lines = np.linspace(0.0, 1.0, 33), ["G17 G21 G40 G90 G94", "G0 Z20"]
    for k, v in enumerate(np.linspace(0.0, 1.0, 97).tolist()):
        at = u[:: -1 if k % 2 else 1]
        words, axes = turned(at, letters)
        contact, normal = surface.point_mm(at, np.full(33, v)), surface.normal(at, np.full(33, v))
        across = normal - np.sum(normal * axes, axis=1, keepdims=True) * axes
        lean = across / np.linalg.norm(across, axis=1, keepdims=True)
        tips = contact + cutter.corner_mm * (normal - axes) + cutter.ring_mm * lean
        lines += [
            f"G1 X{x:.6f} Y{y:.6f} Z{z:.6f}{word} F300" for (x, y, z), word in zip(tips.tolist(), words, strict=True)
        ]
    program = read_program("\n".join([*lines, "G0 Z20", "M2", ""]).encode(), "linuxcnc")
    inputs = example()[1].inputs
    options = replace(inputs.options, best_fit=False)
    return surface_trial(replace(inputs, surface=surface, program=program, cutter=job, options=options), (20, 20))


def turned(at: Array, letters: str) -> tuple[list[str], Array]:
    """Words and axes along a pass: tilted by 15° to 20°, the tilt's direction going round by 20°."""
    tilt, round_ = np.radians(15 + 5 * at), np.radians(30 + 20 * at)
    axes = np.column_stack([np.sin(tilt) * np.sin(round_), -np.sin(tilt) * np.cos(round_), np.cos(tilt)])
    if letters == "IJK":
        return [f" I{i:.9f} J{j:.9f} K{k:.9f}" for i, j, k in axes.tolist()], axes
    return [f" A{a:.9f} C{c:.9f}" for a, c in np.degrees([tilt, round_]).T.tolist()], axes


@pytest.mark.parametrize(
    ("cutter", "letters"),
    [(Cutter(3.0, 3.0), "CA"), (Cutter(3.0, 1.0), "CA"), (Cutter(3.0, 1.0), "IJK"), (Cutter(2.0, 0.0), "CA")],
    ids=["ball", "bull nose", "bull nose by vectors", "flat end"],
)
def test_corrected_programs_of_cutters_that_turn_leave_little_but_ridges(
    cutter: Cutter, letters: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As for those that keep their axis: the truth as programmed is the pattern, and the correction takes it away."""
    monkeypatch.setattr("trueloop_lab.loops.surface.JUDGED", (31, 29))
    process = SurfaceProcess(random_surface(np.random.default_rng(5), 5, 0.020), 0.0, 0.0, 1e-5)
    done = simulate_surface(turning_over(cutter, letters), VirtualMill(process, grid=(20, 20)), parts=3, seed=1)
    assert np.min(done.ridges_mm) > -2e-4 and np.max(done.ridges_mm) < 0.02
    before, after = (values - done.ridges_mm for values in (done.truth_mm[0], done.corrected_truth_mm))
    assert rms(before) > 0.005
    assert rms(after) < 0.1 * rms(before)
