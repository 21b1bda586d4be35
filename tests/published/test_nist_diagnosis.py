"""Errors of features on the metal of [6811] Tables 4 and 8 to 11, against lines through the tables' own numbers."""

import re

import numpy as np
import pytest

from scripts.nist_diagnosis import PAGE, falsified, page
from scripts.nist_errors import Cut, errors, of_family, places_of
from trueloop.diagnosis.features.feature_error import ErrorKind

TABLE_4 = {"1411.559": [3, 6, 9, 13], "1511.561": [-4, -13, -25, -35]}
"""Combined errors as printed, points 1 to 4: the large cylinder."""
CONES = {"2511": [86, 88, 87, 88, 85], "2811": [95, 101, 107, 114, 115]}
"""Table 8, points 1 to 5."""


def ends(of: list[int], from_in: float, to_in: float, length_in: float) -> tuple[float, float]:
    """A line through errors at equal distances from `from_in` to `to_in`: at 0, and how much it rises to the end."""
    slope, start = np.polyfit(np.linspace(from_in, to_in, len(of)), of, 1)
    return float(start), float(slope) * length_in


@pytest.mark.parametrize(("part", "touched"), TABLE_4.items())
def test_a_taper_of_a_cylinder_is_that_of_a_line_through_the_table(part: str, touched: list[int]) -> None:
    """The first touch is at the chuck end; the sign is that of the tables: the error grows to the free end."""
    made = next(one for one in of_family("FACETST") if f"{one.number}.{one.semifinish_inspection}" == part)
    place = places_of(made.profile)["large-cylinder"]
    z_mm = [touch.nominal_mm[1] - place.z_mm[0] for touch in made.semifinish[:4]]
    start, rise = ends(touched, z_mm[0], z_mm[-1], place.z_mm[1] - place.z_mm[0])
    found = errors(made, "semifinish")
    assert 1e3 * found["large-cylinder", ErrorKind.RADIUS].value_mm == pytest.approx(start, abs=0.05)
    assert 1e3 * found["large-cylinder", ErrorKind.SHAFT_TAPER].value_mm == pytest.approx(rise, abs=0.05)


@pytest.mark.parametrize("number", CONES)
def test_the_taper_of_a_cone(number: str) -> None:
    """Touched 0.3 in from its chuck end to 0.45 in from its other, along the cone [6517 Table 1]."""
    made = next(one for one in of_family("MODBAS2") if one.number == number)
    (cone,) = (one for one in made.profile.features if one.name == "cone")
    length_in = cone.length_mm / 25.4
    start, rise = ends(CONES[number], 0.3, length_in - 0.45, length_in)
    found = errors(made, "semifinish")
    assert 1e3 * found["cone", ErrorKind.RADIUS].value_mm == pytest.approx(start, abs=0.05)
    assert 1e3 * found["cone", ErrorKind.SHAFT_TAPER].value_mm == pytest.approx(rise, abs=0.05)


def test_the_falsified_taper_is_that_of_2811() -> None:
    """By far the one that differs from the others of its family."""
    off = falsified()
    assert off["2811"] > 8.0
    assert max(abs(value) for number, value in off.items() if number != "2811") < 0.6 * off["2811"]


@pytest.mark.parametrize(("cut", "least", "most"), [("semifinish", 8.0, 15.5), ("finish", -2.5, 2.5)])
def test_the_offset_of_the_cylinders_is_gone_after_the_correction(cut: Cut, least: float, most: float) -> None:
    found = [1e3 * errors(one, cut)["main-cylinder", ErrorKind.RADIUS].value_mm for one in of_family("MODBAS2")]
    assert least < min(found) and max(found) < most


def test_the_length_between_the_faces_is_what_the_authors_read_off_the_step_face() -> None:
    """[6811 §5.1]: about +4 µm left on the step face of 1411, none on the end face."""
    found = errors(of_family("FACETST")[0], "finish")
    assert 1e3 * found["end-face", ErrorKind.LENGTH].value_mm == pytest.approx(-4.0, abs=0.5)


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


def test_the_page_is_current() -> None:
    """Word by word; a figure at the edge between two last digits falls to either by the processor's order of sums."""
    kept, made = PAGE.read_text(encoding="utf-8"), page()
    assert NUMBER.sub("#", kept) == NUMBER.sub("#", made), "run: python -m scripts.nist_diagnosis --write"
    for one, other in zip(NUMBER.findall(kept), NUMBER.findall(made), strict=True):
        digit = 10.0 ** -len(one.partition(".")[2]) if "." in one else 0.0
        assert abs(float(one) - float(other)) <= 1.01 * digit, (
            f"{one} is {other}: python -m scripts.nist_diagnosis --write"
        )
