"""A field of machine coordinates over a program: machine = program + G52 … + work offset + tool offset, by hand."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from tests.support.machined_path import corrected
from tests.support.machines import chain_with_travel, random_model
from tests.support.mapped import mapped
from trueloop.errors import Code, TrueloopError
from trueloop.machine.correct import Setup
from trueloop.machine.model.model import Machine
from trueloop.machine.model.term import mill_terms, turning_terms
from trueloop.nc.field import Field, field_in_machine, function_field, machine_field
from trueloop.nc.program.called import CutterTool

STRETCHED = function_field(lambda p: 1e-3 * p, "stretched")
"""1 µm a millimetre of position, along each axis."""
WORK = {1: (5.0, -3.0, -120.0), 2: (105.0, 0.0, -20.0)}
LONG = CutterTool(5.0, None, 1, 50.0)
TURNING = CutterTool(0.8, 3, 1, None, (-149.75, 0.0, -80.0))


def in_machine(*tools: CutterTool) -> Field:
    return field_in_machine(STRETCHED, tools, WORK)


def test_a_mill_stands_at_program_work_offset_and_length(tmp_path: Path) -> None:
    """X 10 + 5 + 7 by G52, Y 10 − 3, Z 5 − 120 + 50 in the machine; then G55, where G44 takes the length away."""
    program = "G21 G90 G54\nG52 X7. Y0. Z0.\nG43 H1 G0 X10. Y10. Z5.\nG55 G44 H1 X10. Y10. Z5.\n"
    text, _ = mapped(tmp_path, program, in_machine(LONG), "fanuc-mill")
    assert text.splitlines()[-2:] == ["G43 H1 G0 X10.022 Y10.007 Z4.935", "G55 G44 H1 X10.122 Y10.010 Z4.935"]


def test_a_lathe_stands_at_program_work_offset_and_table(tmp_path: Path) -> None:
    """X60.2 is 30.1 − 149.75 + 5 in the machine on the radius, Z 2 − 80 − 120; T0100 takes the tool's part away."""
    program = "G21 T0101\nG00 X60.2 Z2.\nT0100\nG00 X60.2 Z2.\n"
    text, _ = mapped(tmp_path, program, in_machine(TURNING), "fanuc-lathe")
    assert text.splitlines()[-3:] == ["G00 X59.971 Z1.802", "T0100", "G00 X60.270 Z1.882"]


@pytest.mark.parametrize(
    ("program", "dialect", "line", "why"),
    [
        (
            "G21 G90\nG43 H1 G0 X0. Y0. Z5.\nG43 H2 X0. Y0. Z9.\n",
            "fanuc-mill",
            3,
            "the tool offset in force before the first T is not known",
        ),
        (
            "G21 T0101\nG0 X20. Z5.\nT0202\nG0 X20. Z5.\n",
            "fanuc-lathe",
            4,
            "the tool offset in force after T202 is not known",
        ),
        ("G21\nG0 X20. Z5.\n", "haas-lathe", 2, "before the first T is not known"),
        ("G71 G90 G17\nT3 D1\nG0 X0 Y0 Z5\n", "siemens", 3, "in force after T3 is not known"),
        ('G71 G90 G17\nT="MILL 10" D1\nG0 X0 Y0 Z5\n', "siemens", 3, "called by its name"),
        ("BEGIN PGM A MM\nTOOL CALL 3 Z\nL X+0 Y+0 Z+5 F MAX\n", "heidenhain", 3, "after T3 is not known"),
        ("G71 G90\nT0101\nG0 X20. Z5.\n", "ge2000t", 3, "after T101 is not known"),
        ("G21 G90 G56\nG0 X0. Y0. Z5.\n", "fanuc-mill", 2, "work offset 3 is used, but only 1, 2 is known"),
        ("G21 G90\nG10 L2 P1 X5.\nG0 X0. Y0. Z5.\n", "fanuc-mill", 2, "sets an offset, by G10"),
        ("BEGIN PGM A MM\nTCH PROBE 412 A\nL X+0 Y+0 Z+5 FMAX\n", "heidenhain", 2, "by G10 or a probe"),
    ],
)
def test_what_is_not_in_the_file_is_refused(tmp_path: Path, program: str, dialect: str, line: int, why: str) -> None:
    field = in_machine(TURNING if "lathe" in dialect else LONG)
    with pytest.raises(TrueloopError, match=why) as refused:
        mapped(tmp_path, program, field, dialect)
    assert (refused.value.code, refused.value.place and refused.value.place.line) == (Code.MCH_FRAME, line)


def test_a_register_set_at_a_place_of_the_machine(tmp_path: Path) -> None:
    """G53 Z0, called Z100 from then on: Z50 is machine −50, whatever offsets are in force."""
    program = "G21 G90 G54\nG43 H1 G0 X0. Y0. Z5.\nG53 G0 X0. Y0. Z0.\nG92 X0. Y0. Z100.\nG0 X0. Y0. Z50.\n"
    text, _ = mapped(tmp_path, program, in_machine(LONG), "fanuc-mill")
    assert text.splitlines()[-1] == "G0 X0. Y0. Z49.950"


@pytest.mark.parametrize(
    ("program", "dialect", "line"),
    [
        ("G21 G90 G54\nG53 G0 X0. Y0. Z0.\nG92 X0. Y0. Z100.\nG0 X0. Y0. Z50.\n", "fanuc-mill", 3),
        ("G21\nG50 S2000\nG28 U0 W0\nG50 X200. Z300.\nT0101\nG0 X60. Z5.\n", "fanuc-lathe", 4),
    ],
)
def test_a_register_set_at_a_place_of_the_machine_wants_the_table(
    tmp_path: Path, program: str, dialect: str, line: int
) -> None:
    """With the tool's vector alone, what the place is called would be off by it."""
    field = machine_field(lambda points, *_: 0 * points, {})
    with pytest.raises(TrueloopError, match="depends on the control's offset of the tool") as refused:
        mapped(tmp_path, program, field, dialect)
    assert (refused.value.code, refused.value.place and refused.value.place.line) == (Code.MCH_FRAME, line)
    lines = program.splitlines(keepends=True)
    without = [text for text in lines if not text.startswith(("G53", "G28"))]
    mapped(tmp_path, "".join(without), field, dialect)


@pytest.mark.parametrize("lathe", [False, True])
def test_the_control_s_table_is_as_good_as_the_tool_s_own_vector(lathe: bool) -> None:
    """The tool's point lies at minus the offset from the last axis' frame: same travel, same lever."""
    machine = Machine("any", chain_with_travel("turning" if lathe else "mill-table-x"))
    terms = (turning_terms if lathe else mill_terms)(machine.chain)
    model = random_model(machine, terms, np.random.default_rng(5))
    if lathe:
        zero, offset, dialect = (60.0, 0.0, -60.0), (-20.0, 0.0, -25.0), "fanuc-lathe"
        tool = CutterTool(0.8, 3, 1, None, offset)
        part = "G21 T0101\nG00 X60. Z-10.\nG01 X60. Z-80. F.2\n"
    else:
        zero, offset, dialect = (250.0, 10.0, -260.0), (0.0, 0.0, 120.0), "linuxcnc"
        tool = CutterTool(5.0, None, 1, 120.0)
        part = "G21 T1 M6 G43\nG0 X-80 Y-60 Z5\nG1 X80 Y60 F200\n"
    x, y, z = (-value for value in offset)
    by_vector = corrected(part, model, Setup({1: zero}, {-1: (x, y, z)}), dialect=dialect)
    by_table = corrected(part, model, Setup({1: zero}, {}, table=[tool]), dialect=dialect)
    assert by_table == by_vector != part
    by_other = corrected(part, model, Setup({1: zero}, {-1: (x, y, z + 9)}), dialect=dialect)
    assert by_table != by_other


FILE = """
[[work]]
name = "G54"
x_radius_mm = 5.0
y_mm = -3.0
z_mm = -120.0
[[tool]]
number = 1
radius_mm = 5.0
length_mm = 50.0
"""


def test_the_command_takes_frame_and_file_together(tmp_path: Path) -> None:
    program, file, table = (tmp_path / name for name in ("part.nc", "offsets.toml", "field.csv"))
    program.write_text("G21 G90 G54\nG43 H1 G0 X10. Y10. Z5.\n")
    file.write_text(FILE)
    table.write_text("z_mm,dz_um\n-100,-100\n0,0\n")
    command = ("nc", "map", program, "-d", "fanuc-mill", "--table", table, "-o", tmp_path / "out.nc")
    invoke(*command, "--frame", "machine", "--offsets", file, status=0)
    assert (tmp_path / "out.nc").read_text().splitlines()[-1] == "G43 H1 G0 X10. Y10. Z4.935"
    for half in (("--frame", "machine"), ("--offsets", file)):
        assert "go together" in invoke(*command, *half, status=2).stderr.replace("\n", " ")
