"""`trueloop db`: what a person does with a store."""

import json
import shutil
from pathlib import Path

import pytest

from tests.support.cli import invoke, output_of
from tests.support.records import TURNED
from trueloop.cli.failure import ExitStatus

MODBAS2 = Path(__file__).parents[3] / "examples" / "modbas2"
JOB = MODBAS2 / "job.toml"


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A folder with an empty store, in which the commands run."""
    monkeypatch.chdir(tmp_path)
    invoke("db", "init", status=0)
    return tmp_path


def rows(what: str, *options: str) -> list[dict[str, str]]:
    found: list[dict[str, str]] = json.loads(invoke("db", "find", what, "--json", *options, status=0).stdout)["rows"]
    return found


def test_a_store_is_made_once(folder: Path) -> None:
    assert (folder / "trueloop.db").is_file()
    before = (folder / "trueloop.db").read_bytes()
    assert "STO-EXISTS" in output_of("db", "init", status=ExitStatus.REFUSED)
    assert "STO-EXISTS" in output_of("db", "init", folder, status=ExitStatus.REFUSED)
    assert (folder / "trueloop.db").read_bytes() == before


def test_without_a_store_nothing_is_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    for command in (("find", "part"), ("import", MODBAS2 / "touches.csv")):
        assert "STO-FILE" in output_of("db", *command, status=ExitStatus.REFUSED)
        assert "STO-FILE" in output_of("db", *command, "--db", "other.db", status=ExitStatus.REFUSED)
    assert not list(tmp_path.iterdir())


def test_touches_of_a_job_are_kept_once(folder: Path) -> None:
    given = ("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511")
    assert "1 of 1 new" in output_of(*given)
    assert "inspection:1 is there already, not kept again" in output_of(*given)
    (row,) = rows("inspection")
    assert (row["row"], row["serial"], row["values"]) == ("inspection:1", "2511", "32 touches")
    assert [one["row"] for one in rows("inspection", "--serial", "2511", "--since", "2026-01-01")] == ["inspection:1"]
    assert not rows("inspection", "--serial", "2512") and not rows("inspection", "--since", "2999-01-01")


def test_a_file_of_one_part_is_not_kept_as_another(folder: Path) -> None:
    given = ("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial")
    invoke(*given, "2511", status=0)
    assert "STO-OTHER-PART" in output_of(*given, "2512", status=ExitStatus.REFUSED)
    assert len(rows("inspection")) == 1


def test_a_part_that_is_not_stated_is_refused_and_one_in_a_label_is_taken(folder: Path) -> None:
    file = folder / "2511-AL-P1.139.csv"
    shutil.copy(MODBAS2 / "touches.csv", file)
    job = JOB.read_text(encoding="utf-8").replace('name = "MODBAS2, 3.52 in"', 'name = "2511"')
    (folder / "job.toml").write_text(job, encoding="utf-8")
    shutil.copy(file, folder / "touches.csv")
    for program in ("finish.nc", "semifinish.nc"):
        shutil.copy(MODBAS2 / program, folder)
    said = output_of("db", "import", "touches.csv", "--job", "job.toml", status=ExitStatus.REFUSED)
    assert "STO-PART" in said and "serial number" in said
    assert "LAB-LINK" in output_of(
        "db", "import", file, "--job", "job.toml", "--serial", "140", status=ExitStatus.REFUSED
    )
    assert not rows("inspection")
    invoke("db", "import", file, "--job", "job.toml", status=0)
    assert [(row["part_type"], row["serial"]) for row in rows("inspection")] == [("2511", "139")]


def test_a_label_may_be_ignored(folder: Path) -> None:
    file = folder / "2511-AL-P1.139.csv"
    shutil.copy(MODBAS2 / "touches.csv", file)
    invoke("db", "import", file, "--job", JOB, "--serial", "140", "--ignore-labels", status=0)
    assert [row["serial"] for row in rows("inspection")] == ["140"]


def test_several_files_are_kept_up_to_the_first_that_is_refused(folder: Path) -> None:
    (folder / "broken.csv").write_text("point,feature,nominal_x_mm,nominal_z_mm,error_um\n1,cone,a,b,c\n")
    given = ("--job", JOB, "--serial", "2511")
    refused = invoke("db", "import", MODBAS2 / "touches.csv", "broken.csv", *given, status=ExitStatus.REFUSED)
    assert "1 of 1 new" in refused.stdout and "broken.csv:2" in refused.stderr
    assert len(rows("inspection")) == 1


def test_a_record_is_kept_with_its_inspections(folder: Path) -> None:
    (folder / "record.json").write_text(TURNED.to_json(), encoding="utf-8")
    assert "2 of 2 new" in output_of("db", "import", "record.json")
    assert [row["record"] for row in rows("correction", "--serial", "17")] == [TURNED.id]
    assert [row["serial"] for row in rows("inspection", "--type", "shaft")] == ["17"]
    assert "0 of 2 new" in output_of("db", "import", "record.json")


def test_a_newer_record_and_a_missing_file_are_refused(folder: Path) -> None:
    newer = TURNED.to_json().replace('"schema": 1,\n  "product"', '"schema": 99,\n  "product"')
    (folder / "record.json").write_text(newer, encoding="utf-8")
    assert newer != TURNED.to_json()
    assert "REC-SCHEMA" in output_of("db", "import", "record.json", status=ExitStatus.REFUSED)
    assert "did you mean 'record.json'" in output_of("db", "import", "recor.json", status=ExitStatus.REFUSED)
    assert "STO-IMPORT" in output_of("db", "import", folder, status=ExitStatus.REFUSED)


def test_what_cannot_be_found_that_way_is_said(folder: Path) -> None:
    assert "none of part-type, part," in output_of("db", "find", "parts", status=ExitStatus.USAGE)
    assert "STO-UNKNOWN" in output_of("db", "find", "machine", "--serial", "7", status=ExitStatus.REFUSED)
    assert "0 rows" in output_of("db", "find", "part")
