"""`trueloop nc`: tool paths and findings."""

import csv
import io
import json
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus

EXAMPLES = Path(__file__).parents[3] / "examples"
FINISH = EXAMPLES / "modbas2" / "finish.nc"
SET = ("--set", "P42=8", "--set", "P46=3.52", "-s", " P47 = 0 ")


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    """A program whose arc does not end on its circle, on line 4."""
    path = tmp_path / "odd.ngc"
    path.write_text("G18 G21 G90 G8\nG0 X20 Z0\nG1 X20 Z-5 F0.1\nG2 X10 Z5 I-10 K0.5\nM2\n")
    return path


def test_the_path_in_mm_with_radii_from_inches_and_diameters() -> None:
    result = invoke("nc", "path", str(FINISH), "--dialect", "ge2000t", *SET, "--format", "csv")
    assert result.exit_code == ExitStatus.DONE, result.stderr
    rows = list(csv.DictReader(io.StringIO(result.stdout)))
    (cylinder,) = [row for row in rows if row["line"] == "26"]
    assert float(cylinder["x_mm"]) == pytest.approx((3.52 + 0.0625) / 2 * 25.4, abs=1e-9)
    assert float(cylinder["z_mm"]) == pytest.approx((-1.76875 + (3.6 - 3.52) / 2) * 25.4, abs=1e-9)
    assert (cylinder["motion"], cylinder["feed"], cylinder["feed_unit"]) == ("line", "0.127", "mm/rev")


def test_json_says_the_same_as_csv() -> None:
    rows = list(csv.DictReader(io.StringIO(invoke("nc", "path", str(FINISH), *SET).stdout)))
    told = json.loads(invoke("nc", "path", str(FINISH), *SET, "-f", "json").stdout)
    assert (told["file"], told["dialect"]) == (str(FINISH), "ge2000t")
    for row, move in zip(rows, told["moves"], strict=True):
        for name, cell in row.items():
            assert move[name] == (None if cell == "" else cell if name in ("motion", "feed_unit") else float(cell))


@pytest.mark.parametrize("program, dialect", [("modbas2/finish.nc", "ge2000t"), ("linuxcnc/finish.ngc", "linuxcnc")])
def test_the_dialect_is_found_where_the_text_leaves_no_doubt(program: str, dialect: str) -> None:
    told = json.loads(
        invoke("nc", "path", str(EXAMPLES / program), *(SET if dialect == "ge2000t" else ()), "-f", "json").stdout
    )
    assert told["dialect"] == dialect


def test_where_it_leaves_doubt_the_dialect_is_asked_for(tmp_path: Path) -> None:
    plain = tmp_path / "plain.nc"
    plain.write_text("G01 X10. Z5.\n")
    result = invoke("nc", "path", str(plain))
    assert result.exit_code == ExitStatus.REFUSED
    assert f"{plain}: NC-DIALECT: " in result.stderr
    assert "--dialect ge2000t or --dialect linuxcnc" in result.stderr


def test_an_unknown_dialect_is_answered_with_the_known_ones() -> None:
    result = invoke("nc", "path", str(FINISH), "--dialect", "fanuc")
    assert result.exit_code == ExitStatus.REFUSED
    assert "unknown NC dialect 'fanuc'" in result.stderr
    assert "ge2000t, linuxcnc" in result.stderr


def test_an_undefined_parameter_is_said_where_it_stands_and_leaves_its_cuts_open() -> None:
    result = invoke("nc", "path", str(FINISH), "--set", "P42=8", "--set", "P47=0")
    assert result.exit_code == ExitStatus.FINDINGS
    assert result.stderr.startswith(f"{FINISH}:17:")
    assert "NC-PARAMETER: parameter P46 has no value" in result.stderr
    collar = next(row for row in csv.DictReader(io.StringIO(result.stdout)) if row["line"] == "22")
    assert (collar["x_mm"], collar["z_mm"]) == ("", "")


def test_a_parameter_of_the_machine_zero_alone_leaves_every_cut_known() -> None:
    """P42 only says where the part's zero is on the machine: it decides a rapid move, and G92 takes over."""
    result = invoke("nc", "path", str(FINISH), "--set", "P46=3.52", "--set", "P47=0")
    assert result.exit_code == ExitStatus.DONE
    assert "parameter P42 has no value" in result.stderr
    cuts = [row for row in csv.DictReader(io.StringIO(result.stdout)) if row["motion"] in ("line", "arc")]
    assert cuts
    assert all(row["x_mm"] and row["z_mm"] for row in cuts)


@pytest.mark.parametrize("setting", ["P46", "P46=", "=3.52", "P46=wide", "P46=1=2"])
def test_a_setting_that_is_none_is_a_usage_error(setting: str) -> None:
    result = invoke("nc", "path", str(FINISH), "--set", setting)
    assert result.exit_code == ExitStatus.USAGE
    assert f"{setting!r} is no name=number" in result.stderr


def test_a_sound_program_has_no_errors() -> None:
    result = invoke("nc", "check", str(FINISH), *SET)
    assert result.exit_code == ExitStatus.DONE
    assert "0 of them errors" in result.stdout


def test_errors_are_told_with_their_place_and_by_the_exit_status(odd: Path) -> None:
    result = invoke("nc", "check", str(odd), "--dialect", "linuxcnc")
    assert result.exit_code == ExitStatus.FINDINGS
    assert f"{odd}:4:" in result.stdout
    assert "error NC-ARC" in result.stdout
    assert result.stderr == ""


def test_findings_as_json(odd: Path) -> None:
    result = invoke("nc", "check", str(odd), "--dialect", "linuxcnc", "--json")
    assert result.exit_code == ExitStatus.FINDINGS
    told = json.loads(result.stdout)
    errors = [finding for finding in told["findings"] if finding["severity"] == "error"]
    assert told["errors"] == len(errors) > 0
    assert errors[0]["place"]["line"] == 4
    assert set(errors[0]) == {"severity", "code", "message", "hint", "place", "values", "unseen"}


def test_a_mistyped_file_name_is_answered_with_the_nearest(odd: Path) -> None:
    result = invoke("nc", "check", str(odd.with_name("od.ngc")))
    assert result.exit_code == ExitStatus.REFUSED
    assert f"did you mean {str(odd)!r}?" in result.stderr


def test_diff_says_where_two_programs_lie_furthest_apart(tmp_path: Path) -> None:
    one, other = tmp_path / "one.ngc", tmp_path / "other.nc"
    one.write_text("G18 G21 G90 G8 F100\nG0 X10 Z0\nG1 Z20\nM2\n")
    other.write_text("G18 G21 G98\nG00 X20. Z0.\nG01 W20. F100.\nX20.25\nM30\n")
    arguments = ("diff", str(one), str(other), "--other-dialect", "fanuc-lathe")
    result = invoke("nc", *arguments, "--tolerance-mm", "0.125")
    assert result.exit_code == ExitStatus.DONE, result.output
    assert "largest distance 0.125000 mm" in result.stdout
    assert "other.nc:4:1  x 10.125000 y 0.000000 z 20.000000 mm, x a radius" in result.stdout
    assert "one.ngc:3:4  x 10.000000 y 0.000000 z 20.000000" in result.stdout
    over = invoke("nc", *arguments, "--tolerance-mm", "0.124", "--json")
    assert over.exit_code == ExitStatus.FINDINGS
    assert json.loads(over.stdout)["at"] | {"file": ""} == {
        "file": "", "line": 4, "column": 1, "position_mm": [10.125, 0.0, 20.0],
    }  # fmt: skip


def test_zeros_of_work_offsets_and_lengths_of_tools_are_told(tmp_path: Path) -> None:
    path = tmp_path / "part.nc"
    path.write_text("G21 G55 G00 Z50.\nG43 H3 Z20.\nM30\n")
    told = ("--offset", "G55=0,0,-120", "--tool", "3=R5,L80")
    rows = list(csv.DictReader(io.StringIO(invoke("nc", "path", str(path), "-d", "fanuc-mill", *told).stdout)))
    assert [row["start_z_mm"] for row in rows] == ["120", "-30"]


def test_a_place_of_the_machine_is_compared_by_the_zeros_of_the_offsets_file(tmp_path: Path) -> None:
    one, other, offsets = tmp_path / "one.nc", tmp_path / "other.nc", tmp_path / "offsets.toml"
    one.write_text("G21 G90 G54 G00 Z50.\nG53 G00 Z-20.\nM30\n")
    other.write_text("G21 G90 G54 G00 Z50.\nG00 Z100.\nM30\n")
    offsets.write_text('[[work]]\nname = "G54"\nz_mm = -120.0\n')
    compared = ("nc", "diff", str(one), str(other), "-d", "fanuc-mill", "--rapids", "--json", "--offsets")
    assert json.loads(invoke(*compared, str(offsets)).stdout)["distance_mm"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("told", "named"),
    [
        (("--offset", "G53=0,0,0"), "G53=0,0,0"),
        (("--offset", "G54=1"), "1"),
        (("--offset", "G54"), "G54"),
        (("--tool", "R5,L"), "R5,L"),
    ],
)
def test_a_mistyped_offset_or_length_is_a_fault_of_the_command_line(told: tuple[str, str], named: str) -> None:
    result = invoke("nc", "path", str(FINISH), "-d", "ge2000t", *told)
    assert (result.exit_code, result.stdout) == (ExitStatus.USAGE, "")
    assert f"Invalid value for {told[0]}: {named!r} is " in result.stderr
