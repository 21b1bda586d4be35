"""What a job states of part, tool, machine and gauge: empty where it says nothing, else in inputs and record."""

import tomllib
from datetime import UTC, datetime
from pathlib import Path
from shutil import copytree

import pytest

from tests.support.correction import EXAMPLES
from trueloop.domain.part import PartType
from trueloop.domain.tool import Edge, Machine, Tool
from trueloop.errors import Code, TrueloopError
from trueloop.formats.record_file import read_record
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.record import as_dict, words

STATED = {
    "part": 'revision = "C"\nmaterial = "6061-T6"\ndrawing = "D-4711"\nserial = "S-0815"\n',
    "tool": 'name = "SVJBR"\ninsert = "VBMT 1604"\ncorner = "2"\nset_at = 2026-01-30T07:00:00Z\n',
    "programs": 'machine = "Lathe 7"\nmachine_serial = "M-99"\n',
    "gauging": 'device = "probe 12"\noperator = "K. Meier"\n',
}


def job_stating(folder: Path, stated: dict[str, str], more: str = "") -> Path:
    """MODBAS2's job with keys more at the beginning of its tables."""
    copytree(EXAMPLES / "modbas2", folder, dirs_exist_ok=True)
    job = folder / "job.toml"
    text = job.read_text(encoding="utf-8")
    for table, keys in stated.items():
        assert f"[{table}]\n" in text
        text = text.replace(f"[{table}]\n", f"[{table}]\n{keys}")
    job.write_text(text + more, encoding="utf-8")
    tomllib.loads(job.read_text(encoding="utf-8"))
    return job


def test_what_a_job_states_is_in_the_record(tmp_path: Path) -> None:
    record = compensate(read_job(job_stating(tmp_path, STATED)).inputs).record
    assert record.part_type == PartType("MODBAS2, 3.52 in", "C", "6061-T6", "D-4711")
    tool = Tool(1, "SVJBR", corner_radius_mm=0.79375)
    assert (record.tool, record.edge) == (tool, Edge(tool, "VBMT 1604", "2"))
    assert record.edge_set_at == datetime(2026, 1, 30, 7, tzinfo=UTC)
    assert record.machine == Machine("Lathe 7", "M-99")
    (inspection,) = record.inspections
    assert (inspection.part.serial, inspection.device, inspection.operator) == ("S-0815", "probe 12", "K. Meier")
    (tmp_path / "record.json").write_text(record.to_json(), encoding="utf-8")
    read = read_record(tmp_path / "record.json")
    assert (read.part_type, read.machine, read.tool, read.edge) == (
        record.part_type, record.machine, record.tool, record.edge,
    )  # fmt: skip
    assert (read.edge_set_at, read.inspections) == (record.edge_set_at, record.inspections)
    said = "\n".join(line for _, lines in words(record) for line in lines)
    for value in ("C, drawing D-4711, material 6061-T6", "SVJBR, number 1", "insert VBMT 1604, corner 2", "K. Meier"):
        assert value in said
    assert as_dict(record)["edge_set_at"] == record.edge_set_at.isoformat()


def test_nothing_stated_is_nothing_invented() -> None:
    record = compensate(read_job(EXAMPLES / "modbas2" / "job.toml").inputs).record
    assert record.part_type == PartType("MODBAS2, 3.52 in")
    assert (record.edge, record.edge_set_at, record.machine) == (None, None, None)
    assert record.tool is not None and record.tool.name == ""
    (inspection,) = record.inspections
    assert (inspection.part.serial, inspection.device, inspection.operator) == ("", "", "")


def test_a_machine_is_stated_once(tmp_path: Path) -> None:
    machine = (
        '\n[machine]\nmodel = "m.json"\nwork_zero_mm = [0.0, 0.0, 0.0]\ntool_mm = [0.0, 0.0, 0.0]\n'
        'semifinish_cut = "compensated"\ntouched_on = "cmm"\n'
    )
    with pytest.raises(TrueloopError, match=r"programs\.machine") as refused:
        read_job(job_stating(tmp_path, {"programs": 'machine = "Lathe 7"\n'}, machine))
    assert refused.value.code is Code.JOB_KEY
