"""The report in a real browser, without a network."""

import re
from collections import Counter
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import pytest

from tests.support.chromium import console_errors, dump_dom
from tests.support.correction import example_correction
from tests.support.report_figures import figures
from trueloop.report.style import Trace
from trueloop.report.turned.page import page
from trueloop.report.turned.touch_table import touch_rows, touches_csv

PARTS = ("modbas2", "piecs11", "facetst")


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Path]]:
    folder = tmp_path_factory.mktemp("report")
    files = {part: folder / f"{part}.html" for part in PARTS}
    for part, file in files.items():
        file.write_text(page(example_correction(part)), encoding="utf-8")
    yield files


@pytest.mark.parametrize("part", PARTS)
def test_the_console_stays_silent(pages: dict[str, Path], part: str) -> None:
    assert console_errors(pages[part]) == []


@pytest.mark.parametrize("part", PARTS)
def test_every_mark_says_its_values_when_pointed_at(pages: dict[str, Path], part: str) -> None:
    dom = dump_dom(pages[part])
    expected = list(figures(example_correction(part)))
    assert dom.count('<svg class="still"') == len(expected)
    marks = [mark for figure in expected for trace in figure["data"] for mark in said(trace)]
    found = Counter(unescape(words) for words in re.findall(r'data-tip="([^"]*)"', dom))
    assert Counter(unescape(words).replace("<br>", "\n") for words in marks) <= found


def said(trace: Trace) -> list[str]:
    return list(trace.get("hovertext", [])) if trace["mode"] == "markers" else []


ACT = """<script>
const svg = document.querySelector("#before-after .wide svg");
const mark = svg.querySelector("circle[data-tip]");
const box = mark.getBoundingClientRect();
const at = (name, x, y) =>
  svg.dispatchEvent(new PointerEvent(name, { clientX: x, clientY: y, pointerType: "mouse", bubbles: true }));
svg.setPointerCapture = () => undefined;  // only a real pointer can be captured
at("pointermove", box.left + 6, box.top + 6);
document.body.dataset.said = document.getElementById("tip").textContent;
document.body.dataset.wanted = mark.dataset.tip;
at("pointermove", 1, 1);
document.body.dataset.away = String(document.getElementById("tip").hidden);
document.body.dataset.whole = svg.getAttribute("viewBox");
const frame = svg.getBoundingClientRect();
at("pointerdown", frame.left + 100, frame.top + 100);
at("pointermove", frame.left + 200, frame.top + 160);
at("pointerup", frame.left + 200, frame.top + 160);
document.body.dataset.closer = svg.getAttribute("viewBox");
document.body.dataset.shown = String(svg.querySelectorAll(".drag").length);
at("dblclick", 5, 5);
document.body.dataset.again = svg.getAttribute("viewBox");
</script></body>"""


def test_a_figure_says_values_and_can_be_looked_at_closer(pages: dict[str, Path], tmp_path: Path) -> None:
    acted = tmp_path / "acted.html"
    acted.write_text(pages["modbas2"].read_text(encoding="utf-8").replace("</body>", ACT), encoding="utf-8")
    assert console_errors(acted) == []
    body = re.search(r"<body ([^>]*)>", dump_dom(acted))
    assert body is not None
    done = dict(re.findall(r'data-(\w+)="([^"]*)"', body[1]))
    assert done["said"] == done["wanted"] != ""
    assert "µm" in done["said"] and done["away"] == "true"
    assert done["again"] == done["whole"] != done["closer"]
    wide, high = (float(number) for number in done["closer"].split()[2:])
    assert wide / high == pytest.approx(100 / 60, rel=0.02) and done["shown"] == "0"


def test_the_table_and_the_csv_are_the_data(pages: dict[str, Path]) -> None:
    dom = dump_dom(pages["modbas2"])
    correction = example_correction("modbas2")
    (table,) = re.findall(r'<table id="touches">(.*?)</table>', dom, re.DOTALL)
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", table)[1:]]
    for cells, row in zip(rows, touch_rows(correction), strict=True):
        assert (cells[0], re.sub(r" <abbr.*", "", cells[1])) == (row.feature, row.point)
        assert float(cells[5].replace("−", "-")) == pytest.approx(row.error_before_um, abs=0.0501)
    (text,) = re.findall(r'href="data:text/csv;charset=utf-8,([^"]*)"', dom)
    assert unquote(text) == touches_csv(correction)
