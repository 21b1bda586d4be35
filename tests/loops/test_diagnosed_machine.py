"""From simulated parts in files, through the store, to the axis error that was written down before."""

import json
from pathlib import Path

import pytest

from studies.diagnosed.part_types import DISC, SLIM, STUB
from studies.diagnosed.shop import Shop, cut_series
from studies.diagnosed.truth import Truth
from tests.support.cli import output_of
from tests.support.diagnosed_files import both_file, decompose, model_file, wrong
from trueloop.formats.tables.model_file import read_model

TOOLS = ("T1", "T2", "T3")


def kept(folder: Path, truth: Truth, shops: tuple[Shop, ...], seed: int = 5) -> tuple[Path, str]:
    """Model and store, with the parts of all shops in it."""
    model, db = model_file(folder), str(folder / "trueloop.db")
    output_of("db", "init", db)
    for number, shop in enumerate(shops):
        series = cut_series(truth, shop, seed + number)
        for k, made in enumerate(series.made):
            file = both_file(series, made, folder / f"{shop.part.name}-{k}.csv")
            output_of(*decompose(series, made, file, model, db, type=shop.part.name, serial=f"{number}{k:02d}"))
    return model, db


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The carriage tilts by 150 µrad at 8 K, as the model does not know; three part types, three tools."""
    folder = tmp_path_factory.mktemp("machine")
    shops = tuple(Shop(part, TOOLS, parts=4, set_anew=()) for part in (SLIM, DISC, STUB))
    return kept(folder, wrong("EBZ", 150e-6), shops)


def test_the_error_that_is_wrong_is_in_the_set_named(store: tuple[Path, str]) -> None:
    model, db = store
    found = json.loads(output_of("diagnose", "machine", "-m", model, "--db", db, "--json"))
    assert (found["parts"], found["machine"]) == (12, "lathe 3")
    assert found["sound"] < 0.01
    named = [one["error"] for each in found["sets"] for one in each["errors"]]
    assert named == ["EBZ"]
    assert {one["follows"] for each in found["sets"] for one in each["errors"]} == {"T_carriage"}


def test_a_sound_model_is_said_to_be_sound(tmp_path: Path) -> None:
    model, db = kept(tmp_path, Truth(), (Shop(SLIM, TOOLS, parts=6, set_anew=()),))
    found = json.loads(output_of("diagnose", "machine", "-m", model, "--db", db, "--json"))
    assert found["sound"] > 0.5
    assert found["sets"] == []


def test_a_refined_model_is_offered_and_leaves_less(store: tuple[Path, str], tmp_path: Path) -> None:
    model, db = store
    call = ("diagnose", "refine", "-m", model, "--db", db, "--errors", "auto", "-o", tmp_path, "--json")
    found = json.loads(output_of(*call))
    refinement = found["refinement"]
    assert (refinement["accepted"], refinement["version"], refinement["better"]) == (None, 1, True)
    parts = refinement["left_out"][0]
    assert parts["after_um"] < 0.75 * parts["before_um"]
    offered = tmp_path / "offered.json"
    looked_at = json.loads(output_of("diagnose", "machine", "-m", offered, "--db", db, "--json"))
    assert looked_at["sound"] > found["sound"]
    output_of("machine", "accept", offered, "-o", tmp_path / "accepted.json", "--why", "looked at", "--db", db)
    assert read_model(tmp_path / "accepted.json").machine.serial == "77"
    again = json.loads(output_of("diagnose", "machine", "-m", tmp_path / "accepted.json", "--db", db, "--json"))
    assert again["sound"] > found["sound"]
    assert "DIA-MODEL" in {one["code"] for one in again["findings"]}


def test_names_that_there_are_not(store: tuple[Path, str], tmp_path: Path) -> None:
    model, db = store
    said = output_of("diagnose", "machine", "-m", model, "--db", db, "--type", "slim shft", status=3)
    assert "DIA-NONE" in said
    assert "did you mean 'slim shaft'?" in said
    other = model_file(tmp_path, name="lathe 4")
    assert "did you mean 'lathe 3'?" in output_of("diagnose", "machine", "-m", other, "--db", db, status=3)
    call = ("diagnose", "refine", "-m", model, "--db", db, "--errors", "EXW", "-o", tmp_path / "x")
    assert "MCH-AXIS" in output_of(*call, status=3)
    assert not (tmp_path / "x").exists()


def test_a_page_and_json_are_written(store: tuple[Path, str], tmp_path: Path) -> None:
    model, db = store
    output_of("diagnose", "machine", "-m", model, "--db", db, "-o", tmp_path)
    assert json.loads((tmp_path / "machine.json").read_text())["parts"] == 12
    assert "EBZ" in (tmp_path / "machine.html").read_text()
