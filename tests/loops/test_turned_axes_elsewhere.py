"""Rotary axes where a program of points or a turned part is corrected: refused as by `nc map`."""

import shutil
from pathlib import Path

import pytest

from tests.support.cli import run

EXAMPLES = Path(__file__).parents[2] / "src/trueloop/examples"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("G21 G90\nG0 A0. X10. Y10.\nA90.\nX20. Y20.\n", 4),
        ("G21 G90\nG0 X10. Y10.\nA0.\nX20. Y20.\n", 2),
        ("G21 G90\nG0 B[#1] X10. Y10.\n", 2),
    ],
)
def test_points_of_a_turned_part_are_refused(tmp_path: Path, text: str, line: int) -> None:
    file, out = tmp_path / "a.nc", tmp_path / "b.nc"
    call = ["machine", "points", file, "--quadrupole", "32e-6,-38.3", "--out", out, "--dialect", "fanuc-mill"]
    file.write_text(text)
    message = run(*call, status=3)
    assert message.startswith(f"{file}:{line}:")
    assert "0 degrees" in message
    assert not out.exists()
    file.write_text("G21 G90\nG0 A0. X10. Y10.\nG65 P9 A90. B2. X5. Y5.\nX20. Y20.\n")
    run(*call)
    assert "G65 P9 A90. B2. X5. Y5." in out.read_text()


def test_a_finish_pass_with_c_turned_is_refused(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(EXAMPLES, tmp_path / "examples"))
    program, job = folder / "linuxcnc/finish.ngc", folder / "linuxcnc/job.toml"
    source = program.read_text()
    program.write_text(source.replace("G18 G20 G7", "G18 G20 G7 G0 C90\nG18 G20 G7"))
    message = run("compensate", job, "--output", tmp_path / "out", status=3)
    assert "C does not stand at 0 degrees" in message
    assert not (tmp_path / "out").exists()
    program.write_text(source.replace("G18 G20 G7", "G18 G20 G7 G0 C0\nG18 G20 G7"))
    run("compensate", job, "--output", tmp_path / "out")
    assert "G0 C0" in (tmp_path / "out/corrected.ngc").read_text()
