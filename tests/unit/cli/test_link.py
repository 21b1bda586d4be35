"""`trueloop link` as its user calls it."""

import json
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.support.cli import invoke, output_of
from trueloop.domain.record import Program, ProgramText, sha256_of
from trueloop.factory.carry_out import carry_out
from trueloop.factory.requests import By, ReleaseProgram, Role
from trueloop.factory.shown.records import transfer_rows
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import keep, open_store

NEW = b"O1\nG1 X9.9592\nM30\n"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """links.toml, the folder of a control with O1.nc, and finish.nc."""
    (tmp_path / "control").mkdir()
    (tmp_path / "control" / "O1.nc").write_bytes(b"O1\nG1 X10.\nM30\n")
    (tmp_path / "finish.nc").write_bytes(NEW)
    (tmp_path / "links.toml").write_text('[folder.lathe]\nfolder = "control"\n')
    return tmp_path


def link(place: Path, *call: object, status: int = 0) -> str:
    return output_of("link", *call, "-l", "lathe", "--settings", place / "links.toml", status=status)


def test_a_program_goes_there_and_comes_back(place: Path) -> None:
    assert "O1.nc" in link(place, "list")
    said = link(place, "compare", place / "finish.nc", "--name", "O1.nc", status=1)
    assert "X9.9592" in said and "X10." in said
    assert "LNK-EXISTS" in link(place, "put", place / "finish.nc", "--name", "O1.nc", status=3)
    assert "--not-running" in link(place, "put", place / "finish.nc", "--name", "O1.nc", "--replace", status=3)
    call = ("put", place / "finish.nc", "--name", "O1.nc", "--replace", "--not-running", "--json")
    done = json.loads(link(place, *call))
    assert done["written"] and Path(done["kept"]).read_bytes() == b"O1\nG1 X10.\nM30\n"
    link(place, "get", "O1.nc", "-o", place / "back.nc")
    assert (place / "back.nc").read_bytes() == NEW
    assert "the same" in link(place, "compare", place / "finish.nc", "--name", "O1.nc")
    listed = json.loads(link(place, "list", "--json"))["programs"]
    assert [(one["name"], one["size_bytes"]) for one in listed] == [("O1.nc", len(NEW))]


def test_a_program_edited_at_the_control_is_shown_word_by_word(place: Path) -> None:
    (place / "control" / "O1.nc").write_bytes(b"O1\nG4 P2\nN20 G1 X9.9529 F.1\nM30\n")
    (place / "finish.nc").write_bytes(b"O1\nN20 G1 X9.9592 F.1\nM30\n")
    call = ("compare", place / "finish.nc", "--name", "O1.nc")
    rows = [line.split() for line in link(place, *call, status=1).splitlines()]
    assert ["–", "2", "whole", "line", "–", "'G4", "P2\\n'"] in rows
    assert ["2", "3", "N20", "X", "X9.9592", "X9.9529"] in rows
    added, changed = json.loads(link(place, *call, "--json", status=1))["differences"]
    assert (added["line"], added["other_line"], added["words"]) == (None, 2, [])
    word = {"word": "X", "column": 8, "file": "X9.9592", "other_column": 8, "control": "X9.9529"}
    assert changed["block"] == "N20" and changed["words"] == [word]


def test_the_dialect_of_a_control_is_one_that_there_is(place: Path) -> None:
    (place / "links.toml").write_text('[folder.lathe]\nfolder = "control"\ndialect = "fanuc"\n')
    said = link(place, "list", status=3)
    assert "LNK-FILE" in said and "fanuc-lathe" in said and ":3" in said


def test_what_is_mistyped_is_refused_with_the_nearest_name(place: Path) -> None:
    assert "did you mean 'O1.nc'?" in link(place, "get", "O1.n", "-o", place / "back.nc", status=3)
    assert "OUT-INPUT" in link(place, "get", "O1.nc", "-o", place / "finish.nc", status=4)
    assert (place / "finish.nc").read_bytes() == NEW
    other = invoke("link", "list", "-l", "lath", "--settings", place / "links.toml")
    assert other.exit_code == 3 and "lathe" in other.output
    (place / "links.toml").write_text('[folder.lathe]\nfolder = "contrl"\n')
    assert "LNK-REACH" in link(place, "list", status=3)


def test_transfers_are_recorded_in_a_store_and_only_what_is_released_is_sent(place: Path) -> None:
    db = place / "factory.db"
    store = open_store(str(db), codec=store_codec(), create=True)
    name = ("--name", "O1.nc", "--db", db)
    put = ("put", place / "finish.nc", *name, "--replace", "--not-running")
    assert "FAC-UNKNOWN" in link(place, *put, status=3)
    keep(store, [Program("finish.nc", "fanuc-lathe", sha256_of(NEW)), ProgramText(sha256_of(NEW), NEW)])
    assert "FAC-RELEASE" in link(place, *put, status=3)
    carry_out(store, ReleaseProgram(sha256_of(NEW), "ran in"), By("ana", Role.ENGINEER), datetime.now(UTC))
    assert (place / "control" / "O1.nc").read_bytes() != NEW
    link(place, "compare", place / "finish.nc", *name, status=1)
    assert "LNK-EXISTS" in link(place, "put", place / "finish.nc", *name, status=3)
    link(place, *put)
    link(place, "get", "O1.nc", "-o", place / "back.nc", "--db", db)
    got, sent, refused, compared = transfer_rows(store).items
    assert (got.direction, got.read_back_sha256, got.outcome) == ("from", sha256_of(NEW), "fetched")
    assert (sent.control, sent.program, sent.direction) == ("lathe", "O1.nc", "to")
    assert sent.sent_sha256 == sent.read_back_sha256 == sha256_of(NEW) and sent.who
    assert refused.outcome.startswith("LNK-EXISTS") and refused.read_back_sha256 == ""
    assert compared.outcome == "differs: line 2 X 'X9.9592' 'X10.'"
