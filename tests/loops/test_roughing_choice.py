"""Roughing that stays where it was while the contour that it shares with a finishing cycle is corrected.

Judged by the words of the written program, by the slow reference of roughing cycles on the contour that these words
give it, and by LinuxCNC's interpreter on the finish pass.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import (
    OWN,
    PIN,
    WITHIN_MM,
    in_linuxcncs_words,
    intended_mm,
    moved_mm,
    touches_on,
)
from tests.loops.test_linuxcnc_contour_cycles import NOSE_MM, PROGRAM, ROUGHING
from tests.loops.test_mapped_roughing import contour
from tests.support.correction import NOW
from tests.support.linuxcnc import LATHE_STARTUP, interpret
from tests.support.roughing_reference import Cycle, Piece, Row, cuts, pattern
from trueloop.arrays import Array
from trueloop.domain.part import PartType
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Side
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.options import Options, Roughing
from trueloop.turned.program.contour_cycles import own_contour, roughing_cycles
from trueloop.turned.program.read_back import move_of

KINDS = {Motion.RAPID: "rapid", Motion.LINE: "line", Motion.ARC: "arc"}
STEP_MM = 0.0005
Reference = Callable[[list[Piece]], list[Row]]

OUTSIDE = """\
O0001
G21 G18 G40 G99
G00 X60. Z2.
{first}
{cycle} P10 Q20 {left} F0.25
N10 G00 X20.{start}
G01 Z-10. F0.1
X26. Z-15.
Z-25.
G02 X36. Z-30. R5.
G01 X50.
N20 Z-45.
G00 X150. Z80.
G00 X60. Z2.
G70 P10 Q20 (FINISH)
G00 X150. Z80.
M30
"""
BORE = """\
O0002
G21 G18 G40 G99
G00 X18. Z2.
G71 U1.5 R0.5
G71 P10 Q20 U-0.4 W0.1 F0.25
N10 G00 X50.
G01 Z-10. F0.1
X40. Z-15.
Z-25.
G03 X30. Z-30. R5.
G01 X24.
N20 Z-45.
G70 P10 Q20
G00 Z80.
M30
"""


def turning(cycle: str = "G71", left: str = "U0.4 W0.1", start: str = "") -> str:
    first = {"G71": "G71 U2. R0.5", "G72": "G72 W2. R0.5", "G73": "G73 U4. W2. R3"}[cycle]
    return OUTSIDE.format(cycle=cycle, first=first, left=left, start=start)


def correction(
    source: bytes,
    dialect: str,
    lines: tuple[int, int] | None,
    error_mm: float | None = None,
    *,
    slope: float = 0.3,
    roughing: Roughing = "stays",
    nose_mm: float = 0.4,
    side: Side = Side.OUTSIDE,
) -> Correction:
    program = read_program(source, dialect)
    profile = contour_of_program(feed_moves(program.run(roughing=False)), nose_mm, lines=lines, side=side).profile
    touches = touches_on(profile)
    if error_mm is not None:
        touches = replace(touches, error_mm=error_mm + slope * (touches.error_mm - touches.error_mm.mean()))
    options = Options(roughing=roughing, by="contour")
    return compensate(Inputs(PartType("part"), profile, nose_mm, program, touches, options, NOW, lines=lines))


def passes(program: Program) -> list[Row]:
    """What the roughing cycles cut: kind and end (x, z) of each move."""
    path = program.run()
    own = np.flatnonzero(np.isin(path.block, [cycle.block.index for cycle in roughing_cycles(program)]))
    return [(KINDS[Motion(path.motion[k])], *path.end_mm[k][[0, 2]].tolist()) for k in own]


def same(found: list[Row], wanted: list[Row]) -> bool:
    assert [row[0] for row in found] == [row[0] for row in wanted] and len(found) > 10
    return bool(np.abs(np.array([row[1:] for row in found]) - np.array([row[1:] for row in wanted])).max() < 1e-6)


def finish_lines(text: str) -> list[str]:
    """The blocks in the place of the finishing cycle: from the one after N20's course to the last rapid back."""
    lines = text.splitlines()
    first = max(k for k, line in enumerate(lines) if line.startswith("G00 G42"))
    return lines[first : next(k for k in range(first, len(lines)) if lines[k].startswith("G28"))]


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "haas-lathe"])
def test_a_finish_pass_under_g42_is_corrected_and_the_roughing_stays(dialect: str, tmp_path: Path) -> None:
    found = correction(PIN.read_bytes(), dialect, OWN.lines)
    written = found.corrected_program.decode()
    roughed = PIN.read_text().partition("G70")[0].partition("G21")[2]
    assert roughed in written
    assert "G70" not in written and "N10" in written
    text = in_linuxcncs_words(finish_lines(written), "G21")
    assert np.abs(moved_mm(found, text, tmp_path) - intended_mm(found)).max() < WITHIN_MM + STEP_MM
    assert np.abs(intended_mm(found)).max() > 0.02
    assert any("line 10 cuts what it cut before" in note for note in found.notes)
    source = read_program(PIN.read_bytes(), dialect)
    assert same(passes(read_program(found.corrected_program, dialect)), passes(source))


def test_a_contour_that_goes_down_again_by_its_correction_is_roughed_as_it_was() -> None:
    """G71 of type I refuses it where the roughing moves along: there are no passes then."""
    moves = correction(PIN.read_bytes(), "fanuc-lathe", OWN.lines, roughing="moves")
    assert not passes(read_program(moves.corrected_program, "fanuc-lathe"))
    assert any("does not rise" in note and '"stays"' in note for note in moves.notes)


def test_roughing_that_moves_along_is_the_references_on_the_corrected_contour() -> None:
    """All is 20 µm too large: the passes go down by that, and stop earlier."""
    found = correction(turning().encode(), "fanuc-lathe", (6, 12), error_mm=0.02, slope=0.0, roughing="moves")
    written = read_program(found.corrected_program, "fanuc-lathe")
    wanted = cuts(Cycle((30.0, 2.0), contour(found.corrected_program.decode()), (0.2, 0.1)), 2.0, 0.5)
    assert same(passes(written), wanted)
    given = passes(read_program(turning().encode(), "fanuc-lathe"))
    assert min(row[1] for row in wanted) == pytest.approx(min(row[1] for row in given) - 0.02, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "reference"),
    [
        (turning(), lambda c: cuts(Cycle((30.0, 2.0), c, (0.2, 0.1)), 2.0, 0.5)),
        (turning("G73"), lambda c: pattern(Cycle((30.0, 2.0), c, (0.2, 0.1)), (4.0, 2.0), 3)),
        (BORE, lambda c: cuts(Cycle((9.0, 2.0), c, (-0.2, 0.1)), 1.5, 0.5)),
    ],
    ids=["G71", "G73", "bore"],
)
@pytest.mark.parametrize("dialect", ["fanuc-lathe", "haas-lathe"])
def test_roughing_of_a_finishing_cycle_written_out_is_that_of_the_reference(
    text: str, reference: Reference, dialect: str
) -> None:
    program = read_program(text.encode(), dialect)
    path = program.run(roughing=False)
    cut = int(np.flatnonzero(path.call >= 0)[2])
    apart = read_program(apply_edits(program, own_contour(program, path, cut)), dialect)
    assert same(passes(apart), reference(contour(text)))
    own = apart.run(roughing=False)
    assert b"G70" not in apart.source and np.array_equal(own.motion, path.motion)
    assert (
        np.abs(own.end_mm - path.end_mm).max() < 1e-9
        and not np.intersect1d(own.block, [block.index for block in apart.blocks if block.number in (10, 20)]).size
    )


@pytest.mark.parametrize("start", ["", " Z2."], ids=["type I", "type II"])
@pytest.mark.parametrize("cycle", ["G71", "G73"])
def test_the_finish_pass_is_displaced_and_no_rapid_comes_nearer(cycle: str, start: str, tmp_path: Path) -> None:
    source = turning(cycle, start=start)
    if start and cycle == "G71":
        source = source.replace("Z-25.\n", "Z-18.\nX24. Z-20.\nZ-25.\n").replace("G02 X36.", "X26.\nG02 X36.")
    found = correction(source.encode(), "fanuc-lathe", (6, 14))
    before, after = (read_program(text, "fanuc-lathe") for text in (source.encode(), found.corrected_program))
    assert same(passes(after), passes(before))
    old, new = before.run(roughing=False), after.run(roughing=False)
    ends = [path.end_mm[path.rapid][:, [0, 2]] for path in (old, new)]
    nearest = [clearance_mm(found, places) for places in ends]
    assert len(ends[0]) == len(ends[1]) and np.all(nearest[1] >= nearest[0] - 1e-6)
    assert offset_of_cuts(found, new) < STEP_MM + 0.0005


def clearance_mm(found: Correction, places: Array) -> Array:
    return np.array([np.abs(found.profile.locate(place).distance_mm[0]) for place in places])


def offset_of_cuts(found: Correction, path: ToolPath) -> float:
    """How far the corrected path of the nose's centre is from the feed moves of the written program."""
    feeds = np.flatnonzero(~path.rapid)
    moves = [move_of(path, int(k)) for k in feeds]
    worst = 0.0
    for shifted in found.corrected:
        s = np.linspace(shifted.start_mm, shifted.end_mm, 101)
        points = shifted.shifted.centre_mm(s)
        worst = max(worst, float(np.min([move.gap_mm(points) for move in moves], axis=0).max()))
    return worst


@pytest.mark.parametrize("first", ["G0 X5", "G0 X5 Z2"])
def test_linuxcnc_gets_a_second_subroutine(first: str, tmp_path: Path) -> None:
    """Its own interpreter roughs as before, to the last digit, and finishes the displaced contour."""
    source = PROGRAM.format(first=first, roughing=ROUGHING)
    found = correction(source.encode(), "linuxcnc", None, error_mm=0.02, nose_mm=NOSE_MM)
    written = found.corrected_program.decode()
    assert "G71 Q100 D0.5" in written and "G70 Q101" in written
    assert written.count("O100") == written.count("O101") == 2
    moves = []
    for text in (source, written):
        file = tmp_path / "judged.ngc"
        file.write_text(text)
        judged = interpret(file, startup=LATHE_STARTUP)
        done = next(k for k, move in enumerate(judged) if abs(move.end_mm[2] - 1.0) < 1e-9)
        moves.append((judged[:done], judged[done:]))
    (rough, finish), (rough_after, finish_after) = moves
    assert [m.kind for m in rough] == [m.kind for m in rough_after] and len(rough) > 10
    assert np.allclose([m.end_mm for m in rough], [m.end_mm for m in rough_after], rtol=0, atol=1e-9)
    ends = [np.array([m.end_mm for m in side if m.kind != "rapid"])[-3:, 0] for side in (finish, finish_after)]
    assert np.all(ends[1][1:] < ends[0][1:] + 0.01) and np.abs(ends[1] - ends[0]).max() > 0.005


def test_roughing_that_would_cut_into_the_corrected_contour_is_refused() -> None:
    """The part is 60 µm too small, and U0.04 leaves 20 µm on the radius: what stays would cut 40 µm too deep."""
    text = turning(left="U0.04 W0.02")
    with pytest.raises(TrueloopError) as refused:
        correction(text.encode(), "fanuc-lathe", (6, 12), error_mm=-0.06)
    assert refused.value.code is Code.CMP_STOCK and 20 < float(str(refused.value.values["below_um"])) < 60
    correction(text.encode(), "fanuc-lathe", (6, 12), error_mm=-0.06, roughing="moves")
    correction(text.encode(), "fanuc-lathe", (6, 12), error_mm=0.06)


def test_a_bore_is_corrected_and_its_roughing_stays() -> None:
    """20 µm are left on inside: the finish pass goes out by that, on either side of the axis alike."""
    found = correction(BORE.encode(), "fanuc-lathe", (6, 12), error_mm=0.02, slope=0.0, side=Side.INSIDE)
    after = read_program(found.corrected_program, "fanuc-lathe")
    assert same(passes(after), passes(read_program(BORE.encode(), "fanuc-lathe")))
    written = found.corrected_program.decode().partition("N20")[2]
    cuts_x = [float(x) / 2 for x in re.findall(r"^(?:G01 )?X([\d.]+)", written, re.MULTILINE)]
    assert offset_of_cuts(found, after.run(roughing=False)) < STEP_MM + 0.0005
    assert any(abs(x - 25.02) < STEP_MM for x in cuts_x) and any(abs(x - 20.02) < STEP_MM for x in cuts_x)
    too_little = BORE.replace("U-0.4 W0.1", "U-0.04 W0.02")
    with pytest.raises(TrueloopError) as refused:
        correction(too_little.encode(), "fanuc-lathe", (6, 12), error_mm=-0.06, side=Side.INSIDE)
    assert refused.value.code is Code.CMP_STOCK


def test_a_contour_whose_blocks_are_called_elsewhere_is_refused() -> None:
    """The cylinder is cut by a subprogram: a copy of the contour's blocks would still call the same one."""
    text = turning().replace("Z-25.\n", "M98 P100\n") + "O0100\nZ-25.\nM99\n"
    with pytest.raises(TrueloopError) as refused:
        correction(text.encode(), "fanuc-lathe", (6, 22))
    assert refused.value.code is Code.NC_EDIT and "moves" in refused.value.hint
