"""The still picture shows what the specification says: same places, nothing outside its panel."""

import re
import xml.etree.ElementTree as ET

import pytest

from tests.support.correction import example_correction
from tests.support.report_figures import figures
from trueloop.report import style
from trueloop.report.still import svg
from trueloop.report.style import Figure

SVG = "{http://www.w3.org/2000/svg}"


def simple(**axis: object) -> Figure:
    """Ten by ten units on a plot of 400 × 200 px that begins at (64, 30)."""
    return {
        "data": [
            style.lines([0, 5, None, 5, 10], [0, 10, None, 0, 0], "#112233", 2),
            style.dots([5], [5], ["middle"], color="#445566", symbol="diamond-open"),
        ],
        "layout": style.layout(
            480, 282, xaxis=style.axis("s (mm)", 0, 10, 5), yaxis=style.axis("e (µm)", 0, 10, 5) | axis
        ),
    }


def paths(picture: ET.Element, colour: str) -> list[str]:
    return [path.get("d", "") for path in picture.iter(f"{SVG}path") if path.get("stroke") == colour]


def test_lines_break_where_the_specification_says_and_stand_where_the_axes_say() -> None:
    picture = ET.fromstring(svg(simple(), "simple"))
    assert paths(picture, "#112233") == ["M64.00 230.00L264.00 30.00", "M264.00 230.00L464.00 230.00"]


def test_an_open_marker_is_white_inside() -> None:
    (diamond,) = (p for p in ET.fromstring(svg(simple(), "s")).iter(f"{SVG}path") if p.get("stroke") == "#445566")
    assert diamond.get("fill") == "#ffffff"


def test_equal_scale_shrinks_the_longer_side() -> None:
    """Ten units high are 200 px, so ten units along are 200 px too, in the middle of the 400."""
    picture = ET.fromstring(svg(simple(scaleanchor="x"), "simple"))
    assert paths(picture, "#112233")[0] == "M164.00 230.00L264.00 30.00"


def test_axes_are_named_with_their_units_and_ticks_are_round() -> None:
    words = ["".join(text.itertext()) for text in ET.fromstring(svg(simple(), "simple")).iter(f"{SVG}text")]
    assert {"s (mm)", "e (µm)", "2", "10"} <= set(words)


@pytest.mark.parametrize("part", ["modbas2", "piecs11", "facetst"])
def test_every_figure_of_a_report_becomes_well_formed_svg_with_its_points(part: str) -> None:
    for figure in figures(example_correction(part)):
        picture = ET.fromstring(svg(figure, "figure"))
        circles = sum(
            len(trace["x"])
            for trace in figure["data"]
            if trace["mode"] == "markers" and trace["marker"].get("symbol", "circle") == "circle"
        )
        assert len(list(picture.iter(f"{SVG}circle"))) == circles
        assert not re.search(r"nan|inf", ET.tostring(picture, encoding="unicode"))
