"""Finish passes under G42: the corrected contour, its nose kept off by LinuxCNC, cuts what was intended.

Nose compensation stays on. The judge is LinuxCNC's own interpreter, which keeps the nose off by itself; how far the
surface moved is measured on its moves.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import LATHE_STARTUP, Tool, interpret
from tests.support.standoff import standoff_mm
from trueloop.compensation.moves import Move
from trueloop.errors import Code, TrueloopError
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import Array
from trueloop.geometry.profile import Profile
from trueloop.loops.process_intermittent import Correction, Inputs, Options, compensate
from trueloop.nc.contour import contour_of_program
from trueloop.nc.feed_moves import feed_moves
from trueloop.nc.program import read_program

PROGRAMS = Path(__file__).parents[1] / "programs"
PIN = PROGRAMS / "fanuc-lathe-compensated" / "program.nc"
WITHIN_MM = 0.0002
TO_MM = {"G20": 25.4, "G21": 1.0}


@dataclass(frozen=True)
class Pass:
    """A finish pass of a Fanuc program: lines of its contour, from P to Q, its unit and its tool's nose."""

    file: str
    lines: tuple[int, int]
    unit: str
    nose_radius_mm: float


SHOP = [
    Pass("fanuc-lathe-round-head-plug.nc", (28, 38), "G20", 0.0157 * 25.4),
    Pass("fanuc-lathe-weld-pin.nc", (24, 30), "G20", 0.0315 * 25.4),
]
OWN = Pass(str(PIN), (11, 21), "G21", 0.4)


def in_linuxcncs_words(lines: list[str], unit: str) -> str:
    """A contour, from P to Q, as a program that LinuxCNC runs: its blocks are taken over as they are."""
    position = {"G20": "X3 Z.2", "G21": "X62 Z3"}[unit]
    return "\n".join([f"{unit} G7 G18 G40 G90 G94 F10 T1 M6", f"G0 {position}", *lines, "M2", ""])


def touches_on(profile: Profile) -> ErrorVectors:
    """Up to six touches a feature; errors of tens of micrometres that change along the part."""
    places = [
        (i, feature.length_mm * (k + 0.5) / count)
        for i, feature in enumerate(profile.features)
        for count in [max(1, min(6, int(feature.length_mm // 3)))]
        for k in range(count)
    ]
    index = np.array([i for i, _ in places])
    s = np.array([s for _, s in places])
    nominal = np.array([profile.features[i].point_mm(s) for i, s in places])
    normal = np.array([profile.features[i].outward_normal(s) for i, s in places])
    error = 0.02 + 0.01 * np.sin(nominal[:, 1] / 9) + 0.004 * np.cos(nominal[:, 0])
    names = tuple(map(str, range(len(places))))
    return ErrorVectors(names, index, s, error, np.full(len(s), 5e-4), np.zeros(len(s), bool), nominal, normal)


def corrected(source: bytes, dialect: str, of: Pass, lines: tuple[int, int]) -> Correction:
    program = read_program(source, dialect)
    profile = contour_of_program(feed_moves(program.run()), of.nose_radius_mm, lines=lines).profile
    return compensate(Inputs("part", profile, of.nose_radius_mm, program, touches_on(profile), Options(), lines=lines))


def moved_mm(correction: Correction, text: str, folder: Path) -> Array:
    """How far the surface that LinuxCNC makes the nose leave stands off the nominal, at the touches."""
    file = folder / "judged.ngc"
    file.write_text(text)
    judged = interpret(file, tools=[Tool(1, correction.nose_radius_mm)], startup=LATHE_STARTUP)
    cuts = [move for move in judged if move.kind != "rapid" and not np.allclose(move.start_mm, move.end_mm)]
    moves = [
        Move(
            (move.start_mm[0], move.start_mm[2]),
            (move.end_mm[0], move.end_mm[2]),
            None if move.centre_mm is None else (move.centre_mm[0], move.centre_mm[2]),
            move.sweep_rad or 0.0,
        )
        for move in cuts
    ]
    pairs = zip(correction.touches.nominal_mm, correction.touches.outward_normal, strict=True)
    return np.array([standoff_mm(moves, point, normal, correction.nose_radius_mm) for point, normal in pairs])


def intended_mm(correction: Correction) -> Array:
    """Where the corrected contour shall stand off the nominal, at the touches."""
    shifts = correction.corrected_shift
    pairs = zip(correction.touches.feature_index, correction.touches.arc_length_mm, strict=True)
    return np.array([float(shifts[int(i)].value_mm(s)) for i, s in pairs])


def contour_lines(source: bytes, of: Pass) -> list[str]:
    """The blocks from P to Q, found again by their numbers."""
    text = source.decode().splitlines()
    first, last = (f"N{number}0 " for number in (1, 2))
    start = next(k for k, line in enumerate(text) if line.startswith(first))
    end = next(k for k, line in enumerate(text) if line.startswith(last))
    return text[start : end + 1]


def passes(corpus: Path) -> list[tuple[bytes, Pass]]:
    folder = corpus / "data" / "public" / "nc"
    return [((folder / of.file).read_bytes(), of) for of in SHOP]


def check_both_controls(source: bytes, of: Pass, folder: Path) -> None:
    """In Fanuc's words within the rounding to its step; in LinuxCNC's, whose step is finer, within 0.2 µm."""
    fanuc = corrected(source, "fanuc-lathe", of, of.lines)
    unit_mm = TO_MM[of.unit]
    step_mm = (1e-4 if of.unit == "G20" else 1e-3) * unit_mm
    found = moved_mm(fanuc, in_linuxcncs_words(contour_lines(fanuc.corrected_program, of), of.unit), folder)
    assert np.abs(found - intended_mm(fanuc)).max() < WITHIN_MM + step_mm / 2
    assert any(f"roughing cycle of line {of.lines[0] - 1}" in note for note in fanuc.notes)

    text = in_linuxcncs_words(contour_lines(source, of), of.unit)
    linuxcnc = corrected(text.encode(), "linuxcnc", of, (3, 2 + of.lines[1] - of.lines[0] + 1))
    found = moved_mm(linuxcnc, linuxcnc.corrected_program.decode(), folder)
    assert np.abs(found - intended_mm(linuxcnc)).max() < WITHIN_MM
    assert np.abs(intended_mm(linuxcnc)).max() > 0.02, "there was something to correct"


def test_a_contour_of_g71_and_g70(tmp_path: Path) -> None:
    check_both_controls(PIN.read_bytes(), OWN, tmp_path)


@pytest.mark.corpus
@pytest.mark.parametrize("number", range(len(SHOP)), ids=[of.file for of in SHOP])
def test_finish_passes_of_shops(corpus: Path, number: int, tmp_path: Path) -> None:
    source, of = passes(corpus)[number]
    check_both_controls(source, of, tmp_path)


def test_only_the_blocks_of_the_contour_change() -> None:
    """Two comment lines more behind the program's number, and the rest as it was."""
    source = PIN.read_bytes().splitlines()
    written = corrected(PIN.read_bytes(), "fanuc-lathe", OWN, OWN.lines).corrected_program.splitlines()
    assert written[:2] == source[:2] and written[4:13] == source[2:11]
    assert written[-6:] == source[-6:]


def test_the_wrong_side_is_refused() -> None:
    program = read_program(PIN.read_bytes(), "fanuc-lathe")
    profile = contour_of_program(feed_moves(program.run()), 0.4, lines=OWN.lines).profile
    wrong = read_program(PIN.read_bytes().replace(b"G42 ", b"G41 "), "fanuc-lathe")
    with pytest.raises(TrueloopError) as refused:
        compensate(Inputs("part", profile, 0.4, wrong, touches_on(profile), Options()))
    assert refused.value.code is Code.NC_COMPENSATED and "wants G42" in (refused.value.hint or "")


def test_a_contour_finished_twice_is_not_chosen_from() -> None:
    """G70 runs the same blocks twice, perhaps with two tools: no range of lines tells the passes apart."""
    twice = PIN.read_bytes().replace(b"G70 P10 Q20\n", b"G70 P10 Q20\nT0505\nG70 P10 Q20\n")
    profile = contour_of_program(feed_moves(read_program(PIN.read_bytes(), "fanuc-lathe").run()), 0.4).profile
    with pytest.raises(TrueloopError, match="write the finish pass out") as refused:
        compensate(Inputs("part", profile, 0.4, read_program(twice, "fanuc-lathe"), touches_on(profile), Options()))
    assert refused.value.code is Code.NC_AMBIGUOUS


def test_a_nose_that_does_not_fit_is_refused() -> None:
    program = read_program(PIN.read_bytes(), "fanuc-lathe")
    profile = contour_of_program(feed_moves(program.run()), 0.4, lines=OWN.lines).profile
    with pytest.raises(TrueloopError) as refused:
        compensate(Inputs("part", profile, 6.0, program, touches_on(profile), Options()))
    assert refused.value.code in (Code.GEO_NOSE, Code.GEO_NARROW, Code.NC_GOUGE)


def pin(source: bytes, constant_mm: tuple[float, float] | None) -> Correction:
    """The pin's correction, with a constant error (x as a radius, z) or one that changes along the part."""
    program = read_program(source, "fanuc-lathe")
    profile = contour_of_program(feed_moves(read_program(PIN.read_bytes(), "fanuc-lathe").run()), 0.4, lines=OWN.lines)
    touches = touches_on(profile.profile)
    if constant_mm is not None:
        jitter = 1e-4 * (-1.0) ** np.arange(len(touches.point))
        touches = replace(touches, error_mm=touches.outward_normal @ constant_mm + jitter)
    return compensate(Inputs("part", profile.profile, 0.4, program, touches, Options()))


def test_a_constant_error_shifts_the_frame_around_the_finishing_cycle() -> None:
    """What an offset can do is done by G52 before and after G70: the contour's blocks stay as they were."""
    written = pin(PIN.read_bytes(), (0.02, 0.01)).corrected_program.decode()
    assert "G52 X-0.040 Z-0.010\nG70 P10 Q20\nG52 X0.000 Z0.000\n" in written
    assert "\nG52 X0.000 Z0.000 (takes back the shift of a run that was stopped in the cut)\nG21 G18" in written


def test_an_offset_beyond_the_limit_is_refused() -> None:
    """A ball radius forgotten in the job is such a constant."""
    with pytest.raises(TrueloopError) as refused:
        pin(PIN.read_bytes(), (0.02, 0.5))
    assert refused.value.code is Code.CMP_SIZE
    assert "the tool offset on Z would be -500.0 µm; the limit is 150.0 µm" in refused.value.message
    assert "max_correction_um" in (refused.value.override or "")


OWN_SHIFT = PIN.read_bytes().replace(b"T0303\n", b"T0303\nG52 Z-1.\n")


def test_a_shift_of_the_programs_own_leaves_the_contour_to_be_corrected() -> None:
    correction = pin(OWN_SHIFT, None)
    assert correction.offsets_program is None
    assert any("no variant with tool offsets alone: a shift of x 0 mm (radius), z -1 mm" in n for n in correction.notes)
    assert correction.corrected_program != OWN_SHIFT


def test_a_shift_of_the_programs_own_is_not_replaced() -> None:
    with pytest.raises(TrueloopError) as refused:
        pin(OWN_SHIFT, (0.02, 0.01))
    assert refused.value.code is Code.NC_OFFSET


def test_the_offset_variant_shifts_the_frame_outside_of_compensation(tmp_path: Path) -> None:
    """LinuxCNC lets nobody change the frame under G42: it stops in the cut."""
    text = in_linuxcncs_words(PIN.read_text().splitlines()[OWN.lines[0] - 1 : OWN.lines[1]], OWN.unit)
    lines = 3, 2 + OWN.lines[1] - OWN.lines[0] + 1
    correction = corrected(text.encode(), "linuxcnc", OWN, lines)
    ends = []
    for name, source in (("source", text.encode()), ("offsets", correction.offsets_program)):
        (tmp_path / name).write_bytes(source or b"")
        judged = interpret(tmp_path / name, tools=[Tool(1, OWN.nose_radius_mm)])
        ends.append(np.array([move.machine_mm for move in judged]))
    dx_mm, dz_mm = correction.decision.offset_mm
    moved = ends[1] - ends[0]
    assert moved[0] == pytest.approx(0.0, abs=1e-9), "the way to the part is not shifted"
    assert moved[2:-1] == pytest.approx(np.tile([dx_mm, 0.0, dz_mm], (len(moved) - 3, 1)), abs=1e-5)
