"""`trueloop realtime image` and `show`: of a model, of jobs and of kept corrections."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support import erring_lathe, image_reference
from tests.support.cli import invoke, run
from tests.support.correction import EXAMPLES
from trueloop.domain.record import sha256_of
from trueloop.formats.realtime.image_file import read_image
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.model_file import model_to_json
from trueloop.jobs.realtime.image import Placing, table_of_job

PLACED = ("--origin", "100,-300")
TRAVEL = ("--travel", "X=0,300", "--travel", "Z=-800,100")
WIDE = ("--limit-um", "400")
MACHINE = """
[machine]
model = "model.json"
work_zero_mm = [70.0, 0.0, -60.0]
tool_mm = [-30.0, 0.0, 45.0]
cutting = { T1 = 28.0 }
touched_on = "cmm"
semifinish_cut = "compensated"
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A lathe that errs by some 0.2 mm."""
    path = tmp_path / "model.json"
    path.write_text(model_to_json(erring_lathe.model()))
    return path


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """The example for LinuxCNC, its results beside it."""
    for name in ("linuxcnc", "modbas2"):
        shutil.copytree(EXAMPLES / name, tmp_path / name)
    job = tmp_path / "linuxcnc" / "job.toml"
    job.write_text(job.read_text().replace("../../out/linuxcnc", "out"))
    return job


@pytest.fixture
def job_on_machine(job: Path, model: Path) -> Path:
    """The same job, its part on the lathe that errs."""
    shutil.copy(model, job.parent)
    job.write_text(job.read_text() + MACHINE)
    return job


def test_an_image_of_a_model(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "lathe.img"
    said = run(
        *("realtime", "image", model, "-o", out, *WIDE, "--gate-um", "70"),
        *("--tool", "1,2,-3", "--range", "T1=10,25", "--step", "T1=1"),
    )
    read = read_image(out, serial="7")
    assert read.identity.model_sha256 == sha256_of(model.read_bytes())
    assert (read.identity.machine, read.identity.program, read.blocks) == ("erring lathe", "", ())
    assert read.limits.travel_mm == (erring_lathe.X_TRAVEL, (-1.0, 1.0), erring_lathe.Z_TRAVEL)
    assert (read.limits.limit_mm, read.limits.gate_mm) == pytest.approx((0.4, 0.07))
    assert read.bank is not None and read.bank.tool_mm == (1.0, 2.0, -3.0)
    assert [(s.low, s.high, s.most_step) for s in read.bank.signals] == [(10.0, 25.0, 1.0)]
    assert "rtec.signal-0: T1, 10 to 25, at most 1 between two readings" in said
    assert f"{out.stat().st_size} bytes, sha256 {sha256_of(out.read_bytes())}" in said
    assert run("realtime", "show", out) == said


def test_a_range_beyond_the_data_is_said(model: Path, tmp_path: Path) -> None:
    told = invoke("realtime", "image", model, "-o", tmp_path / "a.img", *WIDE, "--range", "T1=10,25", status=0)
    assert "T1 may go from 10 to 25; the model was found from 15 to 30" in told.stderr
    told = invoke("realtime", "image", model, "-o", tmp_path / "a.img", *WIDE, "--range", "T1=16,25", status=0)
    assert told.stderr == ""


def test_more_than_the_limit_is_refused_and_nothing_written(model: Path, tmp_path: Path) -> None:
    said = run("realtime", "image", model, "-o", tmp_path / "lathe.img", "--limit-um", "20", status=3)
    assert "RTC-LIMIT" in said and "--limit-um" in said
    assert not (tmp_path / "lathe.img").exists()


def test_an_image_of_a_job_bears_the_id_of_its_corrected_program(job: Path, tmp_path: Path) -> None:
    """The given program is run with it: its hash is the image's."""
    invoke("compensate", job, status=0)
    out, program = tmp_path / "part.img", job.parent / "finish.ngc"
    found = json.loads(run("realtime", "image", job, "-o", out, *PLACED, *TRAVEL, *WIDE, "--serial", "9", "--json"))
    read = read_image(out, serial="9", program=program.read_bytes())
    assert read.bank is None
    assert read.blocks == table_of_job(job, Placing((100.0, -300.0))).blocks
    assert read.identity.record == read_record(job.parent / "out" / "record.json").id == found["record"]
    assert (read.identity.program, found["program_sha256"]) == ("finish.ngc", sha256_of(program.read_bytes()))
    assert found["rows"] == sum(len(block.rows) for block in read.blocks)
    corrected = job.parent / "out" / "corrected.ngc"
    assert "RTC-IMAGE" in run("realtime", "show", out, "--program", corrected, status=3)
    assert "must not be run with this image" in run("realtime", "show", out, "--program", program)


def test_a_corrected_program_gets_no_image(job: Path, tmp_path: Path) -> None:
    invoke("compensate", job, status=0)
    job.write_text(job.read_text().replace('finish = "finish.ngc"', 'finish = "out/corrected.ngc"'))
    said = run("realtime", "image", job, "-o", tmp_path / "part.img", *PLACED, *TRAVEL, *WIDE, status=3)
    assert "CMP-TWICE" in said
    assert not (tmp_path / "part.img").exists()


def test_of_a_job_on_a_machine_the_model_is_the_machine_s_and_the_table_the_process_s(
    job_on_machine: Path, tmp_path: Path
) -> None:
    out = tmp_path / "both.img"
    run("realtime", "image", job_on_machine, "-o", out, *WIDE, "--travel", "Z=-300,0")
    read, alone = read_image(out, serial="7"), table_of_job(job_on_machine, Placing())
    assert read.bank is not None and [signal.name for signal in read.bank.signals] == ["T1"]
    assert (
        read.identity.model_sha256
        == alone.model_sha256
        == sha256_of((job_on_machine.parent / "model.json").read_bytes())
    )
    assert read.blocks == alone.blocks
    found = image_reference.read(out.read_bytes())
    expected = erring_lathe.error_mm(np.array([80.0]), np.array([-120.0]), 23.0)[0]
    x, _, z = image_reference.error_mm(found, (80.0, 0.0, -120.0), (0.0,) * 3, (23.0,), (0.0,) * 3)
    assert (x, z) == pytest.approx(tuple(expected), abs=1e-12)


def test_the_model_must_be_the_one_that_the_job_counts_on(job_on_machine: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text((tmp_path / "model.json").read_text() + "\n")
    said = run("realtime", "image", job_on_machine, "-o", tmp_path / "both.img", *WIDE, "--model", other, status=3)
    assert "RTC-TABLE" in said and "--model" in said


def test_a_kept_correction_makes_the_same_image(job: Path, tmp_path: Path) -> None:
    """By record.json, and by the id alone."""
    store, files = job.parent / "trueloop.db", [tmp_path / f"{k}.img" for k in range(3)]
    invoke("db", "init", store, status=0)
    invoke("compensate", job, "--serial", "1", status=0)
    record = job.parent / "out" / "record.json"
    sources = [(job, "--no-store"), (record, "--db", store), (read_record(record).id, "--db", store)]
    for file, source in zip(files, sources, strict=True):
        run("realtime", "image", *source, "-o", file, *PLACED, *TRAVEL, *WIDE)
    assert len({file.read_bytes() for file in files}) == 1


def test_a_model_beside_a_job_without_one_is_commented(job: Path, model: Path, tmp_path: Path) -> None:
    told = invoke(
        *("realtime", "image", job, "-o", tmp_path / "both.img", *PLACED, *TRAVEL, *WIDE, "--model", model), status=0
    )
    assert "would be taken out twice" in told.stderr
