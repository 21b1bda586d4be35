"""Pictures of corrections and proposals over HTTP: of what is stored, in a sandbox of their own."""

import xml.etree.ElementTree as ET

import pytest

from tests.support.correction import example_correction
from tests.support.full_shop import full_shop
from tests.support.service import Running, problem
from trueloop.loops.turned.error_sources import Source
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures.curves import curve_pictures, curve_svg
from trueloop.report.turned.sources import source_name, source_svg


def test_a_correction_has_a_picture_of_each_error_curve(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    (made,) = vera.get("parts/1/life").json()["corrections"]
    stored, words = example_correction("modbas2"), Texts("de")
    shown = vera.get(f"corrections/{made['id']}/curves?language=de").json()["items"]
    assert shown == [vars(one) for one in curve_pictures(stored, words)] != []
    for one in shown:
        answer = vera.get(f"corrections/{made['id']}/curves/{one['number']}?language=de&narrow=true")
        assert answer.headers["content-type"] == "image/svg+xml"
        assert answer.headers["content-security-policy"].startswith("sandbox; default-src 'none'")
        assert answer.text == curve_svg(stored, one["number"], 480, words)


def test_a_correction_has_a_picture_of_the_sources_of_its_errors(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    (made,) = vera.get("parts/1/life").json()["corrections"]
    stored, words = example_correction("modbas2"), Texts("de")
    answer = vera.get(f"corrections/{made['id']}/sources?language=de&narrow=true")
    assert answer.headers["content-type"] == "image/svg+xml"
    assert answer.text == source_svg(stored, 480, words)
    said = ET.fromstring(answer.text).get("aria-label") or ""
    dome = stored.sources[stored.profile.names.index("dome")]
    assert f"dome {words.error(1e3 * dome.together_mm)} ± " in said
    dark = vera.get(f"corrections/{made['id']}/sources?language=de&narrow=true&dark=true").text
    assert dark != answer.text and source_name(Source.NOSE, words) in dark


def test_a_proposal_has_its_picture_and_names_what_the_last_part_was_cut_by(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    shown = vera.get("proposals/dome1").json()
    (made,) = shown["corrections"]
    assert shown["last_serial"] == "2711"
    assert vera.get(f"corrections/{made}/curves").json()["items"] != []
    light, dark = (vera.get(f"proposals/dome1/picture?dark={one}").text for one in ("false", "true"))
    assert ET.fromstring(light).get("aria-label") and light != dark


@pytest.mark.parametrize(
    "path",
    ["corrections/none/curves", "corrections/none/curves/0", "corrections/none/sources", "proposals/none/picture"],
)
def test_what_is_not_there_is_refused(service: Running, path: str) -> None:
    full_shop(service.store)
    assert problem(service.signed_in("viewer").get(path)) == "FAC-UNKNOWN"


def test_a_feature_without_a_curve_has_no_picture(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    (made,) = vera.get("parts/1/life").json()["corrections"]
    assert problem(vera.get(f"corrections/{made['id']}/curves/99")) == "FAC-UNKNOWN"
