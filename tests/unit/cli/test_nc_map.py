"""`trueloop nc map` as a user meets it: slips of the command line and of names."""

from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.cli.failure import ExitStatus


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
