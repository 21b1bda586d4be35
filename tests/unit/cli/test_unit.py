"""Every command that writes or measures lengths: nothing without the program's unit."""

import json
import shutil
from pathlib import Path

import pytest

from tests.support.cli import run

EXAMPLES = Path(__file__).parents[3] / "src/trueloop/examples"
MILLED = "%\nO1 (INCH)\nG0 G90 X1. Y1.\nZ.1\nG1 Z-.1 F10.\nX2.\nM30\n%\n"
TURNED = "%\nO1 (INCH)\nG0 X1. Z.1\nG1 Z-1. F.01\nX1.2\nX1.4 Z-2.\nG0 X2.\nM30\n%\n"


def _calls(folder: Path) -> dict[str, list[object]]:
    milled, turned, field = folder / "a.nc", folder / "b.nc", folder / "field.csv"
    milled.write_text(MILLED)
    turned.write_text(TURNED)
    field.write_text("x_mm,y_mm,dx_um,dy_um\n0,0,10,0\n0,60,10,0\n60,0,10,0\n60,60,10,0\n")
    mill = ["--dialect", "haas-mill"]
    return {
        "map": ["nc", "map", milled, "--shift", "0.01,0,0.01", "--out", folder / "out.nc", *mill],
        "path": ["nc", "path", milled, *mill],
        "diff": ["nc", "diff", milled, milled, *mill],
        "from-program": ["part", "from-program", turned, "--nose-radius-mm", 0.4, "--dialect", "fanuc-lathe"],
        "points": ["machine", "points", milled, "--table", field, "--out", folder / "out.nc", *mill],
    }


NAMES = ("map", "path", "diff", "from-program", "points")


@pytest.mark.parametrize("name", NAMES)
def test_a_command_refuses_a_program_without_a_unit_and_takes_the_one_it_is_given(tmp_path: Path, name: str) -> None:
    call = _calls(tmp_path)[name]
    message = run(*call, status=3)
    file = tmp_path / ("b.nc" if name == "from-program" else "a.nc")
    assert message.startswith(f"{file}:3:")
    assert "NC-UNIT" in message
    assert "--unit" in message.split("hint:")[1]
    assert not list(tmp_path.glob("out.*"))
    run(*call, "--unit", "inch")


@pytest.mark.parametrize("name", NAMES)
def test_a_command_refuses_a_unit_against_the_programs_own(tmp_path: Path, name: str) -> None:
    call = _calls(tmp_path)[name]
    for file in ("a.nc", "b.nc"):
        (tmp_path / file).write_text((tmp_path / file).read_text().replace("(INCH)", "G20"))
    message = run(*call, "--unit", "mm", status=3)
    assert "NC-UNIT" in message
    assert ":2:" in message.splitlines()[0]
    run(*call, "--unit", "inch")


def test_ten_micrometres_are_ten_in_inches_and_in_millimetres(tmp_path: Path) -> None:
    """10 µm are 0.01 mm and 0.000394 in; Haas has steps of 0.0001 in, and of 0.001 mm."""
    call = _calls(tmp_path)["map"]
    told = json.loads(run(*call, "--unit", "inch", "--json"))
    assert told["unit"] == {"unit": "inch", "stated_by": "--unit or programs.unit"}
    assert "X1.0004 Y1." in (tmp_path / "out.nc").read_text()
    run(*call, "--unit", "inch", "--decimals", 6)
    assert "X1.000394 Y1." in (tmp_path / "out.nc").read_text()
    run(*call, "--unit", "mm")
    assert "X1.010 Y1." in (tmp_path / "out.nc").read_text()
    (tmp_path / "a.nc").write_text(MILLED.replace("(INCH)", "G21"))
    told = json.loads(run(*call, "--json"))
    assert told["unit"] == {"unit": "mm", "stated_by": "the program, line 2"}


def test_nc_check_reports_and_does_not_refuse(tmp_path: Path) -> None:
    _calls(tmp_path)
    assert "warning NC-UNIT" in run("nc", "check", tmp_path / "a.nc", "--dialect", "haas-mill")
    assert "NC-UNIT" not in run("nc", "check", tmp_path / "a.nc", "--dialect", "haas-mill", "--unit", "inch")


def test_the_second_program_of_a_difference_may_have_another_unit(tmp_path: Path) -> None:
    _calls(tmp_path)
    (tmp_path / "mm.nc").write_text("G21\nG0 G90 X25.4 Y25.4\nZ2.54\nG1 Z-2.54 F10.\nX50.8\nM30\n")
    call = ["nc", "diff", tmp_path / "a.nc", tmp_path / "mm.nc", "--dialect", "haas-mill", "--json"]
    assert json.loads(run(*call, "--unit", "inch", "--other-unit", "mm"))["distance_mm"] < 1e-9


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """The NIST part, its programs without the block that states the unit."""
    folder = Path(shutil.copytree(EXAMPLES / "modbas2", tmp_path / "job"))
    for name in ("finish.nc", "semifinish.nc"):
        lines = (folder / name).read_text().splitlines(keepends=True)
        (folder / name).write_text("".join(line for line in lines if not line.startswith("N0220 G70")))
    return folder / "job.toml"


def test_a_jobs_programs_take_their_unit_from_it_and_the_record_holds_it(job: Path) -> None:
    for command in (["compensate", job], ["nc", "features", job]):
        message = run(*command, status=3)
        assert "NC-UNIT" in message
        assert "programs.unit" in message
    text = job.read_text()
    job.write_text(text.replace("[programs]\n", '[programs]\nunit = "inch"\n'))
    run("nc", "features", job)
    run("compensate", job, "--output", job.parent / "given")
    record = json.loads((job.parent / "given/record.json").read_text())
    assert record["options"]["unit"] == {"unit": "inch", "stated_by": "--unit or programs.unit"}
    run("compensate", EXAMPLES / "modbas2/job.toml", "--output", job.parent / "stated")
    record = json.loads((job.parent / "stated/record.json").read_text())
    assert record["options"]["unit"] == {"unit": "inch", "stated_by": "the program, line 8"}
    table = "table.csv"
    assert (job.parent / "given" / table).read_bytes() == (job.parent / "stated" / table).read_bytes()


def test_a_jobs_unit_against_its_programs_is_refused(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(EXAMPLES / "modbas2", tmp_path / "job"))
    text = (folder / "job.toml").read_text()
    (folder / "job.toml").write_text(text.replace("[programs]\n", '[programs]\nunit = "mm"\n'))
    assert "NC-UNIT" in run("compensate", folder / "job.toml", status=3)


def test_the_linuxcnc_loop_does_not_run_in_mm_what_is_meant_in_inches(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(EXAMPLES, tmp_path / "examples"))
    program, job = folder / "linuxcnc/finish.ngc", folder / "loop/modbas2.toml"
    program.write_text(program.read_text().replace("G18 G20 G7", "G18 G7"))
    job.write_text(job.read_text().replace("[programs]\n", '[programs]\nunit = "inch"\n'))
    message = run("linuxcnc", "loop", job, status=3)
    assert "NC-UNIT" in message
    assert "LinuxCNC starts in mm" in message
