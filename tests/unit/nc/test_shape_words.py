"""Moves that may be displaced, and those whose shape hangs on words that would stay behind."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.changes import require_own_shape
from trueloop.nc.program.program import read_program

LATHE = "G18 G71 DIAMON\nG1 X10 Z0 F1\n"
MILL = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 F100\n2 L X+10\n"


def checked(text: str, dialect: str, *, absolute_centres: bool = True) -> None:
    program = read_program(text.encode(), dialect)
    path = program.run()
    require_own_shape(program, path, range(len(path)), absolute_centres=absolute_centres)


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        (LATHE + "G3 X20 Z5 I0 K5", "siemens"),
        (LATHE + "G3 X20 Z5 CR=5", "siemens"),
        (LATHE + "G3 X20 Z5 I=AC(10) K=AC(5)", "siemens"),
        (MILL + "3 CR X+20 Y+10 R+10 DR+", "heidenhain"),
    ],
)
def test_an_arc_given_in_its_own_block_has_its_shape(text: str, dialect: str) -> None:
    checked(text, dialect)


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        (LATHE + "G3 X20 Z5 AR=90", "siemens"),
        (LATHE + "CT X20 Z5", "siemens"),
        (LATHE + "G1 Z5\nCT X20 Z10\nX30 Z10", "siemens"),
        (LATHE + "CT X20 Z5 R1=5", "siemens"),
        (LATHE + "CIP X20 Z5 I1=17 K1=1.4", "siemens"),
        (LATHE + "G3 X20 Z5 I0 K5 TURN=1", "siemens"),
        (LATHE + "G111 X0 Z0\nG1 AP=90 RP=20", "siemens"),
        (LATHE + "G1 Z5 ANG=45", "siemens"),
        (MILL + "3 CT X+20 Y+10", "heidenhain"),
        (MILL + "3 CTP PR+20 PA+45", "heidenhain"),
        (MILL + "3 CC X+10 Y+10\n4 C X+20 Y+10 DR+", "heidenhain"),
        (MILL + "3 CC X+10 Y+10\n4 CP IPA+90 DR+", "heidenhain"),
        (MILL + "3 CC X+0 Y+0\n4 LP PR+20 PA+45", "heidenhain"),
    ],
)
def test_a_move_that_other_words_shape_is_refused(text: str, dialect: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        checked(text, dialect)
    assert refused.value.code == Code.NC_EDIT
    assert refused.value.place is not None
    assert refused.value.hint


def test_a_centre_given_as_a_position_can_be_refused() -> None:
    with pytest.raises(TrueloopError, match=r"I=AC\(10\) shapes this move"):
        checked(LATHE + "G3 X20 Z5 I=AC(10) K=AC(5)", "siemens", absolute_centres=False)
