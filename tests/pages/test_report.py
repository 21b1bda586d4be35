"""The report in a real browser, without a network."""

import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import pytest

from tests.support.chromium import console_errors, dump_dom
from tests.support.correction import example_correction
from tests.support.report_figures import figures
from trueloop.report.page import page
from trueloop.report.touch_table import touch_rows, touches_csv

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
def test_every_figure_is_drawn(pages: dict[str, Path], part: str) -> None:
    dom = dump_dom(pages[part])
    expected = list(figures(example_correction(part)))
    assert dom.count('class="plot js-plotly-plot"') == len(expected)
    points = sum(len(trace["x"]) for figure in expected for trace in figure["data"] if trace["mode"] == "markers")
    assert len(re.findall(r'<path class="point"', dom)) == points


def test_the_table_and_the_csv_are_the_data(pages: dict[str, Path]) -> None:
    dom = dump_dom(pages["modbas2"])
    correction = example_correction("modbas2")
    (table,) = re.findall(r'<table id="touches">(.*?)</table>', dom, re.DOTALL)
    rows = [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", table)[1:]]
    for cells, row in zip(rows, touch_rows(correction), strict=True):
        assert (cells[0], re.sub(r" <abbr.*", "", cells[1])) == (row.feature, row.point)
        assert float(cells[5].replace("−", "-")) == pytest.approx(row.error_before_um, abs=0.0501)
    (text,) = re.findall(r'<pre id="csv">(.*?)</pre>', dom, re.DOTALL)
    assert unescape(text).split() == touches_csv(correction).split()
