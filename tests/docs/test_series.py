"""Series as docs/series.md tells of them; its table is that of the covers."""

import json
import shutil
from pathlib import Path

import pytest

from scripts import cover_series
from tests.support.cli import invoke, output_of
from trueloop.errors import Code

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "series.md").read_text(encoding="utf-8")


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "examples" / "shaft", tmp_path / "shaft")
    for file in (ROOT / "examples" / "series").glob("*.csv"):
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _waiting() -> str:
    found = json.loads(output_of("series", "propose", "--job", "shaft/job.toml", "--json"))
    return str(found["proposals"][0]["id"])


def test_the_same_file_adds_nothing_and_one_in_inches_is_refused(folder: Path) -> None:
    output_of("db", "init")
    output_of("series", "add", "first-three.csv")
    assert "0 parts kept" in output_of("series", "add", "first-three.csv")
    again = (folder / "first-three.csv").read_text(encoding="utf-8")
    (folder / "inch.csv").write_text(again.replace(",mm,", ",inch,").replace("SHAFT,10", "SHAFT,20"), encoding="utf-8")
    assert Code.SER_UNIT in invoke("series", "add", "inch.csv", status=3).stderr
    (folder / "copy.csv").write_text(again + "\n", encoding="utf-8")
    assert Code.SER_AGAIN in output_of("series", "add", "copy.csv")
    assert len(json.loads(output_of("series", "status", "--json"))["characteristics"][0]["parts"]) == 3


def test_a_length_between_two_faces_of_the_tool_is_not_proposed(folder: Path) -> None:
    """Shoulder and end face are cut by T3: dZ moves both, so the length stays, and Z of the offset with it."""
    output_of("db", "init")
    output_of("series", "add", "first-three.csv")
    said = output_of("series", "propose", "--job", "shaft/job.toml")
    assert "shoulder: size" not in said and "it does not change 'shoulder'" in said
    assert "Z +0.000 mm (X ± 0.009, Z not determined by what was measured)" in said
    assert Code.SER_TOOL in invoke("series", "propose", "--job", "shaft/job.toml", "-c", "shoulder", status=3).stderr


def test_a_second_decision_is_refused_and_automatic_ones_are_kept_as_such(folder: Path) -> None:
    output_of("db", "init")
    output_of("series", "add", "first-three.csv")
    proposal = _waiting()
    output_of("series", "reject", proposal, "--why", "the gauge was dirty")
    assert Code.SER_DECIDED in invoke("series", "accept", proposal, status=3).stderr
    output_of("series", "add", "next-two.csv")
    found = json.loads(output_of("series", "propose", "--automatic", "offset", "--json"))
    offsets = [one for one in found["proposals"] if one["class"] == "tool offset"]
    alarming = [one for one in offsets if one["alarms"]]
    assert all(one["decision"] is None for one in alarming), "an alarm is a person's"
    assert all(one["decision"]["automatic"] for one in offsets if not one["alarms"])
    assert len(found["waiting"]) == len(alarming)


@pytest.mark.corpus
def test_the_table_of_the_covers_is_that_of_the_script(corpus: Path) -> None:
    replays, findings = cover_series.replays_of(corpus)
    assert cover_series.table(replays) + cover_series.sentences(replays) in PAGE
    assert len(replays) == 25 and {len(one.parts) for one in replays} == {20}
    assert [(one.code, one.values["part"]) for one in findings] == [(Code.SER_NOMINAL, "15")]


@pytest.mark.corpus
def test_the_covers_enter_the_store_once_and_are_proposed_for(corpus: Path, folder: Path) -> None:
    output_of("db", "init")
    file = corpus / cover_series.FILE
    assert "20 parts kept" in output_of("series", "add", "--unit", "mm", file)
    assert "0 parts kept" in output_of("series", "add", "--unit", "mm", file)
    assert Code.SER_UNIT in invoke("series", "add", "--unit", "inch", file, status=3).stderr
    found = json.loads(output_of("series", "propose", "-c", "Diameter 7", "--json"))
    (effect,) = found["proposals"][0]["effects"]
    assert effect["parts"] == 20 and -34 < effect["size_change_um"] < -17  # holes some 33 µm too large
