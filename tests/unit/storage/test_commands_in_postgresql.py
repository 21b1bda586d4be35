"""`trueloop db` with a store in PostgreSQL: as with a file, and what goes through it comes out the same."""

import json
from pathlib import Path

import pytest

from tests.support.cli import invoke, output_of
from tests.support.postgresql import Server
from trueloop.cli.terminal import ExitStatus

MODBAS2 = Path(__file__).parents[3] / "examples" / "modbas2"
GIVEN = ("--job", MODBAS2 / "job.toml", "--serial", "2511")


def test_a_store_in_postgresql_is_worked_with_as_one_in_a_file(
    server: Server, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    first, second = server.new_database(), server.new_database()
    assert "holds no store" in output_of("db", "check", "--db", first, status=ExitStatus.REFUSED)
    invoke("db", "init", first, status=0)
    assert "STO-EXISTS" in output_of("db", "init", first, status=ExitStatus.REFUSED)

    imported = ("db", "import", MODBAS2 / "touches.csv", *GIVEN, "--db", first)
    assert "1 of 1 new" in output_of(*imported)
    assert "inspection:1 is there already, not kept again" in output_of(*imported)
    refused = output_of(*imported[:-3], "2512", "--db", first, status=ExitStatus.REFUSED)
    assert "STO-OTHER-PART" in refused

    shown = json.loads(output_of("db", "show", "2511", "--json", "--db", first))
    assert [(one["row"], shown["part"]["serial"]) for one in shown["entries"]] == [("inspection:1", "2511")]
    row = json.loads(output_of("db", "show", "inspection:1", "--json", "--db", first))
    assert len(row["value"]["values"]) == 32
    assert "0 findings" in output_of("db", "check", "--db", first)

    invoke("db", "export", "-o", "first.jsonl", "--db", first, status=0)
    invoke("db", "init", second, status=0)
    invoke("db", "init", "file.db", status=0)
    for place in (second, "file.db"):
        assert "3 of 3 new" in output_of("db", "import", "first.jsonl", "--db", place)
        invoke("db", "export", "-o", "again.jsonl", "--db", place, status=0)
        assert (tmp_path / "again.jsonl").read_bytes() == (tmp_path / "first.jsonl").read_bytes()
        assert "0 findings" in output_of("db", "check", "--db", place)
