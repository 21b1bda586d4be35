"""The error curve of a feature: touches, band, knots and ends where they belong."""

from dataclasses import replace

import numpy as np
import pytest
from plotly.graph_objects import Figure as PlotlyFigure

from tests.support.correction import example_correction, example_inputs
from trueloop.domain.option import Limits
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.style import Figure, Trace
from trueloop.report.turned.figures.curves import error_curve
from trueloop.turned.fit.chain_fit import TangentPolicy

MODBAS2 = example_correction("modbas2")
DOME = MODBAS2.profile.names.index("dome")
CONE = MODBAS2.profile.names.index("cone")


def named(figure: Figure, name: str) -> Trace:
    found: list[Trace] = [trace for trace in figure["data"] if trace.get("name") == name]
    (trace,) = found
    return trace


@pytest.mark.parametrize("index", [CONE, DOME])
def test_plotly_accepts_the_specification(index: int) -> None:
    PlotlyFigure(error_curve(MODBAS2, index))


def test_touches_stand_at_their_arc_length_with_the_uncertainty_of_gauging() -> None:
    """The dome's touches begin 2.54 mm after its start with +21.717 µm [6517 Table 1]; U = 1.96 × 0.43 µm there."""
    touches = named(error_curve(MODBAS2, DOME), "touches")
    assert len(touches["x"]) == 20
    assert (touches["x"][0], touches["y"][0]) == pytest.approx((2.54, 21.717), abs=1e-3)
    assert touches["error_y"]["array"][0] == pytest.approx(1.96 * 1.5 / np.sqrt(12), rel=0.01)


def test_the_band_surrounds_the_curve_and_widens_where_no_touch_holds_it() -> None:
    figure = error_curve(MODBAS2, DOME)
    fit, band = named(figure, "fitted curve"), named(figure, "95 % band")
    n = len(fit["x"])
    upper, lower = np.array(band["y"][:n]), np.array(band["y"][n:][::-1])
    assert (upper + lower) / 2 == pytest.approx(np.array(fit["y"]), abs=1e-9)
    half = (upper - lower) / 2
    assert np.all(half > 0)
    assert half[-1] > 2 * half[n // 2]


def test_knots_and_prescribed_ends_are_marked() -> None:
    figure = error_curve(MODBAS2, DOME)
    curve = MODBAS2.model.curves[DOME]
    assert named(figure, "knots")["x"] == pytest.approx(curve.knots_mm.tolist())
    end = named(figure, "end condition")
    assert end["x"] == [0.0]
    assert curve.conditions.start_value_mm is not None
    assert end["y"][0] == pytest.approx(curve.conditions.start_value_mm * 1000, abs=1e-9)
    assert figure["layout"]["annotations"][0]["text"] == "value prescribed"
    assert not [t for t in error_curve(MODBAS2, CONE)["data"] if t.get("name") in ("knots", "end condition")]


def test_the_policy_path_prescribes_the_slope_too() -> None:
    inputs = example_inputs("modbas2")
    options = replace(inputs.options, junctions=TangentPolicy.PATH, limits=Limits(slope=0.05))
    path = compensate(replace(inputs, options=options))
    assert error_curve(path, DOME)["layout"]["annotations"][0]["text"] == "value and slope prescribed"


def test_the_lower_panel_shows_what_is_left_and_what_leaving_out_gives() -> None:
    figure = error_curve(MODBAS2, DOME)
    rows = MODBAS2.touches.of_feature(DOME)
    after, left_out = named(figure, "predicted after"), named(figure, "left out of the fit")
    assert {after["yaxis"], left_out["yaxis"]} == {"y2"}
    assert after["y"] == pytest.approx(MODBAS2.prediction.after_mm[rows] * 1000)
    assert left_out["y"] == pytest.approx(MODBAS2.prediction.leave_one_out_mm[rows] * 1000)


@pytest.mark.parametrize("index", [CONE, DOME])
def test_everything_drawn_lies_within_the_axes(index: int) -> None:
    figure = error_curve(MODBAS2, index)
    for trace in figure["data"]:
        low, high = figure["layout"][trace.get("yaxis", "y").replace("y", "yaxis")]["range"]
        assert low <= min(trace["y"]) <= max(trace["y"]) <= high
