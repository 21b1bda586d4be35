"""The part with whiskers: right points, right way, right colour, equal scale."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from plotly.graph_objects import Figure as PlotlyFigure

from tests.support.correction import example_correction
from trueloop.loops.turned.correction import Correction
from trueloop.report.style import LEFT_ON, TAKEN, Figure, Trace
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures import whiskers
from trueloop.report.turned.figures.part_drawing import round_down
from trueloop.turned.compensation.targets import Prediction
from trueloop.turned.error_curve.curve import Budget

MODBAS2 = example_correction("modbas2")


def strokes(figure: Figure, name: str) -> list[tuple[float, ...]]:
    """The whiskers of one colour and half as (z, x) of foot and tip."""
    (trace,) = (trace for trace in figure["data"] if trace.get("name") == name)
    z, x = trace["x"], trace["y"]
    return [(z[k], x[k], z[k + 1], x[k + 1]) for k in range(0, len(z), 3)]


def traces_in(figure: Figure, colour: str) -> list[Trace]:
    return [trace for trace in figure["data"] if trace.get("line", {}).get("color") == colour]


@pytest.mark.parametrize("draw", [whiskers.before_and_after, whiskers.after_enlarged])
@pytest.mark.parametrize("part", ["modbas2", "piecs11", "facetst"])
def test_plotly_accepts_the_specification(part: str, draw: Callable[[Correction], Figure]) -> None:
    PlotlyFigure(draw(example_correction(part)))  # raises on a property it does not know


def test_a_whisker_on_a_cylinder_points_along_x_by_error_times_magnification() -> None:
    """Point 6 of [6517] Table 1: x 44.704 mm, z −106.934 mm, error +12.446 µm, drawn 200 times as large."""
    figure = whiskers.before_and_after(MODBAS2)
    assert figure["layout"]["meta"]["magnification"] == 200
    drawn = strokes(figure, "material left on, Before: measured")
    assert drawn[5] == pytest.approx((-106.934, 44.704, -106.934, 44.704 + 2.4892), abs=1e-6)


def test_a_whisker_on_the_cone_points_along_its_normal() -> None:
    """The cone runs from (2.66, −6.135) to (1.76, −4.51) in: its normal is (1.625, 0.9) / 1.857585."""
    tip = whiskers.tips_mm(MODBAS2, MODBAS2.touches.error_mm, 200.0)[0]
    length = math.hypot(1.625, 0.9)
    expected = (63.87211 + 18.0594 * 1.625 / length, -149.1631 + 18.0594 * 0.9 / length)
    assert tip == pytest.approx(expected, abs=1e-5)


def test_too_much_taken_points_into_the_material_in_blue() -> None:
    """Point 32 alone is negative, −18.733 µm near the apex."""
    figure = whiskers.before_and_after(MODBAS2)
    ((foot_z, _, tip_z, _),) = strokes(figure, "too much taken, Before: measured")
    assert tip_z - foot_z == pytest.approx(-0.018733 * 200, rel=0.01)
    (blue,) = (t for t in traces_in(figure, TAKEN) if t["name"].endswith("Before: measured"))
    assert len(blue["x"]) == 3
    assert all(t["name"].startswith("material left on") for t in traces_in(figure, LEFT_ON))


def test_below_the_axis_stands_the_prediction_mirrored_at_the_same_magnification() -> None:
    figure = whiskers.before_and_after(MODBAS2)
    drawn = [s for kind in ("material left on", "too much taken") for s in strokes(figure, f"{kind}, After: predicted")]
    after = MODBAS2.prediction.after_mm
    written = np.abs(after) >= 5e-5
    assert len(drawn) == np.count_nonzero(written)
    lengths = sorted(math.dist(s[:2], s[2:]) for s in drawn)
    assert lengths == pytest.approx(sorted(200 * np.abs(after[written])), rel=1e-9)
    assert all(foot_x < 0 for _, foot_x, _, _ in drawn)


def test_both_axes_have_the_same_scale() -> None:
    layout = whiskers.before_and_after(MODBAS2)["layout"]
    assert (layout["yaxis"]["scaleanchor"], layout["yaxis"]["scaleratio"]) == ("x", 1)


@pytest.mark.parametrize("part", ["modbas2", "piecs11", "facetst"])
def test_everything_drawn_lies_within_the_axes(part: str) -> None:
    figure = whiskers.before_and_after(example_correction(part))
    for axis, key in (("xaxis", "x"), ("yaxis", "y")):
        low, high = figure["layout"][axis]["range"]
        seen = [value for trace in figure["data"] for value in trace[key] if value is not None]
        assert low <= min(seen) <= max(seen) <= high


def test_pointing_at_a_tip_tells_point_error_and_uncertainty() -> None:
    figure = whiskers.before_and_after(MODBAS2)
    texts = [text for trace in figure["data"] for text in trace.get("hovertext", [])]
    assert len(texts) == 2 * 32
    (first,) = (text for text in texts if "point 6<br>measured" in text)
    assert "main-cylinder" in first
    assert "+12.4 ± 0.8 µm (95 %)" in first  # 1.96 × 1.5 µm/√12


def test_the_enlarged_prediction_shows_each_expanded_uncertainty() -> None:
    figure = whiskers.after_enlarged(MODBAS2)
    magnified = figure["layout"]["meta"]["magnification"]
    lengths = [math.dist(s[:2], s[2:]) for s in strokes(figure, "±U")]
    assert lengths == pytest.approx(2 * magnified * MODBAS2.prediction.expanded_u_mm, rel=1e-9)


def test_every_touch_is_named_where_there_is_room_and_the_worst_always() -> None:
    figure = whiskers.before_and_after(MODBAS2)
    above, below = (trace["text"] for trace in figure["data"] if trace["mode"] == "text")
    assert "4" in above  # 94.2 µm
    worst = MODBAS2.touches.point[int(np.argmax(np.abs(MODBAS2.prediction.after_mm)))]
    assert worst in below
    assert len(set(above)) == len(above) > 20


def test_a_part_without_error_is_not_blown_up_without_end() -> None:
    zero = np.zeros(32)
    perfect = replace(
        MODBAS2, prediction=Prediction(zero, zero, zero, Budget(zero, zero, zero, zero, zero, zero, None))
    )
    figure = whiskers.before_and_after(perfect)
    assert figure["layout"]["meta"]["magnification"] <= 1e6
    assert not traces_in(figure, LEFT_ON)


@pytest.mark.parametrize(("value", "rounded"), [(199.9, 100), (200, 200), (499, 200), (0.07, 0.05), (1, 1)])
def test_magnifications_and_bars_are_round(value: float, rounded: float) -> None:
    assert round_down(value) == pytest.approx(rounded, rel=1e-12)


@pytest.mark.parametrize("width", [whiskers.WIDTH, whiskers.NARROW])
def test_a_radius_has_no_sign_below_the_axis(width: int) -> None:
    axis = whiskers.before_and_after(MODBAS2, width)["layout"]["yaxis"]
    assert min(axis["tickvals"]) < 0
    assert [float(text) for text in axis["ticktext"]] == [abs(value) for value in axis["tickvals"]]


def test_in_inches_the_drawing_is_the_same_in_another_unit() -> None:
    """Point 6 again: 12.446 µm are 490 µin, 106.934 mm are 4.21 in."""
    figure = whiskers.before_and_after(MODBAS2, say=Texts("en", "inch"))
    drawn = strokes(figure, "material left on, Before: measured")[5]
    assert drawn == pytest.approx((-4.21, 1.76, -4.21, 1.76 + 2.4892 / 25.4), abs=1e-6)
    hover = [text for trace in figure["data"] for text in trace.get("hovertext", []) if "point 6<br>measured" in text]
    assert "+490 ± 33 µin (95 %)" in hover[0] and "x 1.7600 in, z −4.2100 in" in hover[0]
    low, high = figure["layout"]["xaxis"]["range"]
    assert low < -149.2 / 25.4 and high > 0


@pytest.mark.parametrize("width", [whiskers.WIDTH, whiskers.NARROW])
@pytest.mark.parametrize("part", ["modbas2", "piecs11", "facetst"])
def test_names_of_features_do_not_overlap(part: str, width: int) -> None:
    layout = whiskers.before_and_after(example_correction(part), width)["layout"]
    px = (width - whiskers.FRAME[0]) / (layout["xaxis"]["range"][1] - layout["xaxis"]["range"][0])
    names = [note for note in layout["annotations"] if note["text"] in example_correction(part).profile.names]
    boxes = [(n["x"] * px, n["y"] * px, 6.0 * len(n["text"]), n["xanchor"]) for n in names]
    for i, (x, y, long, anchor) in enumerate(boxes):
        for x2, y2, long2, anchor2 in boxes[:i]:
            middle = x - long / 2 * (anchor == "right"), x2 - long2 / 2 * (anchor2 == "right")
            assert abs(y - y2) > 13 or abs(middle[0] - middle[1]) > (long + long2) / 2
