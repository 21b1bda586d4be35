"""`trueloop realtime hal` with an image, a serial number and a job: refused where they cannot belong together."""

from pathlib import Path

import pytest

from tests.loops.test_realtime_image import MACHINE, WIDE, job, job_on_machine, model
from tests.support import erring_lathe
from tests.support.cli import run
from trueloop_lab.linuxcnc.realtime.session import with_entries
from trueloop_lab.linuxcnc.session import source

__all__ = ["job", "job_on_machine", "model"]  # fixtures

NOSE_MM = 2 * 0.79375
"""Diameter, as LinuxCNC's tool table counts the nose."""


@pytest.fixture
def ini(tmp_path: Path) -> Path:
    """A lathe in mm whose limits are 1 mm inside the model's travel; T1 stands where the job has it."""
    folder = tmp_path / "config"
    folder.mkdir()
    ends = {"0": erring_lathe.X_TRAVEL, "1": (-300.0, 0.0)}
    entries = [
        (f"JOINT_{joint}", key, f"{end}")
        for joint, (low, high) in ends.items()
        for key, end in (("MIN_LIMIT", low + 1.0), ("MAX_LIMIT", high - 1.0))
    ]
    (folder / "machine.ini").write_text(with_entries(source("machine.ini"), entries))
    (folder / "machine.hal").write_text(source("machine.hal"))
    (folder / "extra.hal").write_text("")
    (folder / "tool.tbl").write_text(f"T1 P1 X30 Z-45 D{NOSE_MM}\n")
    return folder / "machine.ini"


@pytest.fixture
def image(job_on_machine: Path, tmp_path: Path) -> Path:
    out = tmp_path / "both.img"
    run("realtime", "image", job_on_machine, "-o", out, *WIDE, "--travel", "Z=-300,0")
    return out


def test_what_belongs_together_is_wired(ini: Path, image: Path, job_on_machine: Path) -> None:
    """T1 leads from the image's tool point 0 to that of the job, (−30, 0, 45) mm: LinuxCNC subtracts its offset."""
    said = run("realtime", "hal", ini, "--image", image, "--job", job_on_machine, "--serial", "7")
    assert "serial=7" in said and "is compared" not in said and "not compared" not in said
    alone = run("realtime", "hal", ini, "--image", image)
    assert "for serial number 7: with --serial it is compared" in alone
    assert "table is for finish.ngc: with --job program and tool are compared" in alone


@pytest.mark.parametrize(
    ("tool", "reason"),
    [
        ("T1 P1 X-30 Z45", "it has to be X 30 and Z -45 mm"),
        ("T1 P1 X30.2 Z-45", "the offset of T1 is X 30.2 mm (radius), Z -45 mm"),
        ("T1 P1 X60 Z-45", "X 60 mm (radius)"),
        ("T2 P2 X30 Z-45", "OFS-TOOL"),
        ("T1 P1 X30 Z-45 D0.8", "the nose radius of tool 1 is 0.4000 mm in the table and 0.7937 mm in the job"),
    ],
)
def test_another_tool_than_the_job_s_is_refused(
    ini: Path, image: Path, job_on_machine: Path, tool: str, reason: str
) -> None:
    (ini.parent / "tool.tbl").write_text(tool + "\n")
    said = run("realtime", "hal", ini, "--image", image, "--job", job_on_machine, status=3)
    assert reason in said and "tool.tbl:1" in said.replace("tool.tbl: ", "tool.tbl:1")


def test_wear_within_the_gate_is_the_same_tool(ini: Path, image: Path, job_on_machine: Path) -> None:
    (ini.parent / "tool.tbl").write_text("T1 P1 X30.09 Z-45.09\n")
    run("realtime", "hal", ini, "--image", image, "--job", job_on_machine)


def test_another_serial_program_or_model_is_refused(ini: Path, image: Path, job_on_machine: Path) -> None:
    arguments = ("realtime", "hal", ini, "--image", image)
    assert "it is for the machine '7', not '8'" in run(*arguments, "--serial", "8", status=3)
    text = job_on_machine.read_text()
    job_on_machine.write_text(text.replace(MACHINE, "").replace("[programs]", '[programs]\nmachine_serial = "9"'))
    assert "it is for the machine '7', not '9'" in run(*arguments, "--job", job_on_machine, status=3)
    job_on_machine.write_text(text)
    finish = job_on_machine.parent / "finish.ngc"
    given = finish.read_bytes()
    finish.write_bytes(given + b"\n")
    assert "its table is for 'finish.ngc'" in run(*arguments, "--job", job_on_machine, status=3)
    finish.write_bytes(given)
    model = job_on_machine.parent / "model.json"
    model.write_text(model.read_text() + "\n")
    said = run(*arguments, "--job", job_on_machine, status=3)
    assert "the job's model model.json has sha256" in said and "RTC-HAL" in said


def test_there_is_nothing_to_compare_without_an_image(ini: Path) -> None:
    assert "give --image too" in run("realtime", "hal", ini, "--serial", "7", status=2)
