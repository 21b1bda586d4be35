"""The page of a surface's pattern in a real browser, without a network."""

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.support.chromium import console_errors, dump_dom
from trueloop.loops.surface import SurfaceModel, correct, model_of, pattern_model
from trueloop.loops.surface_inputs import read_surface_inputs
from trueloop.report.style import LEFT_ON, TAKEN
from trueloop.report.surface_maps import colour, colour_range_um, flat
from trueloop.report.surface_page import maps, maps_picture, surface_page

EXAMPLE = Path(__file__).parents[2] / "examples" / "surface" / "surface.toml"


@pytest.fixture(scope="module")
def model() -> SurfaceModel:
    inputs = read_surface_inputs(EXAMPLE)
    return pattern_model(inputs.surface, model_of(inputs.surface, inputs.parts, inputs.options), inputs.options)


@pytest.fixture(scope="module")
def page(model: SurfaceModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("surface") / "pattern.html"
    file.write_text(surface_page("Wave", model, correct(model)), encoding="utf-8")
    return file


def test_every_map_is_drawn_and_the_console_stays_silent(page: Path, model: SurfaceModel) -> None:
    dom = dump_dom(page)
    assert dom.count('class="plot js-plotly-plot"') == 1
    assert len(re.findall(r'<figure id="[a-z]+" class="small map"><svg', dom)) == len(maps(model)) == 6
    hints = ("WebGL", "GPU", "Canvas2D")  # what the browser says of its own drawing, where there is no graphics card
    assert [line for line in console_errors(page) if not any(hint in line for hint in hints)] == []


def test_red_is_material_left_on_and_one_scale_serves_all_maps(model: SurfaceModel) -> None:
    assert colour(10.0, 10.0) == LEFT_ON
    assert colour(-10.0, 10.0) == TAKEN
    assert colour(0.0, 10.0) == "#ffffff"
    assert colour(float("nan"), 10.0) == "#c8ced4"
    shown = maps(model)
    reach = colour_range_um(shown)
    assert reach >= max(1000 * abs(m.error_mm).max() for m in shown) > 0.7 * reach
    assert all(f"{reach:.1f} µm" in flat(m, reach) for m in shown)


def test_scattered_parts_are_drawn_as_dots_flat_and_in_space(tmp_path: Path) -> None:
    """Points without row and column: the maps show each where it is."""
    inputs = read_surface_inputs(EXAMPLE)
    scattered = [replace(part, points_mm=part.points_mm[::3], shape=None) for part in inputs.parts[:3]]
    options = replace(inputs.options, best_fit=False)
    found = pattern_model(inputs.surface, model_of(inputs.surface, scattered, options), options)
    file = tmp_path / "pattern.html"
    file.write_text(surface_page("Dots", found), encoding="utf-8")
    dom = dump_dom(file)
    assert dom.count("<circle") >= 5 * 209
    assert dom.count('"type":"scatter3d"') == 5
    assert dom.count('class="plot js-plotly-plot"') == 1


def test_the_sheet_of_maps_is_a_picture_of_its_own(model: SurfaceModel) -> None:
    sheet = ElementTree.fromstring(maps_picture(model))
    titles = [text.text for text in sheet.iter("{http://www.w3.org/2000/svg}text") if text.get("font-weight") == "bold"]
    assert titles == [shown.title for shown in maps(model)]
    predicted, measured = maps(model)[-1], maps(model)[0]
    assert predicted.error_mm.std() < 0.6 * measured.error_mm.std()


def test_every_part_stands_in_the_table(page: Path, model: SurfaceModel) -> None:
    text = page.read_text(encoding="utf-8")
    assert all(f"<td>{part.deviations.name}</td>" in text for part in model.parts)
    assert "best fit: form alone" in text
