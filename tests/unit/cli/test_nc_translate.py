"""`trueloop nc translate` as a user meets it: written whole or not at all, never over its input."""

import json
from pathlib import Path

from tests.support.cli import invoke
from trueloop.cli.failure import ExitStatus

SIMPLE = "G21 G18 G90\nG0 X10 Z2\nG1 Z-5 F100\nM2\n"
LOSSY = "G21 G18 G90\nG0 X10 Z2\nG10 L2 P1 X5\nG1 Z-5 F100\nM2\n"


def run(folder: Path, text: str, *options: str, out: str = "out.nc") -> tuple[int, str, str]:
    (folder / "part.ngc").write_text(text)
    command = ["nc", "translate", str(folder / "part.ngc"), "--dialect", "linuxcnc", "-o", str(folder / out), *options]
    done = invoke(*command)
    return done.exit_code, done.stdout, done.stderr


def test_a_program_is_written(tmp_path: Path) -> None:
    status, told, _ = run(tmp_path, SIMPLE, "--to", "fanuc-lathe")
    assert status == 0 and "rounded by 0.000000 mm" in told
    assert "G00 X20.0 Z2.0\nG01 Z-5.0 F100.0\nM02" in (tmp_path / "out.nc").read_text()


def test_a_loss_that_moves_the_machine_is_refused_unless_accepted(tmp_path: Path) -> None:
    status, _, told = run(tmp_path, LOSSY, "--to", "siemens")
    assert status == ExitStatus.REFUSED and "part.ngc:3:1: error NC-LOST" in told and "--accept-losses" in told
    assert not (tmp_path / "out.nc").exists()
    status, told, _ = run(tmp_path, LOSSY, "--to", "siemens", "--accept-losses", "--json")
    assert status == 0 and json.loads(told)["losses"][0]["code"] == "NC-LOST"
    assert (tmp_path / "out.nc").exists()


def test_the_input_is_never_overwritten_and_dialects_are_known(tmp_path: Path) -> None:
    assert "OUT-INPUT" in run(tmp_path, SIMPLE, "--to", "siemens", out="part.ngc")[2]
    assert (tmp_path / "part.ngc").read_text() == SIMPLE
    assert "NC-DIALECT" in run(tmp_path, SIMPLE, "--to", "simens")[2]
