"""The offsets file: what T0101 adds, and what is wrong in a file."""

from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.files import read_as_file
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.offsets_toml import OffsetTables, read_offsets
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program

FILE = """
[[work]]
name = "G54"
z_mm = -120.0

[[work]]
name = "G54.1P2"
x_radius_mm = 5.0
y_mm = 6.0

[[tool]]
number = 1
radius_mm = 0.8
tip = 3
x_radius_mm = -150.0
z_mm = -80.0
wear_x_radius_mm = 0.25

[[tool]]
number = 12
radius_mm = 0.0
length_mm = 50.0
"""


def tables(text: str) -> OffsetTables:
    found = read_as_file(text, read_offsets)
    assert isinstance(found, OffsetTables)
    return found


def test_geometry_and_wear_add_up_and_offsets_have_numbers() -> None:
    found = tables(FILE)
    assert found.tools == (CutterTool(0.8, 3, 1, None, (-149.75, 0.0, -80.0)), CutterTool(0.0, None, 12, 50.0, None))
    assert found.work_mm == ((1, (0.0, 0.0, -120.0)), (102, (5.0, 6.0, 0.0)))


@pytest.mark.parametrize(
    ("before", "after", "line", "why"),
    [
        ("wear_x_radius_mm", "wear_x_mm", 17, "wear_x_mm"),
        ("radius_mm = 0.8", "radius_mm = -0.8", 13, "-0.8"),
        ("tip = 3", "tip = 10", 14, "10"),
        ('"G54"', '"G53"', 3, "'G53' is no work offset"),
        ('"G54.1P2"', '"G54"', 6, "work 2 of the file is given before"),
        ("number = 12", "number = 1", 19, "tool 2 of the file is given before"),
        ("[[tool]]", "[[tools]]", 11, "tools"),
        ("number = 1\n", "number = true\n", 12, "True"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(before: str, after: str, line: int, why: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        tables(FILE.replace(before, after))
    assert (refused.value.code, refused.value.place and refused.value.place.line) == (Code.NC_FILE, line)
    assert why in str(refused.value)


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "fanuc-lathe-b", "haas-lathe"])
def test_the_machine_stands_at_program_and_offsets(dialect: str) -> None:
    """X60. is radius 30, at machine x = 30 - 149.75; without offset after T0100. G53 X0 is at program x = 149.75."""
    found = tables(FILE)
    text = "G21\nG00 X60. Z2.\nT0101\nG00 X60. Z2.\nG53 X0\nT0100\nG00 X60. Z2.\n"
    path = read_program(text.encode(), dialect).run(tools=found.tools, work_offsets_mm=dict(found.work_mm))
    assert path.findings == ()
    assert path.end_mm[:, 0] == pytest.approx([30, 30, 149.75, 30])
    assert (path.end_mm + path.origin_mm)[:, 0] == pytest.approx([30, -119.75, 0, 30])
    assert (path.end_mm + path.origin_mm)[[0, 1, 3], 2] == pytest.approx([-118, -198, -118])
    assert path.start_mm[1, [0, 2]] == pytest.approx([179.75, 82])


def test_an_offset_that_is_not_given_is_none_and_said() -> None:
    found = tables(FILE)
    path = read_program(b"G21\nT0101\nT1212\nG00 X60. Z2.\n", "fanuc-lathe").run(tools=found.tools)
    assert [(said.code, said.place.line) for said in path.findings] == [(Code.NC_OPAQUE, 3)]
    assert (path.origin_mm == 0).all()


def test_the_command_takes_the_file(tmp_path: Path) -> None:
    program, file = tmp_path / "part.nc", tmp_path / "offsets.toml"
    program.write_text("G21\nT0101\nG00 X60. Z2.\nG53 X0\n")
    file.write_text(FILE)
    command = ("nc", "path", program, "--dialect", "fanuc-lathe", "--offsets", file)
    assert "149.75" in invoke(*command, status=0).stdout.splitlines()[-1]
    file.write_text(FILE.replace("tip", "tipp"))
    assert "NC-FILE" in invoke(*command).stderr
