"""The page of a surface's pattern in a real browser, without a network."""

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.support.chromium import console_errors, dump_dom
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.surface.surface import SurfaceModel, correct, maps_of, model_of, pattern_model
from trueloop.report.style import LEFT_ON, TAKEN
from trueloop.report.surface.maps import DeviationMap, caption, colour, colour_range_um, flat, maps_of_part, rgb
from trueloop.report.surface.page import maps, maps_picture, surface_page

EXAMPLE = Path(__file__).parents[2] / "examples" / "surface" / "surface.toml"


@pytest.fixture(scope="module")
def model() -> SurfaceModel:
    inputs = read_surface(EXAMPLE).inputs
    return pattern_model(inputs.surface, model_of(inputs.surface, inputs.parts, inputs.options), inputs.options)


@pytest.fixture(scope="module")
def page(model: SurfaceModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("surface") / "pattern.html"
    file.write_text(surface_page("Wave", model, correct(model)), encoding="utf-8")
    return file


def test_every_map_is_drawn_and_the_console_stays_silent(page: Path, model: SurfaceModel) -> None:
    dom = dump_dom(page)
    assert dom.count("<canvas") == 1
    assert len(re.findall(r'<figure id="[a-z]+" class="small map"><svg', dom)) == len(maps(model)) == 7
    assert console_errors(page) == []


def test_the_page_says_beside_the_prediction_what_the_band_does_not_cover(page: Path) -> None:
    """With the shares that the docs state of the simulated mill."""
    header = page.read_text(encoding="utf-8").split("</header>")[0]
    (note,) = re.findall(r"<p class='note'>([^<]*does not cover the ridges[^<]*)</p>", header)
    shares = re.findall(r"\d\d to \d\d %", note)
    ridges = (EXAMPLE.parents[2] / "docs" / "surface.md").read_text(encoding="utf-8").split("### Ridges")[1]
    assert len(shares) == 2
    assert re.findall(r"\d\d to \d\d %", ridges) == shares


def test_the_prediction_states_the_share_of_the_pattern_that_a_weight_leaves(model: SurfaceModel) -> None:
    """A quarter of the pattern's largest value with weight 0.75; none with weight 1."""
    quarter = replace(model, options=replace(model.options, weight=0.75))
    left = f"keeps {250 * model.figures.largest_mm:.1f} µm of it at most (weight 0.75), and ± "
    assert left in surface_page("Wave", quarter)
    assert "corrected by it keeps ± " in surface_page("Wave", model)


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
    inputs = read_surface(EXAMPLE).inputs
    scattered = [replace(part, points_mm=part.points_mm[::3], shape=None) for part in inputs.parts[:3]]
    options = replace(inputs.options, best_fit=False)
    found = pattern_model(inputs.surface, model_of(inputs.surface, scattered, options), options)
    file = tmp_path / "pattern.html"
    file.write_text(surface_page("Dots", found), encoding="utf-8")
    dom = dump_dom(file)
    assert dom.count("<circle") >= 5 * 209
    assert dom.count('"rows":0') == 1 and dom.count('"rows":50') == 1  # the parts' own places, and the pattern's grid


COUNT = """<script>
const list = document.querySelector("#space select");
const pen = document.querySelector("#space canvas").getContext("2d");
for (const option of list.options) {
  list.value = option.value;
  list.dispatchEvent(new Event("change"));
  const { data } = pen.getImageData(0, 0, pen.canvas.width, pen.canvas.height);
  let [red, blue] = [0, 0];
  for (let i = 0; i < data.length; i += 4) {
    red += data[i] > data[i + 2] + 20;
    blue += data[i + 2] > data[i] + 20;
  }
  document.body.dataset[option.value] = `${red} ${blue}`;
}
</script></body>"""


def test_the_surface_in_space_is_red_where_material_is_left_on(page: Path, model: SurfaceModel, tmp_path: Path) -> None:
    """Area for area: about as much of the drawing is red and blue as of the map that was chosen."""
    counted = tmp_path / "counted.html"
    counted.write_text(page.read_text(encoding="utf-8").replace("</body>", COUNT), encoding="utf-8")
    body = re.search(r"<body ([^>]*)>", dump_dom(counted))
    assert body is not None
    found = dict(re.findall(r'data-(\w+)="(\d+ \d+)"', body[1]))
    for shown in maps(model):
        if shown.name in ("variability", "random", "predicted", "uncertainty"):
            continue  # too pale, or in cells too small for an area
        red, blue = (int(number) for number in found[shown.name].split())
        level = 0.1 * colour_range_um(maps(model)) / 1000
        expected = (shown.error_mm > level).sum() / (np.abs(shown.error_mm) > level).sum()
        assert red / (red + blue) == pytest.approx(expected, abs=0.08), shown.name


def chosen(page: Path, part: int, to: Path) -> str:
    """The page after somebody chose a part."""
    pick = f'const s = document.querySelector("#choice select"); s.selectedIndex = {part}; '
    pick += 's.dispatchEvent(new Event("change"));'
    to.write_text(
        page.read_text(encoding="utf-8").replace("</body>", f"<script>{pick}</script></body>"), encoding="utf-8"
    )
    assert console_errors(to) == []
    return dump_dom(to)


def fills(dom: str, name: str) -> list[str]:
    """Colours of a flat map's marks, as the page has them: #rrggbb, or rgb(r,g,b) where its script painted them."""
    (marks,) = re.findall(rf'<figure id="{name}".*?<g class="marks">(.*?)</g>', dom, re.DOTALL)
    return [_hex(fill) for fill in re.findall(r'fill="([^"]*)"', marks)]


def _hex(fill: str) -> str:
    return "#" + "".join(f"{int(n):02x}" for n in re.findall(r"\d+", fill)) if fill.startswith("rgb") else fill


def near(one: list[str], other: list[str]) -> bool:
    """To one step of a colour: the page's numbers are rounded to 0.01 µm."""
    pairs = zip(map(rgb, one), map(rgb, other), strict=True)
    return all(abs(a - b) <= 1 for left, right in pairs for a, b in zip(left, right, strict=True))


def test_the_part_that_is_chosen_is_shown_in_the_colours_of_its_own_errors(
    page: Path, model: SurfaceModel, tmp_path: Path
) -> None:
    dom, shown = chosen(page, 3, tmp_path / "chosen.html"), [own for own, _ in maps_of(model)]
    reach = colour_range_um([*maps(model), *(m for own in shown for m in maps_of_part(model, own))])
    for own in maps_of_part(model, shown[3]):
        wanted = [colour(1000 * error, reach) for error in own.error_mm.ravel()]
        assert near(fills(dom, own.name), wanted)
        assert caption(own) in dom
    assert not near(fills(dom, "measured"), fills(page.read_text(encoding="utf-8"), "measured"))
    assert fills(dom, "pattern") == fills(page.read_text(encoding="utf-8"), "pattern")
    assert dom.count("S04: measured") >= 2  # the caption, and the list of maps in space


def test_scattered_parts_move_with_their_places(tmp_path: Path) -> None:
    inputs = read_surface(EXAMPLE).inputs
    some = [replace(p, points_mm=p.points_mm[k :: 3 + k % 2], shape=None) for k, p in enumerate(inputs.parts[:3])]
    options = replace(inputs.options, best_fit=False)
    found = pattern_model(inputs.surface, model_of(inputs.surface, some, options), options)
    (tmp_path / "page.html").write_text(surface_page("Dots", found), encoding="utf-8")
    dom = chosen(tmp_path / "page.html", 1, tmp_path / "chosen.html")
    wanted = maps_of_part(found, maps_of(found)[1][0])[0]
    assert len(fills(dom, "measured")) == len(wanted.error_mm) != len(some[0].points_mm)
    (u, _), frame = wanted.uv[7], flat(wanted, 10.0)
    (high,) = map(float, re.findall(r'class="frame".*? height="([\d.]+)"', frame))
    (marks,) = re.findall(r'<figure id="measured".*?<g class="marks">(.*?)</g>', dom, re.DOTALL)
    assert [float(cy) for cy in re.findall(r'cy="([\d.]+)"', marks)][7] == pytest.approx(8 + (1 - u) * high, abs=0.02)


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


def test_sides_of_a_map_are_named_by_the_coordinates_of_the_part() -> None:
    """By hand: x runs up from 10 to 60 mm, y to the right from 40 down to 10 mm; turned by 45°, both have a share."""
    u, v = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 7), indexing="ij")
    flat_mm, uv = np.stack([10 + 50 * u, 40 - 30 * v, 0.3 * u * v], axis=2), np.stack([u, v], axis=2)
    assert DeviationMap("m", "m", flat_mm, uv, 0 * u).axis_words == ("x 10.0 → 60.0 mm", "y 40.0 → 10.0 mm")
    turned = np.stack([flat_mm[..., 0] - flat_mm[..., 1], flat_mm[..., 0] + flat_mm[..., 1], 0 * u], axis=2) * 0.5**0.5
    drawn = flat(DeviationMap("m", "m", turned, uv, 0 * u), 1.0)
    assert "along (x 0.71, y 0.71, z 0.00) → 50.0 mm" in drawn
    assert "along (x 0.71, y -0.71, z 0.00) → 30.0 mm" in drawn.replace("−", "-")
