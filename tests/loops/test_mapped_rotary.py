"""Rotary axes: a displacement along X, Y, Z is not that of a part that stands turned, and is not written."""

from pathlib import Path

import pytest

from tests.support.mapped import mapped
from tests.support.refusals import refused
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import similarity_field

SHIFT = similarity_field(shift_mm=(0.01, 0.0, 0.01))
AT_ZERO = "G21 G90 G0 A0. X0. Y0. Z5.\nG1 Z-1. F100.\nX10.\n"


def refused_at(folder: Path, text: str, dialect: str = "fanuc-mill") -> TrueloopError:
    (folder / "mapped.ngc").unlink(missing_ok=True)
    error = refused(mapped, folder, text, SHIFT, dialect)
    assert error.code is Code.NC_MAP
    assert not (folder / "mapped.ngc").exists()
    return error


@pytest.mark.parametrize(
    ("dialect", "turned"),
    [
        ("fanuc-mill", "G0 A90."),
        ("haas-mill", "G0 B-90."),
        ("linuxcnc", "G0 A90"),
        ("linuxcnc", "G0 C[#<_x>+30]"),
        ("siemens", "G0 C=DC(90)"),
        ("fanuc-mill", "G91 A90.\nG90"),
        ("fanuc-mill", "G91 G28 A0.\nG90"),
        ("fanuc-mill", "G92 A30."),
        ("linuxcnc", "G0 A0 X0 Y0 Z5\nG28\nG0 X0 Y0 Z5"),  # all axes go home, A with them
    ],
)
def test_a_cut_is_refused_where_an_axis_stands_turned(tmp_path: Path, dialect: str, turned: str) -> None:
    axis = f"{next(letter for letter in 'ABC' if letter in turned.replace('DC(', '('))}0."
    before = AT_ZERO.replace("A0.", axis).replace("G21", "G71" if dialect == "siemens" else "G21")
    error = refused_at(tmp_path, f"{before}G0 Z5.\n{turned}\nG0 X0.\nG1 Z-1.\nX20.\nM30\n", dialect)
    assert error.place.line == 7 + turned.count("\n")
    assert "0 degrees" in error.message
    mapped(tmp_path, f"{before}G0 Z5.\nX0.\nG1 Z-1.\nX20.\nM30\n", SHIFT, dialect)


def test_the_frame_of_the_turned_part_would_have_been_another(tmp_path: Path) -> None:
    """At A90 the part's z lies along the machine's y: 10 µm along z would have cut 10 µm of the wrong side."""
    error = refused_at(tmp_path, "G21 G0 A90.\nG0 X0. Y0. Z5.\nG1 Z-1. F100.\n")
    assert error.place.line == 3
    assert error.message.startswith("A does not stand at 0 degrees")


def test_a_whole_turn_is_none_and_back_at_zero_it_goes_on(tmp_path: Path) -> None:
    mapped(tmp_path, AT_ZERO + "G0 Z5.\nA90.\nG0 A0.\nG1 Z-1.\nG0 Z5.\nA360.\nG1 Z-1.\n", SHIFT, "fanuc-mill")
    error = refused_at(tmp_path, AT_ZERO + "G1 A90. X20.\n")
    assert error.place.line == 4
    error = refused_at(tmp_path, AT_ZERO + "G0 Z5.\nA90.\nG1 A0. Z-1.\n")
    assert error.place.line == 6


def test_an_axis_that_is_named_only_later_stands_nobody_knows_where(tmp_path: Path) -> None:
    text = "G21 G90 G0 X0. Y0. Z5.\nG1 Z-1. F100.\nG0 Z5.\nA0.\nG1 Z-1.\n"
    assert refused_at(tmp_path, text).place.line == 2
    long = "G21 G90 G0 X0. Y0. Z5.\nG1 Z-1. F100.\n" + "X1.\nX2.\n" * 40_000 + "G0 Z5.\nA0.\n"
    assert refused_at(tmp_path, long).place.line == 2


def test_axes_of_sinumerik_with_a_number_are_not_told_apart(tmp_path: Path) -> None:
    assert refused_at(tmp_path, "G71 G90 G0 X0 Y0 Z5 A1=0\nG1 Z-1 F100\n", "siemens").place.line == 2


def test_arguments_of_macros_are_no_axes(tmp_path: Path) -> None:
    text = "G21 G90 G0 X0. Y0. Z5.\nG1 Z-1. F100.\nG65 P9 A90. B3.\nG1 X2.\nM30\nO9\n#9=#1\nM99\n"
    mapped(tmp_path, text, SHIFT, "fanuc-mill")


TILTED = [
    *(("fanuc-mill", code) for code in ("G68.2 X0. Y0. Z0. I0. J90. K0.", "G43.4 H1", "G43.5 H1", "G68 X0. Y0. R90.")),
    *(("fanuc-mill", code) for code in ("G54.2 P1", "G54.4 P1", "G07.1 A10.", "G12.1", "G53.1")),
    *(("haas-mill", code) for code in ("G234 H1", "G254", "G268 X0. Y0. Z0. I0. J90. K0.", "G68 X0. Y0. R90.")),
    *(("siemens", code) for code in ("TRAORI", "TRANSMIT", "TRACYL(20)", "ROT X90", "AROT X90", "CYCLE800(1)")),
    *(("siemens", code) for code in ("TOROT", "TOFRAME", "MIRROR X0")),
    *(("heidenhain", f"{code}") for code in ("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY", "M128", "CYCL DEF 19.1 B+90")),
    *(("fanuc-lathe", code) for code in ("G12.1", "G112", "G7.1 C20.")),
]


@pytest.mark.parametrize(("dialect", "code"), TILTED)
def test_a_tilted_plane_is_refused(tmp_path: Path, dialect: str, code: str) -> None:
    if dialect == "heidenhain":
        text = f"BEGIN PGM A MM\nL X+0 Y+0 Z+5 FMAX\n{code}\nL Z-1 F100\nEND PGM A MM\n"
    else:
        text = f"{'G71' if dialect == 'siemens' else 'G21'} G90 G0 X0. Y0. Z5.\n{code}\nG1 Z-1. F100.\nX5.\nM30\n"
        text = text.replace(" Y0.", "") if dialect == "fanuc-lathe" else text
    with pytest.raises(TrueloopError) as raised:
        mapped(tmp_path, text, SHIFT, dialect)
    assert raised.value.code in (Code.NC_OPAQUE, Code.NC_CODE, Code.NC_WORD, Code.NC_MAP)
    assert raised.value.place.line in (3, 4) if dialect == "heidenhain" else raised.value.place.line in (2, 3)
    assert not (tmp_path / "mapped.ngc").exists()


def test_c_of_a_lathe_excuses_no_other_axis(tmp_path: Path) -> None:
    """C turns the work about the axis of X and Z; an axis with a number beside it may tilt the tool."""
    head, cut = "DIAMON G18 G71 G90 G95\nT1 D1\nM3 S500\nG0 X100 Z5", "G1 X90 Z-5 F0.1\nM30\n"
    mapped(tmp_path, f"{head} C=30\n{cut}", SHIFT, "siemens")
    error = refused_at(tmp_path, f"{head} C=30 B1=45\n{cut}", "siemens")
    assert "a rotary axis does not stand at 0 degrees" in error.message
