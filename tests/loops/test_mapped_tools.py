"""A field over a program that changes tools and offsets: what only the control knows is never written."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.mapped import mapped
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import function_field

SLOPED = function_field(lambda p: 1e-3 * p + 0.01, "sloped")
"""1 µm a millimetre along each axis, and 10 µm."""

CHANGES = [
    ("linuxcnc", "G21\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "T2 M6"),
    ("linuxcnc", "G21\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "G43 H2"),
    ("linuxcnc", "G21 G43 H2\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "G49"),
    ("linuxcnc", "G21\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "G43.1 Z30"),
    ("linuxcnc", "G21\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "G55"),
    ("linuxcnc", "G21 G18 G8\nG0 X10 Z5\n{}\nG0 Z20\n", "G43 H2"),
    ("haas-mill", "G21 G90\nG0 X10. Y10. Z5.\n{}\nG0 X20. Y20.\n", "T2 M6"),
    ("fanuc-mill", "G21 G90\nG0 X10. Y10. Z5.\n{}\nG0 X20. Y20.\n", "G54.1 P2"),
    ("fanuc-lathe", "G21 T0101\nG0 X10. Z5.\n{}\nG0 X20.\n", "T0202"),
    ("fanuc-lathe", "G21 T0101\nG0 X10. Z5.\n{}\nG0 X20.\n", "T0111"),
    ("ge2000t", "G71 G90\nG0 X10. Z5.\n{}\nG0 X20.\n", "T0202"),
    ("siemens", "G71 G90 G17\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "T2"),
    ("siemens", "G71 G90 G17\nT1 M6\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "T2 M6"),
    ("siemens", 'G71 G90 G17\nT="MILL 10"\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n', 'T="MILL 6" D1'),
    ("siemens", "G71 G90 G17 T1\nG0 X10 Y10 Z5\n{}\nG0 X20 Y20\n", "D2"),
    ("heidenhain", "BEGIN PGM A MM\nL X+10 Y+10 Z+5 F MAX\n{}\nL X+20 Y+20 F MAX\n", 'TOOL CALL "MILL" Z S9'),
    ("heidenhain", "BEGIN PGM A MM\nL X+10 Y+10 Z+5 F MAX\n{}\nL X+20 Y+20 F MAX\n", "TOOL CALL 2 Z S1000"),
]


@pytest.mark.parametrize(("dialect", "program", "change"), CHANGES)
def test_a_coordinate_from_before_a_change_is_never_written(
    tmp_path: Path, dialect: str, program: str, change: str
) -> None:
    """The rapid move after it has an axis that nobody knows: it stays as it is. Without the change it is displaced."""
    last = program.splitlines()[-1]
    text, _ = mapped(tmp_path, program.format(change), SLOPED, dialect)
    assert text.splitlines()[-1] == last
    text, _ = mapped(tmp_path, program.format(""), SLOPED, dialect)
    assert text.splitlines()[-1] != last


@pytest.mark.parametrize(("dialect", "program", "change"), CHANGES)
def test_a_cut_needs_positions_after_a_change(tmp_path: Path, dialect: str, program: str, change: str) -> None:
    cuts = program.replace(" F MAX", " F100") if dialect == "heidenhain" else program + "G1 F100\n"
    cuts = cuts.replace("\nG0 X20", "\nG1 X20").replace("\nG0 Z20", "\nG1 Z20")
    with pytest.raises(TrueloopError, match="has no position since tool or offset changed") as refused:
        mapped(tmp_path, cuts.format(change), SLOPED, dialect)
    assert refused.value.code is Code.NC_MAP


@pytest.mark.parametrize(
    ("dialect", "program"),
    [
        ("linuxcnc", "G21\nT1 M6\nG0 X10 Y10 Z5\nT2\nG0 X20 Y20\n"),
        ("fanuc-lathe", "G21 T0101\nG0 X10. Z5.\nT0101\nG0 X20.\n"),
        ("siemens", "G71 G90 G17\nT1 M6\nG0 X10 Y10 Z5\nT2\nG0 X20 Y20\n"),
        ("linuxcnc", "G21 G43 H1\nG0 X10 Y10 Z5\nG43 H1 G54\nG0 X20 Y20\n"),
    ],
)
def test_what_changes_nothing_leaves_positions_known(tmp_path: Path, dialect: str, program: str) -> None:
    """A tool made ready, and what is in force already, called again: Z is written, as the field has it."""
    text, _ = mapped(tmp_path, program, SLOPED, dialect)
    assert text.splitlines()[-1] != program.splitlines()[-1]


def test_a_length_leaves_the_other_axes_known(tmp_path: Path) -> None:
    """G43 is about Z: X and Y are written as they were displaced."""
    tilted = function_field(lambda p: np.outer(p[:, 2], [0.001, 0.0, 0.0]), "tilted")
    text, _ = mapped(tmp_path, "G21\nG0 X10 Y10 Z5\nG43 H1 Z50\nG1 Z-1 F100\n", tilted)
    assert text.splitlines()[-2:] == ["G43 X10.05000 H1 Z50", "G1 X9.99900 Z-1 F100"]


def test_a_new_tool_is_displaced_once_every_axis_is_named(tmp_path: Path) -> None:
    program = "G21\nT1 M6\nG0 X10 Y10 Z5\nT2 M6\nG0 X20 Y20\nZ8\nG1 X30 F100\n"
    text, _ = mapped(tmp_path, program, SLOPED)
    assert text.splitlines()[-3:] == ["G0 X20 Y20", "X20.03000 Y20.03000 Z8.01800", "G1 X30.04000 F100"]
