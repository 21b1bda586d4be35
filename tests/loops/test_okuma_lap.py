"""A contour of LAP that G85 or G86 roughs and G87 finishes: its passes by the slow reference, corrected once."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import intended_mm, moved_mm, touches_on
from tests.loops.test_roughing_choice import passes, same
from tests.support.correction import NOW
from tests.support.roughing_reference import Cycle, Piece, cuts
from trueloop.domain.part import PartType
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import Program, read_program
from trueloop.turned.options import Options, Roughing

NOSE_MM = 0.4
CONTOUR = (
    "N0110 G00 X20 Z2 G42\nN0120 G01 Z-10 F0.1\nN0130 X26 Z-15\nN0140 Z-25\nN0150 G02 X36 Z-30 I5\nN0160 G01 X50\n"
    "N0170 Z-45\nN0180 G40\n"
)
DEFINITION = f"N0100 G81\n{CONTOUR}N0190 G80\n"


def program(call: str = "G85 N0100 D4 U0.4 W0.1 F0.3") -> bytes:
    text = (
        f"O0001\nN0010 G50 S2000\nNAT01\nN0020 G00 X60 Z2 T010101\nN0030 {call}\n{DEFINITION}N0200 G00 X200 Z100\n"
        "NAT02\nN0210 G00 X60 Z4 T020202\nN0220 G87 N0100\nN0230 G00 X62\nN0240 Z100\nN0250 M02\n"
    )
    return text.encode()


def read(source: bytes) -> Program:
    return read_program(source, "okuma-lathe", "shaft.min", unit="mm")


def corrected(source: bytes, roughing: Roughing) -> Correction:
    given = read(source)
    profile = contour_of_program(feed_moves(given.run(roughing=False)), NOSE_MM).profile
    touches = touches_on(profile)
    touches = replace(touches, error_mm=0.02 + 0.3 * touches.error_mm)
    options = Options(roughing=roughing, by="contour")
    return compensate(Inputs(PartType("shaft"), profile, NOSE_MM, given, touches, options, NOW))


PIECES = [
    Piece((10, 2), (10, -10)),
    Piece((10, -10), (13, -15)),
    Piece((13, -15), (13, -25)),
    Piece((13, -25), (18, -30), (18, -25)),
    Piece((18, -30), (25, -30)),
    Piece((25, -30), (25, -45)),
]


def test_bar_turning_is_the_reference_s_but_for_where_it_lifts() -> None:
    """D is a diameter. How far the tool is lifted is the control's: 1.27 mm is taken."""
    source = program().replace(b"X20 Z2 G42", b"X20 G42")
    assert same(passes(read(source)), cuts(Cycle((30, 2), PIECES, (0.2, 0.1)), 2.0, 1.27))


def test_copy_turning_runs_the_contour_from_as_far_off_as_the_manual_says() -> None:
    """Xp = Xs - N D, Zp = Za + W + (Zs - Za - W)(1 - N D / (Xs - Xa - U)), X a diameter: Xs 60, Xa 20, Zs 5, Za 2."""
    source = program("G86 N0100 D15 U0.4 W0.1 F0.3").replace(b"X60 Z2 T01", b"X60 Z5 T01")
    found = passes(read(source))
    a_pass = len(PIECES) + 3  # to its beginning, along the contour, back along Z and along X
    begins = [found[k * a_pass] for k in range(3)]
    share = [1 - number * 15 / (60 - 20 - 0.4) for number in (1, 2)]
    wanted = [(22.5, 2.1 + 2.9 * share[0]), (15.0, 2.1 + 2.9 * share[1]), (10.2, 2.1)]
    assert len(found) == 3 * a_pass and np.allclose([row[1:] for row in begins], wanted, atol=1e-9)
    ends = [row[1:] for row in found[2 * a_pass + 1 : -2]]
    assert np.allclose(ends, [piece.moved((0.2, 0.1)).end for piece in PIECES], atol=1e-9)
    assert found[-1] == ("rapid", 30.0, 5.0) and [row[2] for row in found[a_pass - 2 : a_pass]] == [5.0, 5.0]


@pytest.mark.parametrize("roughing", ["moves", "stays"])
def test_the_contour_is_corrected_once(roughing: Roughing, tmp_path: Path) -> None:
    source = program()
    found = corrected(source, roughing)
    written = found.corrected_program.decode()
    stays = roughing == "stays"
    head = "NLAP1 G81\n" if stays else "N0100 G81\n"
    assert written.count(CONTOUR) == int(stays) and written.count(head) == 1
    assert ("G87 NLAP1" in written) == stays and "G85 N0100 D4" in written
    blocks = written[written.index(head) + len(head) :].partition("G80")[0].splitlines()[:-1]
    moves = [re.sub(r"^N\d+ ", "", block) for block in blocks if "G40" not in block]
    text = "\n".join(["G21 G7 G18 G40 G90 G94 F10 T1 M6", "G0 X60 Z4", *moves, "G40", "M2", ""])
    assert np.abs(moved_mm(found, text, tmp_path) - intended_mm(found)).max() < 0.0002 + 0.0015
    assert np.abs(intended_mm(found)).max() > 0.015
    if stays:
        assert same(passes(read(found.corrected_program)), passes(read(source)))
