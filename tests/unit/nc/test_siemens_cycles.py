"""CYCLE95 and CYCLE952: their passes against the slow reference, their finishing as the contour's own blocks."""

import numpy as np
import pytest

from tests.support.roughing_reference import Cycle, Piece, Row, stock_removal
from trueloop.errors import Code
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

KINDS = {Motion.RAPID: "rapid", Motion.LINE: "line", Motion.ARC: "arc"}
OUTSIDE = "G1 X20 Z0\nZ-10\nX26 Z-15\nZ-25\nG2 X36 Z-30 CR=5\nG1 X50\nZ-45"
INSIDE = "G1 X50 Z0\nZ-10\nX40 Z-15\nZ-25\nG3 X30 Z-30 CR=5\nG1 X24"
FACE = "G1 X60 Z-20\nX40\nX30 Z-10\nX20\nZ0"
PIECES = {
    OUTSIDE: [
        Piece((10, 0), (10, -10)),
        Piece((10, -10), (13, -15)),
        Piece((13, -15), (13, -25)),
        Piece((13, -25), (18, -30), (18, -25)),
        Piece((18, -30), (25, -30)),
        Piece((25, -30), (25, -45)),
    ],
    INSIDE: [
        Piece((25, 0), (25, -10)),
        Piece((25, -10), (20, -15)),
        Piece((20, -15), (20, -25)),
        Piece((20, -25), (15, -30), (15, -25)),
        Piece((15, -30), (12, -30)),
    ],
    FACE: [
        Piece((30, -20), (20, -20)),
        Piece((20, -20), (15, -10)),
        Piece((15, -10), (10, -10)),
        Piece((10, -10), (10, 0)),
    ],
}


def text(contour: str, call: str, head: str = "G0 X80 Z5") -> str:
    return f"%_N_A_MPF\nG18 G71 G90 G95 DIAMON F0.2\n{head}\n{call}\nG0 X100 Z80\nM30\n%_N_PART_SPF\n{contour}\nM17\n"


def run(source: str) -> ToolPath:
    return read_program(source.encode(), "siemens").run()


def rows(path: ToolPath, line: int) -> list[Row]:
    return [
        (KINDS[Motion(path.motion[k])], *path.end_mm[k][[0, 2]].tolist()) for k in np.flatnonzero(path.line == line)
    ]


def assert_same(found: list[Row], wanted: list[Row]) -> None:
    assert [row[0] for row in found] == [row[0] for row in wanted]
    assert np.allclose([row[1:] for row in found], [row[1:] for row in wanted], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("contour", "kind", "left"),
    [(OUTSIDE, 1, (0.2, 0.1)), (INSIDE, 3, (-0.2, 0.1)), (FACE, 2, (0.2, 0.1))],
    ids=["outside", "inside", "face"],
)
@pytest.mark.parametrize("depth", [2.0, 2.5, 30.0])
def test_the_passes_are_those_of_the_reference(
    contour: str, kind: int, left: tuple[float, float], depth: float
) -> None:
    path = run(text(contour, f'CYCLE95("PART",{depth},0.1,0.2,,0.3,0.1,0.15,{kind},,,0.5)'))
    wanted = stock_removal(Cycle((0, 0), PIECES[contour], left), depth, 0.5, facing=kind == 2)
    assert_same(rows(path, 4), wanted)
    assert set(path.feed[path.line == 4]) == {0.3} and set(path.compensation) == {40}


def test_a_contour_written_the_other_way_round_is_roughed_alike() -> None:
    turned = "G1 X50 Z-45\nZ-30\nX36\nG3 X26 Z-25 CR=5\nG1 Z-15\nX20 Z-10\nZ0"
    call = 'CYCLE95("PART",2,0.1,0.2,,0.3,0.1,0.15,1,,,0.5)'
    assert_same(rows(run(text(turned, call)), 4), rows(run(text(OUTSIDE, call)), 4))


def test_complete_machining_roughs_and_then_finishes() -> None:
    call = 'CYCLE95("PART",R1,0.1,0.2,,0.3,0.1,0.15,{},,,0.5)'
    both, rough, finish = (run(text(OUTSIDE, call.format(kind), "R1=2.5\nG0 X80 Z5")) for kind in (9, 1, 5))
    assert_same(rows(both, 5)[: len(rows(rough, 5))], rows(rough, 5))
    assert [rows(both, line) for line in range(9, 17)] == [rows(finish, line) for line in range(9, 17)]
    assert sum(len(rows(finish, line)) for line in range(9, 17)) == 8  # to the contour, six pieces, and back


@pytest.mark.parametrize(
    ("contour", "kind", "side"), [(OUTSIDE, 5, 42), (INSIDE, 7, 41), (FACE, 6, 41), (OUTSIDE.replace("Z-", "Z"), 5, 41)]
)
def test_finishing_keeps_the_nose_off_on_its_side(contour: str, kind: int, side: int) -> None:
    path = run(text(contour, f'CYCLE95("PART",2,,,,0.3,0.1,0.15,{kind},,,0.5)'))
    own = (path.line > 7) & ~path.rapid
    assert set(path.compensation[own]) == {side} and set(path.feed[own]) == {0.15}
    assert path.compensation[-1] == 40 and path.feed[-1] == 0.2
    pieces = PIECES.get(contour, [])
    assert not pieces or [tuple(row[1:]) for row in (rows(path, k)[0] for k in range(9, 9 + len(pieces)))] == [
        piece.end for piece in pieces
    ]


@pytest.mark.parametrize("names", ['"PART",0,,', '"PART"', ',2,"FIRST","LAST"'])
def test_cycle952_finishes_the_contour_that_cycle62_names(names: str) -> None:
    source = text(OUTSIDE, f'CYCLE62({names})\nCYCLE952("P","","",101321,0.15,0,0,2,0.1,0.1,0,0,0,0,1)')
    path = run(source.replace("M30\n", f"M30\nFIRST:\n{OUTSIDE}\nLAST:\n") if "FIRST" in names else source)
    ends = path.end_mm[~path.rapid][:, [0, 2]].tolist()
    assert ends == [list(piece.end) for piece in PIECES[OUTSIDE]]
    assert set(path.compensation[~path.rapid]) == {42}


@pytest.mark.parametrize(
    ("call", "why"),
    [
        ('CYCLE95("ELSEWHERE",2,,,,,,,1)', "not in this file"),
        ('CYCLE95("PART",2,,,,,,,13)', "VARI"),
        ('CYCLE95("PART",2,,,,,,)', "VARI"),
        ('CYCLE95("PART",0,,,,,,,1)', "its infeed makes no sense"),
        ('CYCLE95("PART",0.000000001,,,,,,,1)', "its infeed makes no sense"),
        ('CYCLE95("PART",2,,,0.2,,,,1)', "FAL"),
        ('CYCLE95("PART",2,,,,,,,4)', "inside"),
        ('CYCLE62("PART",0,,)\nCYCLE952("P","","",101311,0.3)', "finishing along or across"),
        ('CYCLE62("PART",0,,)\nCYCLE952("P","","",101421,0.3)', "other way round"),
        ('CYCLE952("P","","",101321,0.3)', "no CYCLE62"),
    ],
)
def test_what_is_not_followed_is_said_and_nothing_moves(call: str, why: str) -> None:
    path = run(text(OUTSIDE, call))
    (found,) = (found for found in path.findings if found.code == Code.NC_OPAQUE)
    assert why in found.message and len(path) == 2


def test_relief_cuts_are_not_roughed_but_finished() -> None:
    contour = OUTSIDE.replace("Z-25", "Z-18\nX24 Z-20\nZ-25").replace("G2 X36", "X26\nG2 X36")
    path = run(text(contour, 'CYCLE95("PART",2,,,,,,,9)'))
    assert any("relief cuts" in found.message and found.severity == "warning" for found in path.findings)
    assert set(path.line.tolist()) > set(range(8, 17))


def test_a_contour_that_calls_its_own_cycle_ends() -> None:
    source = text('G1 X20 Z0\nCYCLE95("PART",2,,,,,,,5)\nZ-10', 'CYCLE95("PART",2,,,,,,,5)')
    path = read_program(source.encode(), "siemens").run(strict=False)
    assert len(path) < 1000 and any(found.code == Code.NC_LIMIT for found in path.findings)
