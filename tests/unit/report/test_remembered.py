"""Earlier parts of the edge on the page and in JSON: figures, shares, alarms, and what a translation leaves over."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_correction
from tests.support.remembered import FEW, remembered_correction, remembering_inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report import style
from trueloop.report.markup import text_of
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.correction_json import json_text
from trueloop.report.turned.figures.curves import budget_words, uncertainty
from trueloop.report.turned.page import page
from trueloop.report.turned.remembered import remembered


def test_the_figure_shows_band_line_and_touches_where_they_are() -> None:
    correction = remembered_correction()
    memory = correction.memory
    assert memory is not None and memory.expected is not None
    figure = remembered(correction, memory, memory.expected, 980)
    by_name = {trace["name"]: trace for trace in figure["data"]}
    assert set(by_name) == {"95 % band", "memory alone", "applied", "touches"}
    dome = correction.touches.of_feature(correction.profile.names.index("dome"))
    assert len(dome) == len(FEW)
    assert by_name["touches"]["y"] == pytest.approx(1e3 * correction.model.vectors.error_mm[dome])
    normal = correction.touches.outward_normal[dome]
    assert by_name["touches"]["x"] == pytest.approx(np.degrees(np.arctan2(normal[:, 0], normal[:, 1])))
    colours = by_name["touches"]["marker"]["color"]
    assert colours == [style.LEFT_ON if y > 0 else style.TAKEN for y in by_name["touches"]["y"]]
    band, k = by_name["95 % band"], len(by_name["95 % band"]["y"]) // 2
    upper, lower = np.array(band["y"][:k]), np.array(band["y"][k:])[::-1]
    rows = memory.expected.rows(correction.profile.names.index("dome"))
    u = 1e3 * np.sqrt(np.diag(memory.expected.covariance_mm2))[rows]
    assert (upper - lower) / 2 == pytest.approx(1.959964 * u, rel=1e-5)
    line = by_name["applied"]
    applied = np.interp(60.0, line["x"][::-1], line["y"][::-1])
    degrees = band["x"][:k][::-1]
    assert np.interp(60.0, degrees, lower[::-1]) < applied < np.interp(60.0, degrees, upper[::-1])


def test_what_the_page_says_is_what_was_computed() -> None:
    correction = remembered_correction()
    html = page(correction)
    text = " ".join(text_of(html).split())
    assert "Earlier parts of the edge" in text
    assert "Memory of edge SVJBL VCMT <110304> 1, inspected parts: 3." in text.replace("&lt;", "<").replace("&gt;", ">")
    assert "VCMT <110304>" not in html
    assert html.count('id="memory-angle"') == 1
    memory = correction.memory
    assert memory is not None
    share = memory.share(correction.profile.names.index("dome"))
    assert (
        f"dome: {100 * share:.0f} % of the correction is from memory, {100 * (1 - share):.0f} % from 14 touches."
        in text
    )


def test_the_budget_has_a_column_for_earlier_parts_and_zeros_elsewhere() -> None:
    correction = remembered_correction()
    table = uncertainty(correction)
    rows = re.findall(r"<tr>(.*?)</tr>", table)
    counts = {len(re.findall(r"<t[hd]", row)) for row in rows}
    assert counts == {9}
    assert "earlier parts" in budget_words(correction)
    assert "earlier parts" not in uncertainty(example_correction("modbas2"))


def test_json_has_shares_advice_and_words() -> None:
    found = json.loads(json_text(remembered_correction()))["memory"]
    assert found["applied"] and found["inspected_parts"] == 3 and found["touches_used"] == 14
    assert 1 <= found["enough_touches"] <= 14
    assert len(found["points_to_keep"]) == max(3, found["enough_touches"])
    assert {one["point"] for one in found["touches"]} > set(found["points_to_keep"])
    of_dome = [one for one in found["touches"] if one["feature"] == "dome"]
    assert len(of_dome) == len(FEW)
    for one in of_dome:
        assert one["taken_off_um"] > 5.0
        assert abs(one["taken_off_um"] - one["from_memory_um"]) < 15.0
    assert json.loads(json_text(example_correction("modbas2")))["memory"] is None


def test_an_alarm_stands_on_the_page() -> None:
    correction = compensate(remembering_inputs(moved_mm=0.060))
    assert correction.memory is not None and correction.memory.alarms
    text = " ".join(text_of(page(correction)).split())
    assert "Today's touches contradict earlier parts" in text.replace("’", "'").replace("&#x27;", "'")
    assert not json.loads(json_text(correction))["memory"]["applied"]


def test_weight_and_bands_are_said() -> None:
    inputs = remembering_inputs()
    bands = compensate(replace(inputs, memory=replace(inputs.memory, memory="bands")))
    assert "memory gives its band" in page(bands)
    half = compensate(replace(inputs, options=replace(inputs.options, weight=0.5)))
    whole, shared = (json.loads(json_text(one))["memory"]["touches"] for one in (remembered_correction(), half))
    for one, other in zip(whole, shared, strict=True):
        assert other["taken_off_um"] == pytest.approx(one["taken_off_um"] / 2, rel=1e-6)
        assert other["from_memory_um"] == pytest.approx(one["from_memory_um"] / 2, rel=1e-6)


def test_no_english_sentence_is_left_on_the_german_page() -> None:
    shown = text_of(page(remembered_correction(), Texts("de")).split("<script>")[0])
    for word in (" the ", " touches ", " of ", "earlier parts", "inspected", "memory"):
        sentences = [
            s for s in re.split(r"(?<=[.;:])\s|\n", shown) if word in s and "N0" not in s and "option" not in s
        ]
        assert not [s for s in sentences if "history" not in s], sentences
