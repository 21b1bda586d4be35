"""Finish passes under G42: the corrected contour, its nose kept off by LinuxCNC, cuts what was intended.

Nose compensation stays on. The judge is LinuxCNC's own interpreter, which keeps the nose off by itself; how far the
surface moved is measured on its moves.
"""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.correction import NOW
from tests.support.linuxcnc import LATHE_STARTUP, Tool, interpret
from tests.support.standoff import feed_moves_of, standoff_mm
from trueloop.arrays import Array
from trueloop.domain.part import PartType
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program
from trueloop.turned.compensation.moves import Move
from trueloop.turned.options import Options
from trueloop.turned.program.read_back import require_nose_fits, unfit
from trueloop.turned.touches.error_vectors import ErrorVectors

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
    return compensate(
        Inputs(PartType("part"), profile, of.nose_radius_mm, program, touches_on(profile), Options(), NOW, lines=lines)
    )


def moved_mm(correction: Correction, text: str, folder: Path) -> Array:
    """How far the surface that LinuxCNC makes the nose leave deviates from the nominal, at the touches."""
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
    contour = [piece.shifted for piece in correction.corrected]
    pairs = zip(correction.touches.feature_index, correction.touches.arc_length_mm, strict=True)
    return np.array([float(contour[int(i)].off_nominal_mm(s)) for i, s in pairs])


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


CORNERED = (
    PIN.read_text()
    .replace("X24.\nX30. Z-3.\nZ-30.\nG02 X40. Z-35. R5.\n", "X30. ,C3.\nZ-35. ,R5.\n")
    .replace("G01 X50.\nG03 X56. Z-38. R3.\nG01 Z-60.\n", "X56. ,R3.\nZ-60.\n")
    .encode()
)
"""The same contour, its chamfer and its roundings asked for by ,C and ,R."""
WITH_CORNERS = replace(OWN, lines=(11, 17))


def contour(correction: Correction, of: Pass) -> list[str]:
    """The blocks between P and Q with their numbers alike: 50. and 50.000 are one."""
    blocks = contour_lines(correction.corrected_program, of)
    return [re.sub(r"\.(\d*?)0*(?=\D|$)", r".\1", block) for block in blocks]


def test_a_contour_with_corners_is_corrected_as_the_one_written_out(tmp_path: Path) -> None:
    assert CORNERED.count(b",") == 3 + PIN.read_bytes().count(b",")
    found = corrected(CORNERED, "fanuc-lathe", WITH_CORNERS, WITH_CORNERS.lines)
    written_out = corrected(PIN.read_bytes(), "fanuc-lathe", OWN, OWN.lines)
    assert contour(found, WITH_CORNERS) == contour(written_out, OWN)
    assert found.record.changes[1].before == "X30. ,C3." and found.record.changes[1].line == 13
    text = in_linuxcncs_words(contour_lines(found.corrected_program, WITH_CORNERS), "G21")
    off_mm = moved_mm(found, text, tmp_path) - intended_mm(found)
    assert np.abs(off_mm).max() < WITHIN_MM + 0.0005
    assert any("roughing cycle of line 10" in note for note in found.notes)


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
        compensate(Inputs(PartType("part"), profile, 0.4, wrong, touches_on(profile), Options(), NOW))
    assert refused.value.code is Code.NC_COMPENSATED and "wants G42" in (refused.value.hint or "")


def test_a_contour_finished_twice_is_one_pass() -> None:
    """G70 runs the same blocks twice, with two tools: both runs move, which a note names."""
    twice = PIN.read_bytes().replace(b"G70 P10 Q20\n", b"G70 P10 Q20\nT0505\nG70 P10 Q20\n")
    profile = contour_of_program(feed_moves(read_program(PIN.read_bytes(), "fanuc-lathe").run()), 0.4).profile
    found = compensate(
        Inputs(PartType("part"), profile, 0.4, read_program(twice, "fanuc-lathe"), touches_on(profile), Options(), NOW)
    )
    assert any("run 2 times" in note for note in found.notes)


def test_a_nose_that_does_not_fit_is_refused() -> None:
    program = read_program(PIN.read_bytes(), "fanuc-lathe")
    profile = contour_of_program(feed_moves(program.run()), 0.4, lines=OWN.lines).profile
    with pytest.raises(TrueloopError) as refused:
        compensate(Inputs(PartType("part"), profile, 6.0, program, touches_on(profile), Options(), NOW))
    assert refused.value.code in (Code.GEO_NOSE, Code.GEO_NARROW, Code.NC_GOUGE)


def pin(source: bytes, constant_mm: tuple[float, float] | None) -> Correction:
    """The pin's correction, with a constant error (x as a radius, z) or one that changes along the part."""
    program = read_program(source, "fanuc-lathe")
    profile = contour_of_program(feed_moves(read_program(PIN.read_bytes(), "fanuc-lathe").run()), 0.4, lines=OWN.lines)
    touches = touches_on(profile.profile)
    if constant_mm is not None:
        jitter = 1e-4 * (-1.0) ** np.arange(len(touches.point))
        touches = replace(touches, error_mm=touches.outward_normal @ constant_mm + jitter)
    return compensate(Inputs(PartType("part"), profile.profile, 0.4, program, touches, Options(), NOW))


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
    assert "the tool offset on Z would be −500.0 µm; the limit is 150.0 µm" in refused.value.message
    assert "max_correction_um" in (refused.value.override or "")


OWN_SHIFT = PIN.read_bytes().replace(b"T0303\n", b"T0303\nG52 Z-1.\n")


def test_a_shift_of_the_programs_own_leaves_the_contour_to_be_corrected() -> None:
    correction = pin(OWN_SHIFT, None)
    assert correction.offsets_program is None
    assert any("no variant with tool offsets alone: a shift of x 0 mm (radius), z -1 mm" in n for n in correction.notes)
    assert correction.corrected_program != OWN_SHIFT


def test_a_shift_of_the_programs_own_is_not_replaced() -> None:
    """The offset is then entered at the control, and the program stays as it is."""
    correction = pin(OWN_SHIFT, (0.02, 0.01))
    assert correction.offsets_program is None and correction.runs_as_given
    assert correction.corrected_program == OWN_SHIFT


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


LED_IN = b"""%
O2200 (RAPID ONTO THE CONTOUR)
G21 G18 G40 G99
T0303
G00 X62. Z3.
N10 G42 G00 X16. Z1.
G01 X20. Z-1. F0.12
Z-30.
X50. Z-45.
N20 G40 G00 X62. Z-45.
M30
%
"""
FROM_ONE_AXIS = LED_IN.replace(b"X62. Z3.", b"X62. Z1.").replace(b"X16. Z1.\nG01 X20. Z-1. F0.12", b"X20.\nG01 F0.12")
"""As the first block of a contour of G71: it must not name Z."""


def led_in(source: bytes, error_mm: float) -> tuple[Correction, list[str], Array, Array]:
    """Its correction for one error everywhere but for a taper, the contour's blocks, where the rapid onto it ends and
    how far the surface then deviates from the nominal: (x, z) and at the touches."""
    program = read_program(source, "fanuc-lathe")
    profile = contour_of_program(feed_moves(program.run()), 0.4).profile
    touches = touches_on(profile)
    touches = replace(touches, error_mm=error_mm + 1e-4 * touches.nominal_mm[:, 1])
    correction = compensate(Inputs(PartType("part"), profile, 0.4, program, touches, Options(), NOW))
    written = read_program(correction.corrected_program, "fanuc-lathe")
    driven = written.run(tools=[CutterTool(0.4, 3)])
    assert not [found for found in driven.findings if found.severity == "error"]
    moves = [replace(move, start_mm=(x0 + 0.4, z0 + 0.4), end_mm=(x1 + 0.4, z1 + 0.4), centre_mm=centre)
             for move in feed_moves_of(driven)
             for (x0, z0), (x1, z1) in [(move.start_mm, move.end_mm)]
             for centre in [move.centre_mm and (move.centre_mm[0] + 0.4, move.centre_mm[1] + 0.4)]]  # fmt: skip
    pairs = zip(touches.nominal_mm, touches.outward_normal, strict=True)
    stands = np.array([standoff_mm(moves, point, normal, 0.4) for point, normal in pairs])
    ends = written.run().end_mm[1][[0, 2]]
    return correction, contour_lines(correction.corrected_program, OWN), ends, stands


@pytest.mark.parametrize("error_mm", [0.03, -0.03], ids=["into the material", "away from it"])
@pytest.mark.parametrize("source", [LED_IN, FROM_ONE_AXIS], ids=["both axes", "one axis"])
def test_a_rapid_onto_the_contour_ends_where_the_corrected_one_begins(source: bytes, error_mm: float) -> None:
    """A block of micrometres between would tell the control to lead the nose in along it, perhaps into the part."""
    correction, blocks, end_mm, stands_mm = led_in(source, error_mm)
    assert len(blocks) == len(contour_lines(source, OWN))
    assert np.abs(stands_mm - intended_mm(correction)).max() < WITHIN_MM + 0.0005
    start_mm, ahead = (np.array([8.0, 1.0]), [1.0, -1.0]) if source is LED_IN else (np.array([10.0, 1.0]), [0.0, -1.0])
    ahead = np.array(ahead) / np.linalg.norm(ahead)
    gone_mm, wanted_mm = end_mm - start_mm, float(correction.corrected[-1].shifted.off_nominal_mm(0.0))
    assert gone_mm @ [-ahead[1], ahead[0]] == pytest.approx(wanted_mm, abs=0.002)
    if source is LED_IN:
        assert gone_mm @ ahead < 0.001 - abs(wanted_mm), "no nearer to what lies ahead"
    else:
        assert end_mm[1] == 1.0


def test_where_a_nose_does_not_fit_is_told_as_a_line_of_the_written_program() -> None:
    """The marks stand before it: lines differ from those of the source, which is what a place names."""
    narrow = LED_IN.replace(b"Z-30.\nX50. Z-45.\n", b"Z-30.\nG02 X20.6 Z-30.3 R.3\nG01 X50.\nZ-45.\n")
    driven = read_program(narrow, "fanuc-lathe", "pin.nc").run(tools=[CutterTool(0.4, 3)], strict=False)
    with pytest.raises(TrueloopError, match=r": line 9 of the corrected program: an arc of radius") as refused:
        require_nose_fits(unfit(driven, driven), np.array([7, 11]))
    assert refused.value.code is Code.NC_GOUGE and refused.value.place == Place("pin.nc")
    require_nose_fits(unfit(driven, driven), np.array([1, 8]))


def test_a_corner_that_the_given_program_has_too_is_its_own() -> None:
    """Steps of 0.1 mm that shops cut with a nose of 0.4: the control has a way of its own. No other is excused."""
    step = b"Z-10.\nX20.2\nZ-30.\n"
    given, moved = (
        read_program(LED_IN.replace(b"Z-30.\n", text), "fanuc-lathe")
        for text in (step, step.replace(b"X20.2", b"X20.18"))
    )
    found = [unfit(p.run(tools=[CutterTool(0.4, 3)], strict=False), p.run()) for p in (given, moved)]
    lines = [one.found.place.line or 0 for one in found[0]]
    assert lines and require_nose_fits(found[1], np.array([7, 12]), found[0], 0.05) == tuple(lines)
    with pytest.raises(TrueloopError, match="does not fit into the corner"):
        require_nose_fits(found[1], np.array([7, 12]), found[0], 0.001)


IN_INCH = """{head}
G0 X1.0374 Z0.2362
G0 X0.2500
G42 G1 X0.2500 Z0.0000 F0.1
G1 X1.2500 Z0.0000
G3 X1.5000 Z-0.1250 I0.0000 K-0.1250
G1 X1.5000 Z-1.8750
G2 X1.7500 Z-2.0000 I0.1250 K0.0000
G1 X2.0000 Z-2.0000
G1 X2.0000 Z-3.0000
G40 G1 X2.3150
G0 X3.3996
M2
"""
"""An edge and a fillet of R.125."""


LINUXCNC_HEAD = "G18 G20 G7 G90 G40 T1 M6"


@pytest.mark.parametrize(("dialect", "head", "step_in"), [
    ("linuxcnc", LINUXCNC_HEAD, 1e-6),
    ("fanuc-lathe", "G20 G18 G40 G99 T0101", 1e-4),
    ("siemens", "G18 G70 G90 G40 DIAMON T1 D1", 1e-5),
])  # fmt: skip
def test_a_taper_error_opens_joins_of_arcs_that_no_control_refuses(
    dialect: str, head: str, step_in: float, tmp_path: Path
) -> None:
    """The arcs of the corrected contour join to some hundredths of a degree. Fanuc and Sinumerik refuse no arc for what
    compensation adds to it, LinuxCNC none before a tangent move."""
    program = read_program(IN_INCH.format(head=head).encode(), dialect)
    profile = contour_of_program(feed_moves(program.run()), 0.8).profile
    touches = touches_on(profile)
    x, z = touches.outward_normal.T
    touches = replace(touches, error_mm=x * (0.015 - 0.012 * touches.nominal_mm[:, 1] / 50) + z * 0.006)
    options = Options(by="contour")
    correction = compensate(Inputs(PartType("part"), profile, 0.8, program, touches, options, NOW))
    written = correction.corrected_program.decode()
    assert sum(line.startswith(("G2 ", "G3 ")) for line in written.splitlines()) > 2, "arcs stay arcs"
    begins, ends = written.index("G0 X1.0374"), written.index("G40 G1")
    judged = f"{LINUXCNC_HEAD}\n{written[begins:ends]}G40 G1 X2.3150\nM2\n"
    found = moved_mm(correction, judged, tmp_path)
    assert np.abs(found - intended_mm(correction)).max() < WITHIN_MM + 25.4 * step_in
    assert np.abs(intended_mm(correction)).max() > 0.02
