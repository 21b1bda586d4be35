"""A refined model is offered, refused by all that corrects, looked at, accepted: `trueloop machine accept`."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, output_of
from tests.support.refusals import refused
from tests.support.worn_lathe import cut, lathe_model, straightness
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.record import sha256_of
from trueloop.errors import Code
from trueloop.formats.tables.model_file import model_to_json, read_model
from trueloop.jobs.machine.machine_model import offer_model
from trueloop.jobs.machine.mapped_program import ModelFile, compensate_program
from trueloop.jobs.realtime.image import make_image
from trueloop.machine.correct import Setup
from trueloop.machine.model.chain import error_name
from trueloop.machine.refine.refine import refine
from trueloop.storage.store import find, open_store

PROGRAM = "G21 G90 G18 G54 G8\nG0 X50 Z0\nG1 Z-20 F0.1\nM2\n"
PLACE = ("--work-zero", "1=60,0,-100", "-t", "T1=25")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """parent.json, fitted; offered.json, refined from it; a program."""
    folder, model = tmp_path_factory.mktemp("versions"), lathe_model()
    parent = folder / "parent.json"
    parent.write_text(model_to_json(model), encoding="utf-8")
    refined = refine(model, cut(model, straightness, 1), [error_name("EXZ")])
    offer_model(parent, refined, folder / "offered.json")
    (folder / "part.ngc").write_text(PROGRAM)
    return folder


def test_what_is_offered_names_its_parent_and_why(folder: Path) -> None:
    version = read_model(folder / "offered.json", offered=True).version
    assert version is not None
    assert (version.number, version.errors, version.accepted) == (1, ("EXZ",), None)
    assert version.parent_sha256 == sha256_of((folder / "parent.json").read_bytes())
    assert "EXZ" in version.reason and "left out" in version.judged
    assert json.loads((folder / "offered.json").read_text())["version"]["accepted"] is None
    assert "version" not in json.loads((folder / "parent.json").read_text())


def test_everything_that_corrects_refuses_it(folder: Path, tmp_path: Path) -> None:
    offered = folder / "offered.json"
    (tmp_path / "drift.json").write_text("{}")
    for call in (
        ("machine", "compensate", folder / "part.ngc", "-m", offered, *PLACE, "-o", tmp_path / "out"),
        ("machine", "export", offered, "-o", tmp_path / "out", "--control", "linuxcnc", "--axis", "X"),
        ("machine", "add-drift", offered, tmp_path / "drift.json", "--channel", "Z=EZ0C", "-o", tmp_path / "out.json"),
        ("realtime", "image", offered, "-o", tmp_path / "image.rtec"),
    ):
        result = invoke(*call)
        assert "MCH-OFFERED" in result.output and result.exit_code == 3, (call, result.output)
        assert "trueloop machine accept" in result.output
    assert refused(make_image, offered).code is Code.MCH_OFFERED
    known = ModelFile(read_model(offered, offered=True), offered)
    setup = Setup({1: (60.0, 0.0, -100.0)}, signals={"T1": 25.0})
    assert refused(compensate_program, folder / "part.ngc", tmp_path / "x.ngc", known, setup).code is Code.MCH_OFFERED
    assert not (tmp_path / "out").exists() and not (tmp_path / "x.ngc").exists()


def test_it_can_be_looked_at(folder: Path) -> None:
    assert "EXZ" in output_of("machine", "show", folder / "offered.json", "-t", "T1=25")


def test_accepted_it_corrects(folder: Path, tmp_path: Path) -> None:
    new, db = tmp_path / "new.json", str(tmp_path / "trueloop.db")
    output_of("db", "init", db)
    before = (folder / "offered.json").read_bytes()
    call = ("machine", "accept", folder / "offered.json", "--who", "A. Meister", "--why", "seen", "--db", db)
    said = output_of(*call, "-o", new)
    assert "accepted by A. Meister" in said and "2 versions of a model, 1 decision on a model" in said
    assert (folder / "offered.json").read_bytes() == before
    offered, accepted = json.loads(before), json.loads(new.read_text())
    given = accepted["version"].pop("accepted")
    assert given["who"] == "A. Meister" and given["why"] == "seen" and given["at"].endswith("+00:00")
    offered["version"].pop("accepted")
    assert offered == accepted
    known, old = read_model(new), read_model(folder / "offered.json", offered=True)
    assert np.array_equal(known.coefficients, old.coefficients)
    output_of("machine", "compensate", folder / "part.ngc", "-m", new, *PLACE, "-o", tmp_path / "out")
    (decision,) = [one.value for one in find(open_store(db), ModelDecision)]
    assert (decision.model, decision.verdict, decision.who) == (sha256_of(before), "accepted", "A. Meister")
    versions = {one.value.sha256: one.value for one in find(open_store(db), ModelVersion)}
    assert set(versions) == {sha256_of(before), sha256_of(new.read_bytes())}
    assert versions[sha256_of(before)].text == before.decode()


def test_what_is_not_offered_is_not_accepted(folder: Path, tmp_path: Path) -> None:
    new = tmp_path / "new.json"
    assert "MCH-FILE" in output_of("machine", "accept", folder / "parent.json", "-o", new, status=3)
    assert "there is no file" in output_of("machine", "accept", folder / "none.json", "-o", new, status=3)
    over = ("machine", "accept", folder / "offered.json", "-o", folder / "offered.json")
    assert "OUT-INPUT" in invoke(*over).output
    output_of("machine", "accept", folder / "offered.json", "-o", new)
    assert "accepted by" in output_of("machine", "accept", new, "-o", tmp_path / "again.json", status=3)
    assert not (tmp_path / "again.json").exists()


@pytest.mark.parametrize(
    "accepted", [{"who": ""}, {"who": "", "at": "2026"}, {"who": 3, "at": "2026"}, [], {"who": "A", "by": "B"}, True]
)
def test_a_damaged_acceptance_is_none(folder: Path, tmp_path: Path, accepted: object) -> None:
    content = json.loads((folder / "offered.json").read_text())
    content["version"]["accepted"] = accepted
    (tmp_path / "model.json").write_text(json.dumps(content))
    assert refused(read_model, tmp_path / "model.json").code is Code.MCH_FILE


def test_a_version_refined_again_counts_on(folder: Path, tmp_path: Path) -> None:
    first = tmp_path / "first.json"
    output_of("machine", "accept", folder / "offered.json", "-o", first)
    model = read_model(first)
    refined = refine(model, cut(model, straightness, 2), [])
    offer_model(first, refined, tmp_path / "second.json", accept=[Code.DIA_WORSE])
    version = read_model(tmp_path / "second.json", offered=True).version
    assert version is not None and version.number == 2 and version.accepted is None
    assert version.parent_sha256 == sha256_of(first.read_bytes())
