"""Earlier parts out of the store in a correction: whose they are, which count, and what the user sees of it."""

import json
import shutil
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.correction import EXAMPLES
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import Store, find, keep, open_store

TOOL = 'name = "SVJBL"\ninsert = "VCMT 110304"\ncorner = "1"\n'
EDGE = Edge(Tool(1, "SVJBL"), "VCMT 110304", "1")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """MODBAS2's job with a stated edge, beside an empty store."""
    for file in (EXAMPLES / "modbas2").iterdir():
        shutil.copy(file, tmp_path)
    job = tmp_path / "job.toml"
    text = job.read_text(encoding="utf-8").replace("[tool]\n", f"[tool]\n{TOOL}")
    job.write_text(text.replace("../../out/modbas2", "out"), encoding="utf-8")
    open_store(tmp_path / "trueloop.db", create=True)
    return tmp_path


def corrected(folder: Path, serial: str, *more: str) -> dict[str, object]:
    """What `compensate --json` says of a part."""
    probed(folder, serial)
    said = invoke("compensate", folder / "job.toml", "--serial", serial, "--json", *more, status=0)
    found: dict[str, object] = json.loads(said.stdout)
    return found


def finished(folder: Path, serial: str, hour: int) -> None:
    """The part's finish cut by its correction, and an inspection that finds 2 µm left on everywhere."""
    store: Store = open_store(folder / "trueloop.db", codec=store_codec())
    touched = [one.value for one in find(store, Inspection, serial=serial)][-1]
    record = next(one.value for one in find(store, Correction) if one.value.record.inspections[0].part.serial == serial)
    at = datetime(2026, 3, 1, hour, tzinfo=UTC)
    cut = Cut(touched.part, Stage.FINISH, Setting(EDGE), correction=record.record.id, at=at, order=hour)
    values = tuple(replace(one, error_mm=0.002, measured_mm=None, line=None) for one in touched.touches)
    seen = replace(
        touched, sha256=f"finish {serial}", values=values, measured_at=at + timedelta(minutes=20), z_reference=None
    )
    keep(store, [cut, seen, InspectionLink(seen.identity, cut.identity)])


def probed(folder: Path, serial: str) -> None:
    """The touches as those of this part: another file than that of the part before."""
    _, _, rows = (folder / "touches.csv").read_text(encoding="utf-8").partition("\n")
    (folder / "touches.csv").write_text(f"# {serial}\n{rows}", encoding="utf-8")


def few_touches(folder: Path) -> None:
    """Three of the dome's touches, and those of lines."""
    lines = (folder / "touches.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    dome = [line for line in lines if ",dome," in line]
    kept = [line for line in lines if line not in dome] + [dome[2], dome[9], dome[16]]
    (folder / "touches.csv").write_text("".join(kept), encoding="utf-8")


def test_the_first_part_is_corrected_as_without_a_store_and_said_to_be_the_first(folder: Path) -> None:
    invoke("compensate", folder / "job.toml", "--serial", "S1", "--no-store", "-o", folder / "without", status=0)
    said = invoke("compensate", folder / "job.toml", "--serial", "S1", status=0)
    assert "Nothing to learn from earlier parts of this edge yet: corrected by the fit of its own touches." in " ".join(
        said.stdout.split()
    )
    for name in ("corrected.nc", "offsets.nc", "table.csv"):
        assert (folder / "out" / name).read_bytes() == (folder / "without" / name).read_bytes()


def test_the_second_part_is_corrected_by_the_first_and_three_touches(folder: Path) -> None:
    first = corrected(folder, "S1")
    finished(folder, "S1", 9)
    few_touches(folder)
    probed(folder, "S2")
    said = invoke("compensate", folder / "job.toml", "--serial", "S2", status=0)
    text = " ".join(said.stdout.split())
    assert "Memory of edge SVJBL VCMT 110304 1, inspected parts: 1." in text
    assert "from 14 touches" in text
    second, off = corrected(folder, "S2"), corrected(folder, "S2", "--memory", "off", "-o", str(folder / "off"))
    assert second["record_id"] not in (first["record_id"], off["record_id"])
    options = second["options"]
    assert isinstance(options, dict) and "history_sha256" in options["memory"]


def test_a_part_made_again_after_later_ones_gets_what_was_known_then(folder: Path) -> None:
    first = corrected(folder, "S1")
    finished(folder, "S1", 9)
    second = corrected(folder, "S2")
    finished(folder, "S2", 11)
    assert corrected(folder, "S1")["record_id"] == first["record_id"]
    assert corrected(folder, "S2")["record_id"] == second["record_id"]
    assert corrected(folder, "S3")["record_id"] != second["record_id"]


def test_without_an_edge_nothing_is_remembered(folder: Path) -> None:
    corrected(folder, "S1")
    finished(folder, "S1", 9)
    job = folder / "job.toml"
    job.write_text(job.read_text(encoding="utf-8").replace(TOOL, ""), encoding="utf-8")
    notes = corrected(folder, "S2")["notes"]
    assert isinstance(notes, list) and not any("Memory of edge" in note for note in notes)
