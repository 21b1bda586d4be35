"""The table of a job and of a stored correction: one correction, one id, applied in one of two ways, never both."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support import erring_lathe
from tests.support.cli import invoke
from tests.support.correction import EXAMPLES
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, TrueloopError
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.model_file import model_to_json
from trueloop.jobs.realtime.image import CorrectedProgram, Placing, table_of_job, table_of_record

ORIGIN = Placing((100.0, -300.0))


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """The example for LinuxCNC, its results beside it."""
    for name in ("linuxcnc", "modbas2"):
        shutil.copytree(EXAMPLES / name, tmp_path / name)
    job = tmp_path / "linuxcnc" / "job.toml"
    job.write_text(job.read_text().replace("../../out/linuxcnc", "out"))
    return job


def same(one: CorrectedProgram, other: CorrectedProgram) -> bool:
    return one.blocks == other.blocks and replace(one, blocks=(), files=()) == replace(other, blocks=(), files=())


def test_a_table_bears_the_id_of_the_corrected_program_and_the_hash_of_the_given_one(job: Path) -> None:
    invoke("compensate", job, status=0)
    folder, table = job.parent / "out", table_of_job(job, ORIGIN)
    corrected = (folder / "corrected.ngc").read_bytes()
    assert table.record == read_record(folder / "record.json").id
    assert f"record {table.record}".encode() in corrected
    assert table.program == "finish.ngc"
    assert table.program_sha256 == sha256_of((job.parent / "finish.ngc").read_bytes()) != sha256_of(corrected)
    assert table.limit_mm == 0.150 and not table.model_sha256


def test_nothing_is_written_for_a_table(job: Path) -> None:
    before = sorted(job.parent.rglob("*"))
    table = table_of_job(job, ORIGIN)
    assert sorted(job.parent.rglob("*")) == before
    assert job.parent / "finish.ngc" in table.files and job in table.files


def test_of_a_corrected_program_there_is_no_table_and_no_further_correction(job: Path) -> None:
    """Whoever makes an image for the corrected program, or corrects it again, is told what it is already."""
    invoke("compensate", job, status=0)
    job.write_text(job.read_text().replace('finish = "finish.ngc"', 'finish = "out/corrected.ngc"'))
    with pytest.raises(TrueloopError) as refused:
        table_of_job(job, ORIGIN)
    assert refused.value.code is Code.CMP_TWICE
    assert "CMP-TWICE" in invoke("compensate", job, status=3).output


def test_a_stored_correction_gives_the_same_table(job: Path) -> None:
    """Out of the store alone: program, part and touches may be gone."""
    store = job.parent / "trueloop.db"
    invoke("db", "init", store, status=0)
    invoke("compensate", job, "--serial", "1", status=0)
    kept = read_record(job.parent / "out" / "record.json").id
    by_job = table_of_job(job, ORIGIN)
    for file in (job, job.parent / "finish.ngc"):
        file.unlink()
    by_record = table_of_record(kept, ORIGIN, str(store))
    assert same(by_record, by_job) and by_record.files == (store,)
    with pytest.raises(TrueloopError) as refused:
        table_of_record("0123456789abcdef", ORIGIN, str(store))
    assert refused.value.code is Code.STO_UNKNOWN


def test_rows_are_in_machine_coordinates(job: Path) -> None:
    """The program's zero at x 100, z −300 mm: the dome's end is where the program has X0 Z0.03125 inch."""
    dome = next(block for block in table_of_job(job, ORIGIN).blocks if block.line == 23)
    assert dome.rows[-1, :2] == pytest.approx([100.0, -300.0 + 0.03125 * 25.4], abs=1e-9)
    moved = next(block for block in table_of_job(job, Placing((90.0, -310.0))).blocks if block.line == 23)
    assert moved.rows - dome.rows == pytest.approx(np.tile([-10.0, -10.0, 0.0, 0.0], (len(dome.rows), 1)), abs=1e-9)


def test_where_the_program_stands_must_be_said(job: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        table_of_job(job, Placing())
    assert refused.value.code is Code.RTC_TABLE and "work offset plus tool offset" in str(refused.value.hint)


MACHINE = """
[machine]
model = "model.json"
work_zero_mm = [70.0, 0.0, -60.0]
tool_mm = [-30.0, 0.0, 45.0]
cutting = { T1 = 28.0 }
touched_on = "cmm"
semifinish_cut = "compensated"
"""


def test_a_job_on_a_machine_says_where_its_program_stands(job: Path) -> None:
    """The axes stand at program + work zero − tool; the model that must act besides is named."""
    model = job.parent / "model.json"
    model.write_text(model_to_json(erring_lathe.model(), {}))
    job.write_text(job.read_text() + MACHINE)
    table = table_of_job(job, Placing())
    assert table.model_sha256 == sha256_of(model.read_bytes())
    assert (table.machine, table.serial) == ("erring lathe", "7")
    dome = next(block for block in table.blocks if block.line == 23)
    assert dome.rows[-1, :2] == pytest.approx([70.0 + 30.0, -60.0 - 45.0 + 0.03125 * 25.4], abs=1e-9)
    assert same(table, table_of_job(job, Placing((100.0, -105.0))))
    with pytest.raises(TrueloopError) as refused:
        table_of_job(job, Placing((100.0, -105.001)))
    assert refused.value.code is Code.RTC_TABLE and "the job says it" in str(refused.value.hint)
