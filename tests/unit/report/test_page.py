"""The page holds everything, asks for nothing from outside, and takes no orders from names in it."""

from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from scipy.special import ndtri, stdtrit

from tests.support.correction import example_correction, size_error_correction
from tests.support.report_figures import figures
from trueloop.loops.turned.correction import Correction
from trueloop.report.turned.page import page

HOSTILE = "<script>alert('x')</script> & <b>\"5\"</b> </title>"


class Outline(HTMLParser):
    """Sections, links, and the text outside scripts and styles."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.scripts = 0
        self.words = ""
        self._silent = False
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        known = dict(attrs)
        self.ids += [value for value in [known.get("id")] if value]
        self.links += [value for key in ("href", "src") if (value := known.get(key))]
        self.scripts += tag == "script"
        self._silent = tag in ("script", "style")

    def handle_endtag(self, tag: str) -> None:
        self._silent = False

    def handle_data(self, data: str) -> None:
        self.words += "" if self._silent else data


@pytest.fixture(scope="module")
def modbas2_page() -> Outline:
    return Outline(page(example_correction("modbas2")))


def renamed(correction: Correction, name: str) -> Correction:
    """Part, touches, features and record with a name that tries to be markup."""
    features = tuple(replace(feature, name=name + str(i)) for i, feature in enumerate(correction.profile.features))
    touches = replace(correction.touches, point=tuple(name + point for point in correction.touches.point))
    return replace(
        correction,
        part=name,
        profile=replace(correction.profile, features=features),
        touches=touches,
        source_program=name.encode(),
        notes=(name,),
        record=replace(correction.record, made_by=name, inputs_sha256={name: name}, options={name: name}),
    )


def test_every_section_is_there(modbas2_page: Outline) -> None:
    assert {"part", "curves", "meet", "program", "why", "numbers", "origin"} <= set(modbas2_page.ids)
    assert {"features", "junctions", "touches", "inputs", "options"} <= set(modbas2_page.ids)


def test_the_head_says_what_to_cut_with_and_that_it_is_a_prediction(modbas2_page: Outline) -> None:
    correction = example_correction("modbas2")
    after = correction.prediction.after_mm * 1000
    worst = int(np.argmax(np.abs(after)))
    assert "PredictionFinish with corrected.nc: the worst error is expected to be" in modbas2_page.words
    k = stdtrit(correction.model.degrees_of_freedom, 0.975)  # Student's, two-sided 95 %
    budget = correction.prediction.budget
    u = 1000 * np.hypot(k * budget.found_mm[worst], ndtri(0.975) * budget.stated_mm[worst])
    assert f"{after[worst]:+.1f} ± {u:.1f}" in modbas2_page.words
    assert f"hold 95 %: k u, with k = {k:.2f} for what is fitted or scatters" in modbas2_page.words
    assert f"at point {correction.touches.point[worst]} on" in modbas2_page.words
    assert "worst measured before: +94.2 µm" in modbas2_page.words


def test_the_sign_is_told_in_words(modbas2_page: Outline) -> None:
    assert "+ is material left on (red), − is too much taken (blue)" in modbas2_page.words


def test_the_tangency_of_the_predicted_part_is_stated(modbas2_page: Outline) -> None:
    model = example_correction("modbas2").model
    (tangency,) = model.tangency
    assert (
        f"0.00 ± {stdtrit(model.degrees_of_freedom, 0.975) * tangency.standard_u_um_per_mm:.2f}" in modbas2_page.words
    )
    assert "Tangent junctions by policy part" in modbas2_page.words


def test_decisions_inputs_and_options_are_told(modbas2_page: Outline) -> None:
    correction = example_correction("modbas2")
    for words in (correction.decision.x.words, correction.decision.z.words, *correction.model.notes, *correction.notes):
        assert words in modbas2_page.words
    for digest in correction.record.inputs_sha256.values():
        assert digest in modbas2_page.words
    assert "limits.age_hours" in modbas2_page.words


def test_nothing_comes_from_outside(modbas2_page: Outline) -> None:
    assert modbas2_page.links
    assert all(link.startswith(("data:", "#")) for link in modbas2_page.links)
    html = page(example_correction("modbas2"))
    assert "default-src 'none'" in html


def test_pictures_stand_in_the_page_without_scripts(modbas2_page: Outline) -> None:
    html = page(example_correction("modbas2"))
    drawn = list(figures(example_correction("modbas2")))
    assert html.count('<svg class="still"') == len(drawn) == 12
    touches = example_correction("modbas2").touches
    assert all(html.count(f"point {name}\n") >= 2 for name in touches.point)  # in the drawing, and on its curve
    assert len(html.encode()) < 400_000  # a page is sent by mail, and opens on a telephone


def test_names_give_no_orders() -> None:
    html = page(renamed(example_correction("modbas2"), HOSTILE))
    calm = page(example_correction("modbas2"))
    assert Outline(html).scripts == Outline(calm).scripts
    assert "<script>alert" not in html
    assert "alert('x')" in Outline(html).words  # told as text


def test_where_an_offset_is_enough_the_offset_program_is_the_one_to_run() -> None:
    words = Outline(page(size_error_correction())).words
    assert "Finish with offsets.nc" in words
    assert "corrected.nc" not in words
    assert "TOV(X)" in words


def test_the_page_is_the_same_on_any_run() -> None:
    assert page(example_correction("piecs11")) == page(example_correction("piecs11"))
