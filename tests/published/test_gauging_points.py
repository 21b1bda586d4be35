"""The gauging points and drawings of the parts of [6811], rebuilt, against what [6517] and [6811] print."""

import csv
import math

import pytest

from scripts.nist_parts import ALLOWANCE_IN, FAMILIES, NOSE_RADIUS_IN, TABLE1_CSV, NistPart, parts, profile_of
from trueloop.geometry.feature import Arc
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import JunctionKind
from trueloop.units import MM_PER_INCH

PARTS = list(parts())
FACETST, MODBAS2, PIECS11 = FAMILIES

PIECS11_POINTS = {
    (5.30, "finish"): (4.83636, 2.45254, -1.62131, -1.25, 1.28125),
    (5.30, "semifinish"): (4.84800, 2.47416, -1.62009, -1.25, 1.29125),
    (5.26, "finish"): (4.81310, 2.40924, -1.60369, -1.23, 1.26125),
    (5.26, "semifinish"): (4.82474, 2.43090, -1.60251, -1.23, 1.27125),
    (5.22, "finish"): (4.78982, 2.36586, -1.58600, -1.21, 1.24125),
    (5.22, "semifinish"): (4.80146, 2.38756, -1.58486, -1.21, 1.25125),
    (5.18, "finish"): (4.76654, 2.32240, -1.56824, -1.19, 1.22125),
    (5.18, "semifinish"): (4.77818, 2.34414, -1.56713, -1.19, 1.23125),
    (5.14, "finish"): (4.74326, 2.27886, -1.55041, -1.17, 1.20125),
    (5.14, "semifinish"): (4.75490, 2.30064, -1.54934, -1.17, 1.21125),
}
"""[6811 A.4.2.1–A.4.2.19]: diameters at the start of the taper and of the arc, z there, arc centre's z, arc radius, in
inches. For 5.18 finish the report prints the radius as 1.20125, against its own centre and offsets."""


def of(family: str, number: str) -> NistPart:
    return next(part for part in PARTS if part.family.name == family and part.number == number)


def test_points_of_the_352_part_are_those_of_6517_table_1() -> None:
    """All 32, each to its last printed digit: seven figures in mm of coordinates rounded to 1e-6 in."""
    rebuilt = of("MODBAS2", "2511").semifinish
    with TABLE1_CSV.open(encoding="utf-8") as file:
        printed = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(printed) == len(rebuilt) == 32
    for row, touch in zip(printed, rebuilt, strict=True):
        assert touch.point == row["point"]
        for value, text in zip(touch.nominal_mm, (row["nominal_x_mm"], row["nominal_z_mm"]), strict=True):
            rounded_mm = 0.5e-6 * MM_PER_INCH + 0.5 * 10.0 ** -len(text.partition(".")[2])
            assert abs(value - float(text)) <= rounded_mm, (touch.point, value, text)


def test_parts_are_those_of_the_tables() -> None:
    """[6811] Tables 4, 8, 10 and 7, 9, 11: four, four and six parts; each finish inspection follows its semi-finish."""
    names = [f"{part.number}.{part.semifinish_inspection}/{part.finish_inspection}" for part in PARTS]
    assert names == [
        *("1411.559/560", "1411.606/607", "1511.561/562", "1511.608/609"),
        *("2511.139/140", "2611.141/142", "2711.143/144", "2811.145/146"),
        *("3511.158/159", "3611.160/161", "3711.162/164", "3811.154/155", "3812.165/166", "3911.167/169"),
    ]
    sizes = [5.62, 5.62, 5.58, 5.58, 3.52, 3.48, 3.44, 3.40, 5.30, 5.26, 5.22, 5.18, 5.18, 5.14]
    assert [part.size_in for part in PARTS] == pytest.approx(sizes, abs=1e-12)


def test_touches_fall_on_the_features_the_text_names() -> None:
    """[6811 §5.1 Fig. 13, §5.2, §5.3]: which points lie on which feature, by number."""
    expected = {
        "FACETST": {"large-cylinder": 4, "step-face": 8, "small-cylinder": 12, "end-face": 15},
        "MODBAS2": {"cone": 5, "main-cylinder": 10, "main-face": 11, "small-cylinder": 12, "dome": 32},
        "PIECS11": {"flange-face": 1, "collar": 2, "cone": 6, "knob": 26},
    }
    for part in PARTS:
        for touches in (part.semifinish, part.finish):
            last = {touch.feature: int(touch.point) for touch in touches}
            assert last == expected[part.family.name]


def test_knob_is_touched_from_102_to_5_degrees() -> None:
    """Twenty points on the 5.30 in knob: 102.3° … 4.6° from the spindle axis."""
    part = of("PIECS11", "3511")
    knob = part.profile.features[-1]
    assert isinstance(knob, Arc)
    angles = [
        math.degrees(math.atan2(t.nominal_mm[0], t.nominal_mm[1] - knob.centre_mm[1]))
        for t in part.semifinish
        if t.feature == "knob"
    ]
    assert len(angles) == 20
    assert angles[0] == pytest.approx(102.3, abs=0.05)
    assert angles[-1] == pytest.approx(4.6, abs=0.05)


@pytest.mark.parametrize(("size_in", "cut"), PIECS11_POINTS)
def test_one_drawing_gives_every_piecs11_program(size_in: float, cut: str) -> None:
    """A cone from diameter 4.8 in to the ball of 1.25 in at z = −1.625 in, skinned evenly for the smaller parts.

    The programs' coordinates are its offset: radii rounded to 1e-5 in, then doubled.
    """
    nose_in = NOSE_RADIUS_IN + (ALLOWANCE_IN if cut == "semifinish" else 0.0)
    path = nose_centre_path(profile_of(PIECS11, size_in), nose_in * MM_PER_INCH).features
    _, collar, step_face, cone, knob = path
    assert isinstance(knob, Arc)

    def inch(value_mm: float) -> float:
        return round(value_mm / MM_PER_INCH, 5)

    assert 2 * inch(collar.end_mm[0]) == pytest.approx(size_in + 2 * nose_in)
    assert (
        2 * inch(step_face.end_mm[0]),
        2 * inch(cone.end_mm[0]),
        inch(cone.end_mm[1]),
        inch(knob.centre_mm[1]),
        inch(knob.radius_mm),
    ) == pytest.approx(PIECS11_POINTS[size_in, cut], abs=1e-9)


@pytest.mark.parametrize(
    ("allowance_in", "cone_start_in", "cone_end_z_in"), [(0.0, 0.03684, -4.54192), (ALLOWANCE_IN, 0.04862, -4.53934)]
)
def test_one_drawing_gives_both_modbas2_programs(
    allowance_in: float, cone_start_in: float, cone_end_z_in: float
) -> None:
    """[6811 A.3.2, A.3.3]: a cone from diameter P46 + 1.8 at the step face to P46, 1.625 in long, offset by the nose.

    What the programs add to P46 + 1.8 is twice a radius rounded to 1e-5 in; their z is that of P46 = 3.6.
    """
    path = nose_centre_path(profile_of(MODBAS2, 3.6), (NOSE_RADIUS_IN + allowance_in) * MM_PER_INCH).features
    step_face, cone = path[1], path[2]
    assert 2 * round(step_face.end_mm[0] / MM_PER_INCH - 2.7, 5) == pytest.approx(cone_start_in, abs=1e-9)
    assert round(cone.end_mm[1] / MM_PER_INCH, 5) == pytest.approx(cone_end_z_in, abs=1e-9)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: f"{part.number}.{part.semifinish_inspection}")
def test_junctions_are_tangent_where_the_text_says(part: NistPart) -> None:
    """[6811 §5.1–5.3]: FACETST has only corners, MODBAS2's dome is tangent to its cylinder, PIECS11's knob is not."""
    tangent = [
        (before, after)
        for before, after, junction in zip(
            part.profile.names, part.profile.names[1:], part.profile.junctions, strict=False
        )
        if junction.kind is JunctionKind.TANGENT
    ]
    assert tangent == ([("small-cylinder", "dome")] if part.family.name == "MODBAS2" else [])
