"""`trueloop db`: what a person does with a store."""

import json
import shutil
import sqlite3
import struct
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pytest

from tests.support.cli import invoke, output_of
from tests.support.records import TURNED
from tests.support.stores import AT, cut, link, touched
from trueloop.cli.terminal import ExitStatus
from trueloop.domain.record import Program
from trueloop.domain.tool import Machine
from trueloop.factory.carry_out import carry_out
from trueloop.factory.requests import By, RecordTransfer, Role
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.keeping import Keeping
from trueloop.storage.store import keep, open_store

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
    assert "not one of part-type, part," in output_of("db", "find", "parts", status=ExitStatus.USAGE)
    assert "STO-UNKNOWN" in output_of("db", "find", "machine", "--serial", "7", status=ExitStatus.REFUSED)
    assert "0 rows" in output_of("db", "find", "part")


def test_an_export_makes_an_equal_store(folder: Path) -> None:
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    invoke("db", "export", "-o", "all.jsonl", status=0)
    invoke("db", "init", "other.db", status=0)
    assert "3 of 3 new" in output_of("db", "import", "all.jsonl", "--db", "other.db")
    assert "0 of 3 new" in output_of("db", "import", "all.jsonl", "--db", "other.db")
    invoke("db", "export", "-o", "again.jsonl", "--db", "other.db", status=0)
    assert (folder / "again.jsonl").read_bytes() == (folder / "all.jsonl").read_bytes()
    assert "OUT-INPUT" in output_of("db", "export", "-o", "trueloop.db", status=ExitStatus.OUTPUT)


def test_an_export_that_is_cut_off_is_refused_with_its_line(folder: Path) -> None:
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    invoke("db", "export", "-o", "all.jsonl", status=0)
    lines = (folder / "all.jsonl").read_text().splitlines(keepends=True)
    (folder / "cut.jsonl").write_text("".join(lines[:3]) + lines[3][:50])
    invoke("db", "init", "other.db", status=0)
    said = output_of("db", "import", "cut.jsonl", "--db", "other.db", status=ExitStatus.REFUSED)
    assert "cut.jsonl:4: STO-EXPORT" in said
    assert "0 rows" in output_of("db", "find", "part", "--db", "other.db")


def test_the_life_of_a_part(folder: Path) -> None:
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    for name in ("2511", "MODBAS2, 3.52 in/2511", "2511.139"):
        assert "inspected: 32 touches" in output_of("db", "show", name)
    shown = json.loads(output_of("db", "show", "2511", "--json"))
    assert shown["part"]["serial"] == "2511"
    assert [entry["row"] for entry in shown["entries"]] == ["inspection:1"]
    assert "STO-UNKNOWN" in output_of("db", "show", "2512", status=ExitStatus.REFUSED)


def test_a_correction_is_shown_by_the_id_of_its_record(folder: Path) -> None:
    (folder / "record.json").write_text(TURNED.to_json(), encoding="utf-8")
    invoke("db", "import", "record.json", status=0)
    shown = json.loads(output_of("db", "show", TURNED.id, "--json"))
    assert (shown["kind"], shown["value"]["record"]["id"]) == ("correction", TURNED.id)
    life = output_of("db", "show", "17")
    assert "for correction:1" in life and f"by record {TURNED.id}" in life


def test_a_wrong_row_is_replaced_and_both_stay(folder: Path) -> None:
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    wrong = output_of("db", "show", "inspection:1", "--json")
    (folder / "right.json").write_text(wrong.replace('"2511"', '"2512"'), encoding="utf-8")
    (folder / "same.json").write_text(wrong, encoding="utf-8")
    (folder / "part.json").write_text(output_of("db", "show", "part:1", "--json"), encoding="utf-8")
    (folder / "none.json").write_text("{", encoding="utf-8")
    given = ("--why", "the wrong tag was read", "--by", "ana")
    for file, code in (("same.json", "STO-IMPORT"), ("part.json", "VAL-FORM"), ("none.json", "STO-IMPORT")):
        assert code in output_of("db", "replace", "inspection:1", file, *given, status=ExitStatus.REFUSED)
    assert "STO-UNKNOWN" in output_of("db", "replace", "inspection:9", "right.json", *given, status=ExitStatus.REFUSED)
    said = output_of("db", "replace", "inspection:1", "right.json", *given)
    assert "kept: inspection:2 supersedes inspection:1" in said
    assert [row["serial"] for row in rows("inspection")] == ["2512"]
    assert [row["superseded_by"] for row in rows("inspection", "--superseded")] == ["inspection:2", ""]
    assert "superseded by inspection:2: ana, the wrong tag was read" in output_of("db", "show", "2511")
    assert "inspected: 32 touches" in output_of("db", "show", "2512")


def test_a_replaced_inspection_leaves_no_link_behind_unsaid(folder: Path) -> None:
    store = open_store("trueloop.db", codec=store_codec())
    inspection, made = touched(), cut()
    keep(store, [inspection, made, link(inspection, made)])
    assert "0 findings" in output_of("db", "check")
    shown = output_of("db", "show", "inspection:1", "--json")
    (folder / "right.json").write_text(shown.replace('"serial": "17"', '"serial": "18"'), encoding="utf-8")
    said = output_of("db", "replace", "inspection:1", "right.json", "--why", "other part")
    assert "inspection-link:1; replace it too" in said
    found = output_of("db", "check", status=ExitStatus.FINDINGS)
    assert "STO-LOST" in found and "inspection-link:1 names the inspection" in found


def test_a_check_finds_labels_times_and_orders_that_contradict(folder: Path) -> None:
    store = open_store("trueloop.db", codec=store_codec())
    program = Program("1411-C45-P1-S-M.nc", "fanuc-lathe", "2" * 64)
    first, second = replace(cut("17"), order=1), replace(cut("18"), order=2)
    early, late = (
        replace(touched(serial, sha256=serial), measured_at=AT + timedelta(hours=hours))
        for serial, hours in (("17", 5), ("18", -3))
    )
    keep(store, [program, first, second, early, late, link(early, first), link(late, second)])
    found = json.loads(output_of("db", "check", "--json", status=ExitStatus.FINDINGS))["findings"]
    assert sorted(one["code"] for one in found) == ["LAB-LINK", "LAB-LINK", "STO-CLOCK", "STO-ORDER"]
    assert {one["values"].get("in_link") for one in found if one["code"] == "LAB-LINK"} == {"finish"}


def _in_one_file() -> None:
    """What SQLite has in its log goes into the file."""
    connection = sqlite3.connect("trueloop.db")
    connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    connection.close()


def test_a_check_finds_a_number_that_was_changed_in_the_file(folder: Path) -> None:
    """A wrong digit of a measured value is no wrong row: only the hash tells it."""
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    assert "0 findings" in output_of("db", "check")
    connection = sqlite3.connect("trueloop.db")
    (error_mm,) = connection.execute("SELECT min(error_mm) FROM touch").fetchone()
    connection.close()
    _in_one_file()
    content, value = (folder / "trueloop.db").read_bytes(), struct.pack(">d", error_mm)
    assert content.count(value) == 1
    (folder / "trueloop.db").write_bytes(content.replace(value, struct.pack(">d", error_mm + 0.001)))
    (found,) = json.loads(output_of("db", "check", "--json", status=ExitStatus.FINDINGS))["findings"]
    assert (found["code"], found["severity"], found["values"]["row"]) == ("STO-DAMAGED", "error", "inspection:1")
    (folder / "trueloop.db").write_bytes(content)
    assert "0 findings" in output_of("db", "check")


def test_a_check_says_that_pages_of_the_file_are_damaged(folder: Path) -> None:
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    connection = sqlite3.connect("trueloop.db")
    (page,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'touch'").fetchone()
    (size,) = connection.execute("PRAGMA page_size").fetchone()
    connection.close()
    _in_one_file()
    with (folder / "trueloop.db").open("r+b") as file:
        file.seek((page - 1) * size)
        file.write(b"\xa5" * 100)
    found = json.loads(output_of("db", "check", "--json", status=ExitStatus.FINDINGS))
    assert {one["code"] for one in found["findings"]} == {"STO-DAMAGED"} and found["rows"] == 0
    assert {"the file", "the table 'inspection'"} <= {one["values"]["row"] for one in found["findings"]}


def test_a_check_finds_a_clock_that_went_back(folder: Path) -> None:
    store = open_store("trueloop.db", codec=store_codec())
    with store.writing() as connection:
        keeping = Keeping(store.codec, connection)
        keeping.keep(Machine("lathe"), kept_at=AT)
        keeping.keep(Machine("mill"), kept_at=AT - timedelta(seconds=1))
    said = output_of("db", "check", status=ExitStatus.FINDINGS)
    assert "STO-CLOCK" in said and "machine:2 was kept at" in said


def test_a_backup_is_restored_into_a_new_store_alone(folder: Path) -> None:
    invoke("db", "import", MODBAS2 / "touches.csv", "--job", JOB, "--serial", "2511", status=0)
    invoke("db", "export", "-o", "all.jsonl", status=0)
    invoke("db", "backup", "copy.db", status=0)
    for source, target in (("copy.db", "one.db"), ("all.jsonl", "two.db")):
        invoke("db", "restore", source, "--db", target, status=0)
        invoke("db", "export", "-o", "again.jsonl", "--db", target, status=0)
        assert (folder / "again.jsonl").read_bytes() == (folder / "all.jsonl").read_bytes()
    before = (folder / "one.db").read_bytes()
    for command in (("restore", "copy.db", "--db", "one.db"), ("backup", "one.db"), ("backup", ".")):
        assert "STO-EXISTS" in output_of("db", *command, status=ExitStatus.REFUSED)
    assert (folder / "one.db").read_bytes() == before
    assert "STO-FILE" in output_of("db", "restore", JOB, "--db", "three.db", status=ExitStatus.REFUSED)
    assert not list(folder.glob("three*")) and not list(folder.glob(".trueloop-*"))


def test_a_store_of_another_version_is_refused(folder: Path) -> None:
    with sqlite3.connect("trueloop.db") as connection:
        connection.execute("UPDATE trueloop_schema SET version_num = '9999'")
    connection.close()
    for command in (("find", "part"), ("check",), ("backup", "copy.db")):
        assert "STO-SCHEMA" in output_of("db", *command, status=ExitStatus.REFUSED)
    assert "STO-FILE" in output_of("db", "find", "part", "--db", "none-such.db", status=ExitStatus.REFUSED)
    assert not (folder / "none-such.db").exists()


def test_what_went_to_controls_is_found(folder: Path) -> None:
    sha = "ab" * 32
    store = open_store("trueloop.db", codec=store_codec())
    for control, outcome in (("lathe", "sent"), ("mill", "refused")):
        sent = RecordTransfer(control, sha, "O1.nc", "from", sha, sha if outcome == "sent" else "", outcome)
        carry_out(store, sent, By("otto", Role.OPERATOR), AT)
    store.close()
    first, second = rows("transfer")
    assert first["row"] == "transfer:1" and second["row"] == "transfer:2"
    said = ("control", "program", "direction", "outcome", "sent_sha256", "read_back_sha256", "by")
    assert [first[name] for name in said] == ["lathe", "O1.nc", "from", "sent", sha[:12], sha[:12], "otto"]
    assert [second[name] for name in said[3:6]] == ["refused", sha[:12], ""]
    assert rows("transfer", "--since", f"{AT + timedelta(days=1):%Y-%m-%d}") == []
    assert "STO-UNKNOWN" in output_of("db", "find", "transfer", "--serial", "7", status=ExitStatus.REFUSED)


def test_the_removed_command_leads_to_export_and_restore() -> None:
    told = invoke("db", "migrate", "--db", "shop.db", status=2).stderr
    assert "`trueloop db export`" in told and "`trueloop db restore`" in told
