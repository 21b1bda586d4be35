"""Pages of diagnoses: what they say of sound and guilty alike, arrows with their signs, German, windows of 400 px."""

import re
from pathlib import Path

import pytest

from scripts.nist_causes import diagnosed
from tests.pages.test_paper_and_telephone import LOOK
from tests.support import diagnosis
from tests.support.chromium import console_errors, dump_dom
from trueloop.diagnosis.causes.cause import Diagnosis, SeenSeries
from trueloop.report.diagnosis.page_machine import machine_page
from trueloop.report.diagnosis.page_part import fixture_page, part_page, series_page
from trueloop.report.diagnosis.shapes import PartDiagnosisShape
from trueloop.report.diagnosis.values import part_shape, series_shape
from trueloop.report.markup import text_of
from trueloop.report.texts.texts import ENGLISH, Texts


def one_part() -> PartDiagnosisShape:
    shape = part_shape("SHAFT <7>", diagnosis.seen_series().parts[0], diagnosis.guilty())
    return shape.model_copy(update={"points": [diagnosis.point()]})


def pages(say: Texts, long_names: bool = False) -> dict[str, str]:
    series = diagnosis.seen_series(long_names=long_names)
    return {
        "part": part_page(one_part(), say),
        "series": series_page(series_shape("SHAFT <7>", series, diagnosis.guilty()), say),
        "fixture": fixture_page(diagnosis.fixtures(), say),
        "machine": machine_page(diagnosis.machine(), say),
    }


def said(page: str) -> str:
    return text_of(page.split("<script>", maxsplit=1)[0])


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (diagnosis.guilty(), "Cause found: tool offset. Probability 95.5 %."),
        (diagnosis.torn(), "One of 2 answers, which these data do not tell apart: tool offset; part-probe offset."),
        (diagnosis.sound(), "Sound: nothing acts that 12 parts could show. Probability 98.1 %."),
        (None, "Nothing is concluded; the findings say why."),
    ],
)
def test_the_verdict_names_one_cause_or_all_that_are_left_or_none(found: Diagnosis | None, words: str) -> None:
    series = diagnosis.sound_series() if found == diagnosis.sound() else diagnosis.seen_series()
    assert words in said(series_page(series_shape("SHAFT", series, found)))


def test_an_error_without_a_cause_is_never_called_sound() -> None:
    """Radii of 12 µm on the machine, which falls to 1 µm after a setting, and a verdict that nothing acts."""
    page = said(series_page(series_shape("SHAFT", diagnosis.seen_series(), diagnosis.sound())))
    assert "No known cause (98.1 % that none acts), but errors beyond their uncertainty: end − shoulder, length" in page
    assert "Sound" not in page and "Not explained" in page


def test_a_cause_stands_with_evidence_remedy_and_what_would_decide() -> None:
    page = series_page(series_shape("SHAFT", diagnosis.seen_series(), diagnosis.guilty()))
    card = page.split('<div class="cause">')[2]
    assert "tool offset<span>96.2 %" in card and 'width="96.20"' in card
    assert "<li class=for>+12.0 µm (on the radius)" in card
    assert "<li class=against>one of three features moves less" in card
    assert "+11.8 ± 1.2 µm (95 %)" in card and "[4773 §4.2 a]" in card
    assert "a standard part under standard conditions" in page.split('id="decide"')[1]


@pytest.mark.parametrize("name", ["part", "series", "fixture", "machine"])
def test_names_are_escaped_and_no_english_is_left_on_a_german_page(name: str) -> None:
    page = pages(Texts("de"), long_names=True)[name].split("<script>")[0]
    assert not re.search(r"<[17]>|<journal|P<\d", page.replace("<h1>", ""))
    for word in (" the ", " parts", "Probability", " nothing ", "error ("):
        assert word not in text_of(page), word
    assert "&lt;" in page


@pytest.mark.parametrize("name", ["part", "series", "fixture", "machine"])
def test_at_400_px_nothing_runs_over_the_edge_and_figures_are_legible(name: str, tmp_path: Path) -> None:
    page = pages(Texts("de"), long_names=True)[name]
    content = page.replace("&", "&amp;").replace('"', "&quot;")
    frame = f'<iframe srcdoc="{content}" style="width:400px;height:4000px;border:0"></iframe>'
    look = tmp_path / "look.html"
    look.write_text(f"<!doctype html><body>{frame}{LOOK}</body>", encoding="utf-8")
    body = re.search(r"<body ([^>]*)>", dump_dom(look))
    assert body is not None
    seen = dict(re.findall(r'data-(\w+)="([^"]*)"', body[1]))
    assert int(seen["wide"]) <= 400
    assert float(seen["least"]) >= 9  # px on the screen
    assert int(seen["figures"]) == {"part": 1, "series": 4, "fixture": 2, "machine": 3}[name]
    alone = tmp_path / "page.html"
    alone.write_text(page, encoding="utf-8")
    assert console_errors(alone) == []


def test_200_parts_keep_within_400_kb_and_name_what_is_left_out() -> None:
    shape = series_shape("SHAFT", diagnosis.seen_series(200, 30, long_names=True), diagnosis.torn())
    page = series_page(shape)
    assert len(page.encode()) <= 420_000
    left_out = re.search(r"(\d+) more errors stand in the table alone", page)
    assert left_out is not None and int(left_out[1]) + page.count("<figure ") == len(shape.means) == 31


def test_a_series_without_parts_has_a_page() -> None:
    assert "No part has errors of features." in said(series_page(series_shape("SHAFT", SeenSeries({}, ()), None)))


def test_the_machine_page_never_names_one_error_out_of_a_set() -> None:
    page = said(machine_page(diagnosis.machine(), ENGLISH))
    assert "The model has wrong: one of EXZ, EBZ, which these data do not tell apart. Probability that nothing" in page
    assert "told apart bya tool of another length in X" in page
    assert "Offered, not in force" in page and "+2.10 ± 0.30" in page
    alone = diagnosis.machine().model_copy(update={"sets": [diagnosis.found_set("EXX")], "refinement": None})
    assert "The model has wrong: EXX. Probability that nothing is wrong: 0.4 %." in said(machine_page(alone))
    nothing = alone.model_copy(update={"sets": [], "sound": 0.97})
    assert "Sound: the model has nothing wrong that 20 parts could show. Probability 97.0 %." in said(
        machine_page(nothing)
    )


def test_an_unstable_fixturing_stops_everything_else() -> None:
    page = said(fixture_page(diagnosis.fixtures()))
    assert "Unstable: part. Nothing else is concluded until this is mended." in page
    assert "after repeat 4" in page and "+8.0 ± 0.6" in page


def test_a_real_diagnosis_is_said_in_german() -> None:
    """Names, evidence and remedies of the catalogue, of NIST's parts."""
    page = said(series_page(diagnosed("MODBAS2", "semifinish"), Texts("de")))
    assert "Form der Schneidenecke" in page and "Der Taster der Maschine findet im Mittel von 4 Teilen" in page
    for word in ("tool wear", " the ", "standard uncertainty", "It is the same"):
        assert word not in page
