"""Diagnoses as values and figures: units, means, arrows of [6876 Fig. 12–15] with signs, lines of a terminal."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support import diagnosis
from trueloop.diagnosis.causes.cause import SeenBy, SeenPart
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, SeenPoints
from trueloop.report.diagnosis import lines
from trueloop.report.diagnosis.causes import credible, share
from trueloop.report.diagnosis.figures import surface_figure, surfaces_um, vectors_um
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape
from trueloop.report.diagnosis.page_machine import binned, residual_figures, without_set_up
from trueloop.report.diagnosis.page_part import points_section
from trueloop.report.diagnosis.shapes import HypothesisShape, PointShape, SeriesDiagnosisShape
from trueloop.report.diagnosis.values import means_of, points_of, series_shape
from trueloop.report.style import LEFT_ON, TAKEN
from trueloop.report.texts.texts import Texts


def _part(serial: str, machine_mm: float, cmm_mm: float, standard: bool = False) -> SeenPart:
    errors = {
        device: (FeatureError("journal", ErrorKind.RADIUS, value, u, 4),)
        for device, value, u in ((SeenBy.MACHINE, machine_mm, 3e-4), (SeenBy.CMM, cmm_mm, 4e-4))
    }
    return SeenPart(serial, 0, errors, standard=standard)


def test_means_are_over_cut_parts_and_the_difference_is_cmm_less_machine() -> None:
    parts = [_part("A", 0.010, 0.013), _part("B", 0.014, 0.015), _part("S", 1.0, 2.0, standard=True)]
    (found,) = means_of(parts)
    assert found.machine is not None and found.cmm is not None and found.difference is not None
    assert (found.machine.mean_um, found.cmm.mean_um, found.difference.mean_um) == (12.0, 14.0, 2.0)
    assert found.difference.parts == 2
    assert found.machine.scatter_um == pytest.approx(np.std([10.0, 14.0], ddof=1), abs=1e-4)
    assert found.machine.standard_u_um == pytest.approx(2.0, abs=1e-4)
    (alone,) = means_of(parts[:1])
    assert alone.difference is not None and alone.difference.standard_u_um == 0.5  # 3, 4 and 5
    assert alone.difference.scatter_um is None


def _points(errors_um: Mapping[str, list[float]], z_mm: list[float]) -> SeenPoints:
    names = tuple(name for name, errors in errors_um.items() for _ in errors)
    error = 1e-3 * np.concatenate([*errors_um.values()])
    n = len(error)
    at, normal = np.column_stack([np.full(n, 20.0), z_mm]), np.tile([1.0, 0.0], (n, 1))
    return SeenPoints(names, at, normal, error, np.full(n, 1e-3), np.full(n, np.nan), np.ones(n, dtype=np.intp))


def test_gauging_points_have_mean_and_standard_deviation_over_cut_parts() -> None:
    """Points 1 and 2 of [6811 Table 11] on three parts: −2, 3, 3 and −5, 1, 0; the second was read twice on A."""
    rows = {"A": ([-2.0, -4.0, -6.0], [-5.0, -30.0, -30.0]), "B": ([3.0, 1.0], [-5.0, -30.0])}
    parts = [
        SeenPart(serial, k, {}, {SeenBy.MACHINE: _points({"cone": errors}, z)})
        for k, (serial, (errors, z)) in enumerate(rows.items())
    ]
    parts.append(SeenPart("C", 2, {}, {SeenBy.CMM: _points({"cone": [3.0, 0.0]}, [-5.0, -30.0])}))
    parts.append(SeenPart("S", 3, {}, {SeenBy.CMM: _points({"cone": [90.0]}, [-5.0])}, standard=True))
    first, second = points_of(parts)
    assert (first.feature, first.x_mm, first.z_mm, second.z_mm) == ("cone", 20.0, -5.0, -30.0)
    assert (first.machine_um, first.cmm_um) == ({"A": -2.0, "B": 3.0}, {"C": 3.0})
    assert second.machine_um == {"A": -5.0, "B": 1.0}
    assert first.machine is not None and second.machine is not None and first.cmm is not None
    assert (first.machine.mean_um, second.machine.mean_um) == (0.5, -2.0)
    assert first.machine.scatter_um == pytest.approx(5.0 / math.sqrt(2.0), abs=1e-3)
    assert second.machine.one_part_u_um == pytest.approx(math.sqrt((0.5 + 1.0) / 2.0), abs=1e-3)
    assert (first.cmm.parts, first.cmm.scatter_um) == (1, None)
    page = points_section([first, second], Texts())
    assert ">+0.5<" in page and ">3.5<" in page and points_section([], Texts()) == ""


def test_what_no_probable_cause_acts_on_is_named_by_its_mean_or_its_scatter() -> None:
    series = diagnosis.seen_series()
    alone = series_shape("SHAFT", series, diagnosis.sound()).unexplained
    assert (alone[0].feature, alone[0].shows, alone[0].size_um) == ("end", "mean", -4.0)
    assert {(one.feature, one.device, one.shows) for one in alone[1:]} >= {("journal 0", "machine", "scatter")}
    explained = series_shape("SHAFT", series, diagnosis.guilty()).unexplained
    assert {one.feature for one in explained} == {"end"}
    assert series_shape("SHAFT", diagnosis.sound_series(), diagnosis.sound()).unexplained == []


def test_a_tool_is_set_where_its_count_rises_and_not_on_the_first_part() -> None:
    shape = series_shape("SHAFT", diagnosis.seen_series(), None)
    assert [part.serial for part in shape.parts if part.tool_set] == ["P6"]


def test_json_gives_the_shape_back() -> None:
    shape = series_shape("SHAFT", diagnosis.seen_series(), diagnosis.guilty())
    assert SeriesDiagnosisShape.model_validate_json(shape.model_dump_json()) == shape
    first = json.loads(shape.model_dump_json())["causes"]["candidates"][0]
    assert first["supports"] == ["+12.0 µm (on the radius)"] and first["size_um"] == 11.8
    machine = diagnosis.machine()
    assert MachineDiagnosisShape.model_validate_json(machine.model_dump_json()) == machine


def test_surfaces_and_vectors_close_as_the_report_says() -> None:
    """[6876 §3.5]: ERROR_PP is the sum of the residuals; each compensation leaves its residual."""
    point = diagnosis.point()
    surfaces, vectors = surfaces_um(point), vectors_um(point)
    length = {name: end - start for name, (start, end) in vectors.items()}
    assert length["ERROR_PP"] == length["ERROR_MTG,RESID"] + length["ERROR_PROC,RESID"] == 7.0
    assert length["COMP_MTG"] == -length["ERROR_MTG"] + length["ERROR_MTG,RESID"] == -10.0
    assert length["COMP_PROC"] == -length["ERROR_PROC"] + length["ERROR_PROC,RESID"] == 15.0
    assert length["COMP_MTG + PROC"] == 5.0
    assert surfaces["detected surface"] - surfaces["uncompensated surface"] == 5.0
    assert surfaces["uncompensated surface"] == length["ERROR_MTG"] + length["ERROR_PROC"] == 2.0
    assert surfaces["GT compensated surface"] == vectors["ERROR_PROC"][1] == -8.0
    assert {start for start, _ in vectors.values()} | {end for _, end in vectors.values()} == set(surfaces.values())


def _heads(point: PointShape) -> Mapping[float, tuple[str, str]]:
    """Of the arrows, by row from below: where the head points, and its colour."""
    found: dict[float, tuple[str, str]] = {}
    for trace in surface_figure(point)["data"]:
        marker: dict[str, Any] = trace.get("marker", {})
        if marker.get("symbol", "").startswith("triangle"):
            found[trace["y"][0]] = (marker["symbol"].removeprefix("triangle-"), marker["color"])
    return found


def test_red_points_away_from_the_material_and_is_left_on_blue_the_other_way() -> None:
    heads = _heads(diagnosis.point())
    assert heads[8.0] == ("right", LEFT_ON)  # ERROR_PP = +7, first of eight vectors
    assert heads[4.0] == ("left", TAKEN)  # ERROR_PROC = −11
    assert heads[6.0][0] == "left" and heads[3.0][0] == "right"  # COMP_MTG = −10, COMP_PROC = +15


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=9))
def test_credible_sets_are_the_fewest_with_the_probability(weights: list[float]) -> None:
    whole = sum(weights) or 1.0
    sets = [HypothesisShape(causes=[str(k)], probability=weight / whole) for k, weight in enumerate(weights)]
    found = credible(sets)
    if len(found) < len(sets):
        assert sum(one.probability for one in found) >= 0.95
    assert sum(one.probability for one in found[:-1]) < 0.95


def test_probabilities_are_never_said_to_be_none_or_certain() -> None:
    assert [share(p) for p in (0.0, 0.0004, 0.0006, 0.5, 0.9994, 0.9999)] == [
        "< 0.05 %", "< 0.05 %", "0.1 %", "50.0 %", "99.9 %", "> 99.95 %",
    ]  # fmt: skip
    assert share(0.123, Texts("de")) == "12,3 %"


def test_residuals_lose_their_parts_mean_and_halves_are_by_temperature() -> None:
    machine = diagnosis.machine()
    values = without_set_up(machine)
    for serial in {one.part for one in machine.residuals}:
        of_it = [v for v, one in zip(values, machine.residuals, strict=True) if one.part == serial]
        assert np.mean(of_it) == pytest.approx(0.0, abs=1e-9)
    figures = residual_figures(machine)
    assert list(figures) == ["position of Z (mm)", "temperature T_carriage (°C)"], "X does not vary"
    cold, warm = figures["position of Z (mm)"]["data"][2:]
    assert cold["line"]["color"] == TAKEN and warm["line"]["color"] == LEFT_ON
    assert cold["y"][-1] < cold["y"][0] and warm["y"][-1] > warm["y"][0], "longer with warmth, as simulated"


@given(st.lists(st.tuples(st.integers(0, 5), st.floats(-9, 9)), min_size=1, max_size=60))
def test_binned_means_keep_the_mean_and_the_range(pairs: list[tuple[int, float]]) -> None:
    at, values = np.array([float(a) for a, _ in pairs]), np.array([v for _, v in pairs])
    middles, means = binned(at, values)
    assert middles == sorted(middles) and min(at) <= middles[0] and middles[-1] <= max(at)
    assert min(values) - 1e-9 <= min(means) and max(means) <= max(values) + 1e-9


def test_lines_say_the_verdict_causes_and_sets() -> None:
    series = list(lines.series_lines(series_shape("SHAFT", diagnosis.seen_series(), diagnosis.guilty())))
    assert series[0] == "SHAFT: 12 parts"
    assert "cause: tool offset, probability 95.5 %" in series
    assert "  96.2 %  tool offset on journal 0, journal 1, journal 2, +11.8 µm ± 1.2 (95 %)" in series
    torn = list(lines.series_lines(series_shape("SHAFT", diagnosis.seen_series(), diagnosis.torn())))
    assert any(line.startswith("one of 2 answers: tool offset; part-probe offset") for line in torn)
    machine = list(lines.machine_lines(diagnosis.machine()))
    assert "  97.3 %  1 of EXZ (with T_carriage, 50.0 %), EBZ (with T_carriage, 50.0 %)" in machine
    fixture = list(lines.fixture_lines(diagnosis.fixtures()))
    assert "part: UNSTABLE" in fixture[0] and "step +8.0 ± 0.6* after repeat 4" in fixture[0]
