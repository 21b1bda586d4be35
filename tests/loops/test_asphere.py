"""An asphere (R 40, k −0.8, A4, A6) as 400 short lines and as a macro loop: corrected, and judged by LinuxCNC.

What the corrected nose centre must do is worked out here from the equation of ISO 10110-12 and the error alone, in
numpy: the contour displaced by −error along its normal, and moved out by the nose radius along its own normal.
"""

import math
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

from tests.support.asphere_part import NOSE_MM, error_mm, lens_inputs, lens_touches, lines_program, loop_program
from tests.support.curves import LENS, arc_as_curve
from tests.support.linuxcnc import Tool, interpret
from tests.support.standoff import standoff_mm
from trueloop.arrays import Array
from trueloop.domain.part import PartType
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.validate import checked_profile
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.turned.compensation.moves import Move
from trueloop.turned.options import Options
from trueloop.turned.touches.error_vectors import ErrorVectors

WITHIN_MM = 1e-4
PROGRAMS = {"lines": lines_program(), "loop": loop_program()}


def contour_mm(h: Array) -> Array:
    """Points of the lens displaced by −error along the normal."""
    return LENS.point_mm(h) - error_mm(LENS.arc_length_mm(h))[:, None] * LENS.normal(h)


def wanted_mm(h: Array) -> Array:
    """The nose's centre over them; the contour's tangent by central differences of 0.1 mm, fourth order."""
    d = 0.1
    along = 8 * (contour_mm(h - d) - contour_mm(h + d)) - (contour_mm(h - 2 * d) - contour_mm(h + 2 * d))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return contour_mm(h) + NOSE_MM * np.stack([along[:, 1], -along[:, 0]], axis=1)


def off_wanted_mm(points: Array) -> Array:
    """Distances of points from that path: from its chords of 1 µm, which are within 10⁻⁸ mm of it."""
    path = wanted_mm(np.linspace(20.6, -0.2, 20801))
    nearest = np.clip(KDTree(path).query(points)[1], 1, len(path) - 2)
    found = []
    for first in (nearest - 1, nearest):
        a, chord = path[first], path[first + 1] - path[first]
        share = np.clip(np.sum((points - a) * chord, axis=1) / np.sum(chord * chord, axis=1), 0.0, 1.0)
        found.append(np.linalg.norm(points - a - share[:, None] * chord, axis=1))
    return np.asarray(np.min(found, axis=0))


@cache
def corrected(kind: str) -> Correction:
    return compensate(lens_inputs(PROGRAMS[kind]))


def driven(program: bytes, folder: Path) -> list[Move]:
    """The feed moves that LinuxCNC makes of a program, in (x, z)."""
    file = folder / "judged.ngc"
    file.write_bytes(program)
    moves = [move for move in interpret(file, tools=[Tool(1)]) if move.kind == "line"]
    return [Move((m.start_mm[0], m.start_mm[2]), (m.end_mm[0], m.end_mm[2])) for m in moves]


@pytest.mark.parametrize("kind", PROGRAMS)
def test_linuxcnc_drives_the_displaced_curve(kind: str, tmp_path: Path) -> None:
    """All 400 ends, and the middles of the lines, whose sagitta over a nose path of 41 mm radius is 0.01 µm."""
    given, moves = driven(PROGRAMS[kind].encode(), tmp_path), driven(corrected(kind).corrected_program, tmp_path)
    assert len(moves) == len(given) == 402
    ends = np.array([move.end_mm for move in moves])[2:]
    assert np.max(off_wanted_mm(ends)) < 0.3 * WITHIN_MM
    assert np.max(off_wanted_mm((ends[:-1] + ends[1:]) / 2)) < WITHIN_MM
    before = np.array([move.end_mm for move in given])[2:]
    assert np.min(off_wanted_mm(before)) > 0.02, "the given program is 24 to 36 µm away from it"


@pytest.mark.parametrize("kind", PROGRAMS)
def test_lines_stay_as_tangent_to_each_other_as_they_were(kind: str, tmp_path: Path) -> None:
    """Neighbours turn by about 0.05 mm / 41 mm, and by no more than 0.1 mrad more or less than before: rounding to
    10⁻⁶ mm makes 0.04, the error's bend of 1 µm/mm² 0.05. No line became longer or shorter than the error's slope says.
    """
    before, after = (
        np.diff([move.end_mm for move in driven(program, tmp_path)][2:], axis=0)
        for program in (PROGRAMS[kind].encode(), corrected(kind).corrected_program)
    )
    turns = [np.diff(np.arctan2(steps[:, 0], steps[:, 1])) for steps in (before, after)]
    assert np.max(np.abs(turns[1] - turns[0])) < 1e-4
    lengths = [np.linalg.norm(steps, axis=1) for steps in (before, after)]
    assert np.max(np.abs(lengths[1] / lengths[0] - 1)) < 3e-3


@pytest.mark.parametrize("kind", PROGRAMS)
def test_all_else_stays_byte_for_byte(kind: str) -> None:
    source, written = PROGRAMS[kind].encode(), corrected(kind).corrected_program
    head, tail = source[: source.index(b"G1 X41.6")], source[source.index(b"G0 Z5") :]
    assert written.endswith(tail)
    assert head in written
    if kind == "loop":
        assert b"#1 = 0 (steps)\n(loop of lines 8 to 16 written out, 400 moves)\nG1 X" in written
        assert b"\n(end of the loop)\nG0 Z5" in written


@pytest.mark.parametrize("kind", PROGRAMS)
def test_form_after_the_correction_is_the_noise_of_the_touches(kind: str, tmp_path: Path) -> None:
    """A forward model: the surface is the envelope of the nose on the driven path, plus the error of the process.

    With touches that scatter by σ = 0.5 µm the curve through 24 of them is known to a fraction of σ: what is left has
    an RMS below σ, where 27 µm were. With touches that do not scatter it is below 0.15 µm.
    """
    rng, sigma_mm = np.random.default_rng(40), 5e-4
    h = np.linspace(19.8, 0.3, 60)
    for noise_mm, left_mm in ((0.0, 1.5e-4), (sigma_mm, sigma_mm)):
        inputs = lens_inputs(PROGRAMS[kind])
        touches = lens_touches(inputs.profile, rng.normal(0.0, noise_mm, 28) if noise_mm else None)
        done = compensate(replace(inputs, touches=touches)) if noise_mm else corrected(kind)
        moves = driven(done.corrected_program, tmp_path)
        surface = np.array(
            [standoff_mm(moves, p, n, NOSE_MM) for p, n in zip(LENS.point_mm(h), LENS.normal(h), strict=True)]
        )
        left = surface + error_mm(LENS.arc_length_mm(h))
        assert math.sqrt(np.mean(left**2)) < left_mm
        assert np.max(left) - np.min(left) < 6 * left_mm


def test_coarse_lines_keep_their_facets_and_are_not_blamed_for_them(tmp_path: Path) -> None:
    """40 lines of half a millimetre, facets of 0.9 µm: their ends are corrected, and the touches lie between them."""
    inputs, moves = lens_inputs(lines_program(40)), driven(lines_program(40).encode(), tmp_path)
    at = inputs.touches
    facets = [standoff_mm(moves, p, n, NOSE_MM) for p, n in zip(at.nominal_mm, at.outward_normal, strict=True)]
    assert max(np.abs(facets)) > 5e-4
    done = compensate(replace(inputs, touches=replace(at, error_mm=at.error_mm + facets)))
    ends = np.array([move.end_mm for move in driven(done.corrected_program, tmp_path)])[2:]
    assert len(ends) == 40
    assert np.max(off_wanted_mm(ends)) < 2 * WITHIN_MM
    assert not [note for note in done.notes if "off the nominal on lens" in note]


def test_lines_rounded_to_a_micrometre_stay_so(tmp_path: Path) -> None:
    """Three decimals: the ends keep the programmer's rounding of up to 0.56 µm; touches are less what it is there."""
    inputs = lens_inputs(lines_program(400, 3))
    done = compensate(inputs)
    ends = np.array([move.end_mm for move in driven(done.corrected_program, tmp_path)])[2:]
    assert np.max(off_wanted_mm(ends)) < 1e-3


def _loop(inside: str = "", after: str = "", variable: str = "#1") -> str:
    text = loop_program(60).replace("#1", variable)
    return text.replace("  G1 X[", f"  {inside}\n  G1 X[").replace("o100 endwhile\n", f"o100 endwhile\n{after}\n")


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (_loop(after="G0 X[60 + #4]"), "#4 is read again in line 18"),
        (_loop(inside="M8"), "its loop has M8"),
        (_loop(variable="#510"), "#510 keeps its value after the program"),
        (_loop(inside="G4 P0"), "its loop has G4"),
    ],
)
def test_loop_that_does_more_is_refused(program: str, words: str) -> None:
    with pytest.raises(TrueloopError) as refusal:
        compensate(lens_inputs(program))
    assert refusal.value.code is Code.NC_EDIT
    assert words in refusal.value.message
    assert refusal.value.hint


def test_loop_of_a_fanuc_control() -> None:
    """The same loop in Fanuc's words, written to the control's step of a micrometre."""
    text = loop_program(100)
    for old, new in (
        ("G7 G18 G21 G40 G90 G95 F0.1", "G21 G18 G40 G99 F0.1"),
        ("T1 M6 (lens)", "T0101 (LENS)"),
        ("o100 while [#1 LT 100]", "WHILE[#1LT100]DO1"),
        ("o100 endwhile", "END1"),
        ("#2**4", "#2*#2*#2*#2"),
        ("#2**6", "#2*#2*#2*#2*#2*#2"),
        ("#2**3", "#2*#2*#2"),
        ("#2**5", "#2*#2*#2*#2*#2"),
        ("M2\n", "M30\n%\n"),
    ):
        text = text.replace(old, new)
    text = "%\nO0001 (LENS)\n" + re.sub(r"\((\w+)\)", lambda comment: comment[0].upper(), text)
    text = re.sub(r"([XZ])(-?\d+)(?![\d.])", r"\1\2.", text)
    done = compensate(lens_inputs(text, "fanuc-lathe"))
    lines = done.corrected_program.decode().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("(loop of lines"))
    places = [line.removeprefix("G1 X").split(" Z") for line in lines[at + 1 : at + 101]]
    ends = np.array([[float(x) / 2, float(z)] for x, z in places])
    assert np.max(off_wanted_mm(ends)) < 7e-4
    assert lines[at + 101] == "(end of the loop)"


@pytest.mark.parametrize("count", [90])
def test_dome_as_a_curve_is_corrected_as_the_dome(count: int) -> None:
    """A quarter circle of 24 mm by 90 lines: the profile's arc, or the same arc as a curve."""
    angles = np.linspace(math.pi / 2, 0.0, count + 1)
    places = 24.8 * np.stack([np.sin(angles), np.cos(angles)], axis=1)
    lines = [f"G1 X{x + 0.0:.6f} Z{z - 24 + 0.0:.6f}" for x, z in places]
    source = "\n".join(["G8 G18 G21 G40 G90 G95 F0.1", "G0 X30 Z-40", "G1 X24.8", *lines, "G0 Z5", "M2", ""])
    neck, dome = (
        Line("neck", (24.0, -40.0), (24.0, -24.0)),
        Arc("dome", (24.0, -24.0), (0.0, 0.0), (0.0, -24.0), math.pi / 2),
    )
    done = [
        compensate(
            Inputs(
                PartType("dome"),
                profile,
                NOSE_MM,
                lens_inputs(source).program,
                _dome_touches(profile.features[1].length_mm, dome),
                Options(weight=1.0),
                lens_inputs(source).made_at,
            )
        )
        for profile in (checked_profile([neck, dome]), checked_profile([neck, arc_as_curve(dome)]))
    ]
    assert done[0].corrected_program.splitlines()[2:] == done[1].corrected_program.splitlines()[2:]


def _dome_touches(length_mm: float, dome: Arc) -> ErrorVectors:
    s = np.linspace(1.0, length_mm - 1.0, 15)
    on_neck = np.array([2.0, 8.0, 14.0])
    index = np.repeat([0, 1], [3, 15])
    neck = np.column_stack([np.full(3, 24.0), on_neck - 40.0])
    nominal = np.vstack([neck, dome.point_mm(s)])
    normal = np.vstack([np.tile([1.0, 0.0], (3, 1)), dome.outward_normal(s)])
    error = np.concatenate([np.full(3, 0.02), 0.02 + 0.015 * (s / length_mm) ** 2])
    every = np.concatenate([on_neck, s])
    names = tuple(map(str, range(18)))
    return ErrorVectors(names, index, every, error, np.full(18, 1e-4), np.zeros(18, bool), nominal, normal)
