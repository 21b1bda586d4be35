"""Pictures of what a drawing or a solid offers: `trueloop part from-dxf|from-step --picture`."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.solids import revolved, written
from tests.unit.formats.test_dxf_sheet import BORE, OUTSIDE, SHAFT, Sheet
from trueloop.arrays import Array

SVG = "{http://www.w3.org/2000/svg}"


def drawn(file: Path, width: str) -> list[Array]:
    """The places of all coloured lines so wide."""
    lines = [one for one in ElementTree.parse(file).iter(f"{SVG}polyline") if one.get("stroke-width") == width]
    return [np.array([pair.split(",") for pair in str(one.get("points")).split()], dtype=float) for one in lines]


def like(places: Array, contour: list[tuple[float, float]]) -> None:
    """The corners are those of the contour, but for place and scale; up is up."""
    distinct = places[np.insert(np.any(np.abs(np.diff(places, axis=0)) > 1e-6, axis=1), 0, True)]
    wanted = np.array([(z, -x) for x, z in contour])
    scale = np.ptp(distinct[:, 0]) / np.ptp(wanted[:, 0])
    np.testing.assert_allclose(distinct - distinct[0], (wanted - wanted[0]) * scale, atol=0.05)


def test_two_parts_of_a_sheet_are_drawn_with_their_numbers_though_none_is_chosen(tmp_path: Path) -> None:
    sheet = Sheet((-20.0, 40.0)).bush()
    sheet.at = (80.0, 40.0)
    path, picture = sheet.shaft().border().saved(tmp_path), tmp_path / "picture.svg"
    assert "GEO-DXF-CHOICE" in run("part", "from-dxf", path, "--picture", picture, status=3)
    assert drawn(picture, "5") == []
    first, second = drawn(picture, "2")
    like(first, OUTSIDE)
    like(second, SHAFT)
    said = re.findall(r"<text[^>]*>([^<]*)</text>", picture.read_text())
    assert said.count("1") == 2 and said.count("2") == 2 and any(one.startswith("outside, 5 features") for one in said)


def test_the_chosen_contour_is_bold(tmp_path: Path) -> None:
    path, picture = Sheet().bush().saved(tmp_path), tmp_path / "picture.svg"
    table = run("part", "from-dxf", path, "--side", "inside", "--zero", "chuck-end", "--picture", picture)
    assert "start = [12.0, 60.0]" in table and 'side = "inside"' in table
    (bold,) = drawn(picture, "5")
    like(bold, BORE)


@pytest.mark.parametrize("outline", [1, 2])
def test_the_section_of_a_solid_is_drawn(tmp_path: Path, outline: int) -> None:
    blind = [[(0.0, -50.0), (6.0, -50.0), (6.0, -60.0)], [(9.0, 0.0), (9.0, -20.0), (0.0, -25.0)]]
    section = [*blind[0], (20.0, -60.0), (20.0, 0.0), *blind[1]]
    path, picture = written(revolved(section), tmp_path / "part.step"), tmp_path / "picture.svg"
    run("part", "from-step", path, "--side", "inside", "--outline", outline, "--picture", picture)
    (bold,) = drawn(picture, "5")
    like(bold, blind[outline - 1])
    assert "part.step" in picture.read_text()
