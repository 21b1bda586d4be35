"""Single pictures of corrections and proposals: what they draw, in words too, and on a dark page."""

import re
import xml.etree.ElementTree as ET

import pytest

from tests.support.correction import example_correction
from trueloop.domain.proposal import Effect
from trueloop.report import style
from trueloop.report.series.page import proposal_figure
from trueloop.report.still import svg
from trueloop.report.style import DARK, in_the_dark
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures.curves import curve_pictures, curve_svg, error_curve

SVG = "{http://www.w3.org/2000/svg}"


def luminance(colour: str) -> float:
    """Relative luminance of WCAG 2.2 of `#rrggbb`."""
    channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one: str, other: str) -> float:
    """Contrast of WCAG 2.2."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_what_means_something_is_read_on_a_dark_page_as_well_as_on_white() -> None:
    ground = DARK["#ffffff"]
    for colour in (style.LEFT_ON, style.TAKEN, style.AFTER, style.IN, style.OUT, style.INK, style.SOFT):
        assert contrast(DARK[colour], ground) >= 4.5, colour
    assert contrast(DARK[style.FAINT], ground) >= 3


def test_a_dark_picture_has_the_same_drawing_and_words() -> None:
    correction = example_correction("modbas2")
    light = curve_svg(correction, correction.profile.names.index("dome"), 980, Texts())
    dark = in_the_dark(light)
    for colour in DARK:
        assert f'"{colour}"' not in dark
    places = re.compile(r'(?: d| x| y| cx| cy)="[^"]*"|>[^<]+<')
    assert places.findall(light) == places.findall(dark)
    assert style.LEFT_ON in light and DARK[style.LEFT_ON] in dark


def test_a_word_that_is_a_colour_stays() -> None:
    assert in_the_dark(f"<text>{style.INK}</text>") == f"<text>{style.INK}</text>"


def test_the_words_of_a_curve_say_what_is_drawn() -> None:
    correction = example_correction("modbas2")
    (dome,) = (one for one in curve_pictures(correction, Texts()) if one.feature == "dome")
    fitted = next(one for one in error_curve(correction, dome.number)["data"] if one.get("name") == "fitted curve")
    low, high = (float(one.replace("−", "-")) for one in re.findall(r"[+−][\d.]+(?= )", dome.said)[:2])
    assert low == pytest.approx(min(fitted["y"]), abs=0.05)
    assert high == pytest.approx(max(fitted["y"]), abs=0.05)
    german = {one.number: one.said for one in curve_pictures(correction, Texts("de"))}
    assert german[dome.number].startswith("Abweichungskurve von dome: ")


def test_a_proposal_is_of_sizes_whose_sign_has_no_colour_and_bars_hold_95_percent() -> None:
    effects = [Effect(name, ("S", "A", name), 9, -e, e, 0.001, 0.002) for name, e in (("a<b", 0.009), ("c", -0.012))]
    figure = proposal_figure(effects)
    before, after = figure["data"]
    assert before["marker"]["color"] not in ([style.LEFT_ON, style.TAKEN], style.LEFT_ON, style.TAKEN)
    assert (before["y"], after["y"]) == (pytest.approx([9, -12]), pytest.approx([1, 1]))
    assert before["error_y"]["array"] == pytest.approx([3.92, 3.92], abs=0.005)
    low, high = figure["layout"]["yaxis"]["range"]
    assert low < -12 - 3.92 and high > 9 + 3.92
    picture = ET.fromstring(svg(figure, "p"))
    assert "a<b" in {one.text for one in picture.iter(f"{SVG}text")}
