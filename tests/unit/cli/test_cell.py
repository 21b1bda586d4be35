"""`trueloop cell`: settings that cannot be used, and what its journal says, without any service or machine."""

import json
from pathlib import Path

import pytest

from tests.support.cli import invoke as run
from trueloop.controllers.linuxcnc.cell.journal import Journal
from trueloop.formats.cell_toml import read_cell
from trueloop.jobs.cell import opened

SETTINGS = '[cell]\nmachine = "lathe"\nservice = "http://127.0.0.1:1"\n[linuxcnc]\nini = "lathe.ini"\n'


@pytest.fixture
def settings(tmp_path: Path) -> Path:
    file = tmp_path / "cell.toml"
    file.write_text(SETTINGS)
    (tmp_path / "cell.key").touch(0o600)
    (tmp_path / "cell.key").write_text("tl_abc\n")
    return file


def test_names_count_from_the_settings(settings: Path) -> None:
    cell = opened(settings)
    assert cell.journal == settings.parent / "cell.journal" and cell.ini == settings.parent / "lathe.ini"
    assert read_cell(settings).model.temperatures.pins == {}


def test_a_key_that_others_may_read_is_refused(settings: Path) -> None:
    (settings.parent / "cell.key").chmod(0o644)
    done = run("cell", "arm", "O1", "--parts", "1", "--why", "night", "--settings", str(settings))
    assert done.exit_code == 3
    assert "CEL-FILE" in done.stderr and "644" in done.stderr and "chmod 600" in done.stderr
    assert str(settings) in done.stderr


@pytest.mark.parametrize("key", ["", "a b\n"])
def test_a_key_is_one_word(settings: Path, key: str) -> None:
    (settings.parent / "cell.key").write_text(key)
    done = run("cell", "arm", "O1", "--parts", "1", "--why", "night", "--settings", str(settings))
    assert done.exit_code == 3 and "a key is 1" in done.stderr


def test_a_service_that_is_away_is_named(settings: Path) -> None:
    done = run("cell", "arm", "O1", "--parts", "1", "--why", "night", "--settings", str(settings))
    assert done.exit_code == 3
    assert "CEL-SERVICE" in done.stderr and "http://127.0.0.1:1" in done.stderr


def test_a_certificate_that_is_none_is_refused(settings: Path) -> None:
    (settings.parent / "ca.pem").write_text("nothing")
    settings.write_text(
        SETTINGS.replace("http:", "https:").replace("[linuxcnc]", 'certificates = "ca.pem"\n[linuxcnc]')
    )
    done = run("cell", "arm", "O1", "--parts", "1", "--why", "night", "--settings", str(settings))
    assert done.exit_code == 3 and "CEL-FILE" in done.stderr and "ca.pem" in done.stderr


def test_the_journal_is_told(settings: Path) -> None:
    journal = Journal(settings.parent / "cell.journal")
    journal.add("run", key="O1.1.0.1", sent_sha256="ab", touches="", kind="finish")
    values = {"run": "O1.1.0.1", "what": "sent", "at": "2026-01-01T00:00:00+00:00", "witness": "cell", "values": {}}
    journal.add("fact", **values)
    told = run("cell", "status", "--settings", str(settings))  # also while the cell has it
    journal.close()
    assert told.exit_code == 0
    assert "run O1.1.0.1, sent" in told.stdout and "1 entries wait" in told.stdout
    found = json.loads(run("cell", "status", "--settings", str(settings), "--json").stdout)
    assert found["run"] == {"key": "O1.1.0.1", "sent_sha256": "ab", "facts": ["sent"]} and found["waiting"] == 1


def test_no_journal_yet(settings: Path) -> None:
    done = run("cell", "status", "--settings", str(settings))
    assert done.exit_code == 3 and "cell.journal" in done.stderr
