"""What `compensate` keeps in a store: once, whole, and never of a part that it does not know."""

import json
import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.correction import EXAMPLES
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, ProgramText
from trueloop.domain.tool import Edge, Tool
from trueloop.jobs.store.history import history_of
from trueloop.jobs.store.opened import store_of
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.storage.store import Store, find, open_store

TOOL = 'name = "PCLNL"\ninsert = "CNMG"\ncorner = "2"\n'


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """A job in a folder of its own."""
    for file in (EXAMPLES / "piecs11").iterdir():
        shutil.copy(file, tmp_path)
    job = tmp_path / "job.toml"
    text = job.read_text(encoding="utf-8").replace("[tool]\n", f"[tool]\n{TOOL}")
    job.write_text(text.replace("../../out/piecs11", "out"), encoding="utf-8")
    yield tmp_path


def opened(folder: Path) -> Store:
    store = store_of(folder, None, None)
    assert store is not None
    return store


def rows(folder: Path) -> dict[str, int]:
    """Rows by table, as SQLite itself counts them."""
    with sqlite3.connect(folder / "trueloop.db") as database:
        names = [name for (name,) in database.execute("select name from sqlite_master where type = 'table'")]
        return {name: database.execute(f'select count(*) from "{name}"').fetchone()[0] for name in names}


def test_what_a_correction_was_made_of_is_kept(folder: Path) -> None:
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    new = f"kept in the new store {folder / 'trueloop.db'}: 1 part, 1 inspection, 1 cut, 1 correction, 4 programs"
    assert new in said.stdout
    store = opened(folder)
    (correction,) = (kept.value for kept in find(store, Correction))
    made = compensate(read_job(folder / "job.toml", serial="3511.158").inputs)
    assert correction.record.id == made.record.id
    assert correction.payload.corrected_program == made.corrected_program
    (cut,) = (kept.value for kept in find(store, Cut))
    assert cut.stage is Stage.SEMIFINISH and cut.part.serial == "3511.158"
    assert cut.setting is not None
    assert cut.setting.edge == Edge(Tool(1, "PCLNL", corner_radius_mm=0.79375), "CNMG", "2")
    (link,) = (kept.value for kept in find(store, InspectionLink))
    (touches,) = (kept.value for kept in find(store, Inspection))
    assert link.cut == cut.identity and link.inspection == touches.identity and touches.count == 26
    texts = {kept.value.sha256: kept.value.content for kept in find(store, ProgramText)}
    assert texts[cut.program_sha256] == (folder / "semifinish.nc").read_bytes()
    assert (folder / "finish.nc").read_bytes() in texts.values()
    assert (folder / "out" / "corrected.nc").read_bytes() in texts.values()
    assert history_of(store, Edge(Tool(1, "PCLNL"), "CNMG", "2")) == ()  # no finish cut yet


def test_the_same_job_twice_has_no_second_row(folder: Path) -> None:
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    before = rows(folder)
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    assert "all of it is kept already" in said.stdout
    assert rows(folder) == before


def test_the_same_touches_as_another_part_are_refused_and_nothing_is_written(folder: Path) -> None:
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    before = rows(folder)
    said = invoke("compensate", folder / "job.toml", "--serial", "3611.154", "-o", folder / "other", status=3)
    assert "STO-OTHER-PART" in said.stderr and "'3511.158'" in said.stderr
    assert rows(folder) == before and not (folder / "other").exists()


def test_a_part_without_serial_number_is_kept_nowhere_and_a_named_store_refuses_it(folder: Path) -> None:
    open_store(folder / "named.db", create=True)
    said = invoke("compensate", folder / "job.toml", "--db", folder / "named.db", status=3)
    assert "STO-PART" in said.stderr and not (folder / "out").exists()
    former = invoke("compensate", folder / "job.toml", "--db", "none", status=2)
    assert "--no-store" in former.stderr and not (folder / "out").exists()
    without = invoke("compensate", folder / "job.toml", status=0)
    assert "kept in no store: the part has no serial number" in without.stdout
    assert (folder / "out" / "corrected.nc").exists() and not (folder / "trueloop.db").exists()
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    assert "kept in no store" in invoke("compensate", folder / "job.toml", status=0).stdout  # and refused neither
    assert len(find(opened(folder), Part)) == 1


def test_no_store_is_made_where_none_is_wanted_or_the_correction_is_refused(folder: Path) -> None:
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", "--no-store", status=0)
    assert "kept in" not in said.stdout
    job = folder / "job.toml"
    job.write_text(job.read_text(encoding="utf-8") + "[compensation]\nmax_correction_um = 1.0\n", encoding="utf-8")
    invoke("compensate", job, "--serial", "3511.158", status=3)
    assert not (folder / "trueloop.db").exists()


def test_a_store_that_cannot_be_made_is_named_before_anything_is_written(folder: Path) -> None:
    (folder / "trueloop.db").mkdir()
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=3)
    assert "STO-FILE" in said.stderr and "--db" in said.stderr and not (folder / "out").exists()
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", "--no-store", status=0)


def test_json_says_what_was_kept(folder: Path) -> None:
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", "--json", status=0)
    store = json.loads(said.stdout)["store"]
    assert store["new"]["ProgramText"] == 4 and store["new"]["Correction"] == 1 and store["findings"] == []


def test_an_edge_that_is_not_stated_is_warned_of(folder: Path) -> None:
    job = folder / "job.toml"
    job.write_text(job.read_text(encoding="utf-8").replace(TOOL, ""), encoding="utf-8")
    said = invoke("compensate", job, "--serial", "3511.158", status=0)
    assert "STO-EDGE" in said.stderr


def test_what_cannot_be_written_is_kept_and_says_so(folder: Path) -> None:
    """The store knows of every program that may have been run: it is asked first."""
    (folder / "out").write_text("a file in the place of the folder")
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=4)
    assert "OUT-FOLDER" in said.stderr and "kept in" in said.stderr and "keeps nothing twice" in said.stderr
    assert len(find(opened(folder), Correction)) == 1
    (folder / "out").unlink()
    again = invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    assert "all of it is kept already" in again.stdout and (folder / "out" / "corrected.nc").exists()


def test_touches_older_than_the_setting_of_the_edge_are_refused_unless_accepted(folder: Path) -> None:
    job = folder / "job.toml"
    text = job.read_text(encoding="utf-8").replace(TOOL, f"{TOOL}set_at = 2026-01-05T08:00:00Z\n")
    job.write_text(text.replace("[gauging]\n", "[gauging]\nmeasured_at = 2026-01-05T07:00:00Z\n"), encoding="utf-8")
    limits = "[compensation]\nmax_age_hours = 1e6\n"
    job.write_text(job.read_text(encoding="utf-8") + limits, encoding="utf-8")
    said = invoke("compensate", job, "--serial", "3511.158", status=3)
    assert "STO-CLOCK" in said.stderr and "2026-01-05T07:00" in said.stderr
    accepted = invoke("compensate", job, "--serial", "3511.158", "--accept", "STO-CLOCK", status=0)
    assert "warning STO-CLOCK" in accepted.stderr and len(find(opened(folder), Correction)) == 1


def test_another_weight_is_another_correction_of_the_same_part(folder: Path) -> None:
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    job = folder / "job.toml"
    job.write_text(job.read_text(encoding="utf-8") + "[compensation]\nweight = 0.5\n", encoding="utf-8")
    said = invoke("compensate", job, "--serial", "3511.158", status=0)
    assert "trueloop.db: 1 correction, 2 programs" in said.stdout
    assert len(find(opened(folder), Part)) == 1 and len(find(opened(folder), Inspection)) == 1


def test_another_content_under_the_same_identity_needs_to_be_said(folder: Path) -> None:
    """The semi-finish program is mended after the part was kept: the cut was another."""
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=0)
    program = folder / "semifinish.nc"
    program.write_bytes(program.read_bytes() + b"\n")
    said = invoke("compensate", folder / "job.toml", "--serial", "3511.158", status=3)
    assert "STO-DIFFERS" in said.stderr
    invoke("compensate", folder / "job.toml", "--serial", "3511.158", "--supersede", status=0)
    assert len(find(opened(folder), Cut)) == 1 and len(find(opened(folder), Cut, superseded=True)) == 2


def test_without_a_store_nothing_is_asked(tmp_path: Path) -> None:
    invoke("compensate", EXAMPLES / "piecs11" / "job.toml", "-o", tmp_path / "out", status=0)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["out"]


def test_a_surfaces_parts_and_correction_are_kept_once(tmp_path: Path) -> None:
    """The first three parts of the example, each by the name of its file."""
    for file in (EXAMPLES / "surface").iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path)
    shutil.copytree(EXAMPLES / "surface" / "parts", tmp_path / "parts")
    for file in sorted((tmp_path / "parts").iterdir())[3:]:
        file.unlink()
    open_store(tmp_path / "trueloop.db", create=True)
    job = tmp_path / "surface.toml"
    said = invoke("surface", "compensate", job, "-o", tmp_path / "out", status=0)
    assert "3 parts, 3 inspections, 3 cuts, 1 correction, 2 programs" in said.stdout
    store = opened(tmp_path)
    assert len(find(store, Cut, stage=Stage.FINISH)) == 3
    (correction,) = (kept.value for kept in find(store, Correction, product="surface"))
    written = (tmp_path / "out" / "corrected.ngc").read_bytes()
    assert correction.payload.program is not None and correction.payload.program.source == written
    before = rows(tmp_path)
    again = invoke("surface", "compensate", job, "-o", tmp_path / "out", status=0)
    assert "all of it is kept already" in again.stdout and rows(tmp_path) == before
