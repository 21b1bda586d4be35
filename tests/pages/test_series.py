"""The page of a series: in a window of 400 px, in German, within its size, with what it has to mark."""

import re
from pathlib import Path

import pytest

from tests.pages.test_paper_and_telephone import LOOK
from tests.support.chromium import dump_dom
from tests.support.series import inspection
from trueloop.domain.option import LengthUnit
from trueloop.loops.post_process.series import PartSeen, series_of
from trueloop.loops.post_process.tracked import replay
from trueloop.report.markup import text_of
from trueloop.report.series.page import series_page
from trueloop.report.series.values import SeriesShape, replay_shape
from trueloop.report.style import IN, OUT
from trueloop.report.texts.texts import Texts

PARTS = 70
UNITS: tuple[LengthUnit, ...] = ("mm", "inch")


def _shown(names: int = 2) -> SeriesShape:
    """Parts that jump once, and for one of which the tool was set."""
    errors = [20.0 + 3.0 * ((7 * k) % 5 - 2) + (60.0 if k == 50 else 0.0) for k in range(PARTS)]
    parts = [
        PartSeen(inspection(f"P{k}", {f"journal {n}": error for n in range(names)}), set_before=k == 40)
        for k, error in enumerate(errors)
    ]
    return replay_shape("SHAFT <1>", [replay(one) for one in series_of(parts)], PARTS, ())


@pytest.fixture(scope="module")
def shown() -> SeriesShape:
    return _shown()


def test_the_page_marks_alarms_settings_and_why_weights_moved(shown: SeriesShape) -> None:
    page = series_page(shown, Texts("en"))
    assert "SHAFT &lt;1&gt;" in page and "<1>" not in page.split("<script>")[0].replace("<h1>", "")
    figure = page.split('id="series-1"')[1].split("</figure>")[0]
    alarms = [part.serial for part in shown.characteristics[0].parts if part.alarm]
    assert "P50" in alarms and figure.count(f'fill="{OUT}"') == len(alarms)
    assert figure.count("<circle") >= 60 and IN in figure
    assert figure.count('stroke-dasharray="2 4"') == 1, "the tool was set once"
    assert "the tool was set before this part" in text_of(figure)
    assert "the latest 60 of 70 parts" in text_of(figure)


def test_the_german_page_has_commas_and_inches_are_microinches(shown: SeriesShape) -> None:
    page = text_of(series_page(shown, Texts("de", "inch")).split("<script>")[0])
    assert "Abweichung (µin)" in page and "Gewicht" in page
    for word in (" the ", " parts ", "weight ", "learned"):
        assert word not in page
    limits = [re.findall(r'<path d="([^"]*)"[^>]*"7 5"', series_page(shown, Texts("de", unit))) for unit in UNITS]
    assert limits[0] == limits[1] != [], "a limit stays where it is in the picture"
    value = shown.characteristics[0].left_rms_um["measured"]
    assert f"{value * 1000 / 25.4:.1f}".replace(".", ",") in page


def test_a_page_of_many_series_keeps_within_400_kb_and_names_how_many_it_leaves_out() -> None:
    page = series_page(_shown(40))
    assert len(page.encode()) <= 400_000
    left_out = re.search(r"(\d+) more characteristics stand in the table alone", page)
    assert left_out is not None and int(left_out[1]) + page.count("<figure ") == 40


def test_at_400_px_nothing_runs_over_the_edge_and_figures_are_legible(shown: SeriesShape, tmp_path: Path) -> None:
    content = series_page(shown, Texts("de")).replace("&", "&amp;").replace('"', "&quot;")
    frame = f'<iframe srcdoc="{content}" style="width:400px;height:4000px;border:0"></iframe>'
    look = tmp_path / "look.html"
    look.write_text(f"<!doctype html><body>{frame}{LOOK}</body>", encoding="utf-8")
    body = re.search(r"<body ([^>]*)>", dump_dom(look))
    assert body is not None
    seen = dict(re.findall(r'data-(\w+)="([^"]*)"', body[1]))
    assert int(seen["wide"]) <= 400
    assert float(seen["least"]) >= 9  # px on the screen
    assert int(seen["figures"]) == 2
