"""`trueloop nc map` as a user meets it: slips of the command line and of names, all obstacles of a program at once."""

import json
import re
import shlex
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus


@pytest.mark.parametrize("degrees", ["nan", "inf", "-inf"])
def test_a_turn_is_a_number(tmp_path: Path, degrees: str) -> None:
    (tmp_path / "part.nc").write_text("G21 G90\nG0 X0 Y0 Z5.\nG1 X1. F100\n")
    command = ("nc", "map", tmp_path / "part.nc", "-d", "fanuc-mill", f"--rotate={degrees}", "-o", tmp_path / "out.nc")
    done = invoke(*command, status=ExitStatus.USAGE)
    assert f"{degrees} is no angle in degrees" in done.stderr
    assert not (tmp_path / "out.nc").exists()


def test_a_mistyped_program_is_answered_with_the_nearest_name(tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text("G21 G90\nG0 X0 Y0 Z5.\n")
    command = ("nc", "map", tmp_path / "prat.nc", "-d", "fanuc-mill", "--rotate", "1", "-o", tmp_path / "out.nc")
    assert f"did you mean '{tmp_path / 'part.nc'}'?" in invoke(*command, status=ExitStatus.REFUSED).stderr


OBSTACLES = """G21 G90
G0 X10. Y0
G1 X20. F100
G0 Z5.
M98 P7777
G12 I5. D1
G1 X30. Z-1. F100
G92 X0
G1 X40.
M30
"""


def test_a_dry_run_lists_all_obstacles_with_line_and_code(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text(OBSTACLES)
    command = ("nc", "map", program, "-d", "fanuc-mill", "--scale", "1.001")
    shown = invoke(*command, "--dry-run", status=ExitStatus.FINDINGS).stdout
    places = re.findall(rf"^{re.escape(str(program))}:(\d+):\d+: ([A-Z-]+): ", shown, re.M)
    assert places == [("3", "NC-MAP"), ("5", "NC-FLOW"), ("6", "NC-CODE"), ("8", "NC-MAP")], shown
    assert shown.endswith(f"{program}: 4 obstacles, nothing is written\n")
    assert list(tmp_path.iterdir()) == [program]
    listed = json.loads(invoke(*command, "--dry-run", "--json", status=ExitStatus.FINDINGS).stdout)["obstacles"]
    assert [one["place"]["line"] for one in listed] == [3, 5, 6, 8]
    first = invoke(*command, "-o", tmp_path / "out.nc", status=ExitStatus.REFUSED).stderr
    assert f"{program}:5:1: NC-FLOW" in first


def test_a_dry_run_lists_all_obstacles_of_a_program_whose_chamfers_would_be_written_out(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text(
        "G21 G99\nG0 X40. Z2.\nG1 X20. F0.1\nX#501\nX30. ,C1.\nZ-30.\nM98 P77\nX5025\nG28 U0\nG1 Z-31.\nM30\n"
    )
    shown = invoke(
        "nc", "map", program, "-d", "fanuc-lathe", "--scale", "1.001", "--dry-run", status=ExitStatus.FINDINGS
    ).stdout
    places = re.findall(rf"^{re.escape(str(program))}:(\d+):\d+: ([A-Z-]+): ", shown, re.M)
    assert places == [("4", "NC-PARAMETER"), ("7", "NC-FLOW"), ("8", "NC-PARAMETER"), ("10", "NC-MAP")], shown
    assert json.loads(invoke("nc", "check", program, "-d", "fanuc-lathe", "--json").stdout)["obstacles_to_map"] == 4


@pytest.mark.parametrize(
    ("block", "count"),
    [("G0 X0 Y0 Z5.\nG1 X30. F100\nG92 X0\n", 1), ("G0 X0 Y0 Z5.\nG1 X30. F100\n", 0), ("G1 X30. F100\nY5.\n", 1)],
)
def test_check_counts_the_obstacles_and_names_the_command_that_lists_them(
    tmp_path: Path, block: str, count: int
) -> None:
    program = tmp_path / "part.nc"
    program.write_text(f"G21 G90\n{block}M30\n")
    shown = invoke("nc", "check", program, "-d", "fanuc-mill").stdout
    found = re.search(r"(\d+) obstacle to `nc map`: `trueloop ([^`]+)` lists", shown)
    assert bool(found) == bool(count), shown
    as_json = json.loads(invoke("nc", "check", program, "-d", "fanuc-mill", "--json").stdout)
    assert as_json["obstacles_to_map"] == count
    if found:
        listed = invoke(*shlex.split(found[2]), status=ExitStatus.FINDINGS).stdout
        assert f"{program}: {count} obstacle, nothing is written" in listed


def test_the_command_that_check_names_reads_the_program_as_check_did(tmp_path: Path) -> None:
    """In a folder with a blank; by the unit, the parameter and the skipped blocks that were given."""
    folder = tmp_path / "Gehäuse 1"
    folder.mkdir()
    program = folder / "part.nc"
    program.write_text("G90\nG0 X0 Y0 Z5.\n/M98 P7777\nIF [#100 EQ 1] GOTO 10\nG92 X0\nN10 G1 X1. F100\nM30\n")
    given = ("-d", "fanuc-mill", "--set", "#100=1", "--unit", "inch", "--skipped-blocks")
    shown = invoke("nc", "check", program, *given).stdout
    found = re.search(r"(\d+) obstacle to `nc map`: `trueloop ([^`]+)` lists", " ".join(shown.split()))
    assert found
    (listed,) = json.loads(invoke(*shlex.split(found[2]), "--json", status=ExitStatus.FINDINGS).stdout)["obstacles"]
    assert listed["place"]["line"] == 3
    plain = json.loads(invoke("nc", "check", program, "-d", "fanuc-mill", "--json").stdout)
    assert plain["obstacles_to_map"] == 2, "neither unit nor parameter"


def test_a_program_without_obstacles_is_mapped_and_blocks_of_one_kind_are_counted(tmp_path: Path) -> None:
    (tmp_path / "good.nc").write_text("G21 G90\nG0 X0 Y0 Z5.\nG1 X30. F100\nM30\n")
    command = ("nc", "map", tmp_path / "good.nc", "-d", "fanuc-mill", "--shift", "0.1,0,0")
    assert "0 obstacles" in invoke(*command, "--dry-run").stdout
    invoke(*command, status=ExitStatus.USAGE)
    invoke(*command, "--dry-run", "-o", tmp_path / "out.nc", status=ExitStatus.USAGE)
    steps = "".join(f"G1 X{number}. F100\n" for number in range(1, 40))
    (tmp_path / "far.nc").write_text(f"G21 G90\nG0 X0 Y0 Z5.\n{steps}M30\n")
    (tmp_path / "field.csv").write_text("x_mm,dx_um\n-1,0\n10.5,1\n")
    table = ("--table", tmp_path / "field.csv", "--dry-run")
    shown = invoke("nc", "map", tmp_path / "far.nc", "-d", "fanuc-mill", *table, status=ExitStatus.FINDINGS).stdout
    assert f"{tmp_path / 'far.nc'}:13:1: NC-FIELD" in shown and "and 28 more of this kind, to line 41" in shown
