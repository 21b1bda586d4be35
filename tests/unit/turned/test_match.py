"""Sizes of an inspection on a profile: by name, by geometry, never by guess."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.shaft import SHAFT
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Severity
from trueloop.geometry.feature import Line
from trueloop.geometry.validate import checked_profile
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import Axis, Left, Matches
from trueloop.turned.readings.of_this_part import check_matches
from trueloop.units import MM_PER_INCH

D, R, L, A = Quantity.DIAMETER, Quantity.RADIUS, Quantity.LENGTH, Quantity.ANGLE


def inspection(*values: Reading | Touch, **stated: object) -> Inspection:
    whole = Inspection(Part(PartType("shaft")), "readings", "0" * 64, len(values), values)
    return replace(whole, **stated)  # type: ignore[arg-type]


def matches(*values: Reading | Touch, names: dict[str, str] | None = None) -> Matches:
    return match_inspection(SHAFT, inspection(*values), names)


def one(reading: Reading) -> tuple[str, str | None, str]:
    """Feature, other feature and how they were found, of a reading that is matched."""
    found = matches(reading)
    assert not found.left, found.left
    (match,) = found.readings
    other = None if match.other_index is None else SHAFT.names[match.other_index]
    return SHAFT.names[match.feature_index], other, match.by


def left(reading: Reading) -> Left:
    """A reading that is not matched."""
    found = matches(reading)
    assert found.count == 0
    (unmatched,) = found.left
    return unmatched


@pytest.mark.parametrize(
    ("reading", "feature"),
    [
        (Reading("D1", D, 30.012, 30.0), "journal"),  # a diameter is twice the cylinder's x
        (Reading("D1", D, 30.012), "journal"),  # without a nominal value, within what a finish cut leaves on
        (Reading("D1", D, 25.0, 25.0, place_mm=(-18.75,)), "cone"),  # x is 12.5 half way along the cone
        (Reading("D1", D, 25.0, 25.0, place_mm=(0.3, 0.1, -18.75)), "cone"),  # a circle about the axis
        (Reading("R1", R, 10.0, 10.0, place_mm=(-8.0,)), "tip"),
        (Reading("R1", R, 2.003, 2.0), "round"),
        (Reading("L1", L, 0.0, 40.0, feature="shoulder", other="end"), "shoulder"),
    ],
)
def test_a_size_is_that_of_the_feature_it_fits(reading: Reading, feature: str) -> None:
    if reading.quantity is L:
        reading = replace(reading, actual=40.01)
    assert one(reading)[0] == feature


def test_a_cone_is_found_by_its_angle_to_the_axis() -> None:
    assert one(Reading("A1", A, 33.7, 33.69)) == ("cone", None, "geometry")  # atan(5/7.5)
    assert "no feature has" in left(Reading("A1", A, 56.3, 56.31)).reason  # its complement is no angle to the axis


def test_a_name_goes_before_geometry_in_any_case_and_by_the_users_list() -> None:
    assert one(Reading("D1", D, 30.012, 30.0, feature="JOURNAL")) == ("journal", None, "name")
    listed = matches(Reading("DIAMETER 7", D, 30.012, 30.0), names={"DIAMETER 7": "journal"})
    assert [(SHAFT.names[m.feature_index], m.by) for m in listed.readings] == [("journal", "name")]


def test_a_named_feature_with_another_size_is_no_match() -> None:
    wrong = left(Reading("D1", D, 24.0, 24.0, feature="journal"))
    assert "'journal' is named" in wrong.reason
    assert "6.0000 mm" in wrong.reason


def test_two_features_of_one_size_are_named_and_none_is_taken() -> None:
    stepped = checked_profile([
        Line("far", (20.0, -20.0), (15.0, -20.0)), Line("seat", (15.0, -20.0), (15.0, -10.0)),
        Line("near", (15.0, -10.0), (10.0, -10.0)), Line("tip", (10.0, -10.0), (10.0, 0.0)),
    ])  # fmt: skip
    (both,) = match_inspection(stepped, inspection(Reading("L1", L, 10.0, 10.0))).left
    assert both.candidates == ("near", "far to near")
    assert one(Reading("L1", L, 40.0, 40.0, feature="shoulder", other="end")) == ("shoulder", "end", "name")
    assert one(Reading("L1", L, 40.0, 40.0, feature="end")) == ("end", "shoulder", "name")


def test_a_face_at_z_0_is_the_zero_from_which_a_length_counts() -> None:
    """From the end face and from the part's zero it is one length; the one face named is that from zero."""
    assert one(Reading("L1", L, 40.012, 40.0)) == ("shoulder", None, "geometry")
    assert one(Reading("L1", L, 40.012, 40.0, feature="shoulder")) == ("shoulder", None, "name")


def test_a_length_whose_datum_is_no_feature_is_left() -> None:
    assert "'flange'" in left(Reading("L1", L, 40.0, 40.0, feature="shoulder", other="flange")).reason


def test_a_radius_among_diameters_is_said_and_not_applied() -> None:
    assert "2 times it fits: a radius among diameters?" in left(Reading("D1", D, 15.01, 15.0)).reason
    assert "0.5 times it fits: a diameter among radii?" in left(Reading("R1", R, 4.0, 4.0)).reason


def test_a_place_that_is_not_stated_is_asked_for_and_a_circle_off_the_axis_is_another_feature() -> None:
    assert "not stated" in left(Reading("D1", D, 25.0, 25.0, feature="cone")).reason
    cross = left(Reading("D1", D, 30.0, 30.0, place_mm=(12.0, 5.0, -30.0)))
    assert "13.000 mm off the axis" in cross.reason
    assert not cross.is_error


def test_a_size_too_far_from_nominal_is_not_of_this_part() -> None:
    far = left(Reading("D1", D, 32.1, 30.0))
    assert "deviates by +2.1000 mm" in far.reason
    assert one(Reading("D1", D, 31.9, 30.0))[0] == "journal"  # 0.95 mm of material on each side


@pytest.mark.parametrize("quantity", [Quantity.RUNOUT, Quantity.FORM, Quantity.POSITION, Quantity.OTHER])
def test_what_is_no_error_of_the_profile_is_kept_and_said(quantity: Quantity) -> None:
    kept = left(Reading("journal", quantity, 0.01, 0.0, feature="journal", axis="x"))
    assert not kept.is_error
    assert kept.reason


def test_a_coordinate_of_a_named_face_is_a_touch_whose_error_is_positive_where_material_is_left_on() -> None:
    found = matches(Reading("Z", Quantity.POSITION, -39.99, -40.0, feature="shoulder", axis="z"))
    (match,) = found.touches
    assert match.touch.nominal_mm == (17.5, -40.0)
    assert match.touch.error_mm == pytest.approx(0.01)  # the shoulder faces +z and stands further out
    facing_back = checked_profile(
        [
            Line("a", (10.0, -9.0), (10.0, -5.0)),
            Line("back", (10.0, -5.0), (12.0, -5.0)),
            Line("b", (12.0, -5.0), (12.0, 0.0)),
        ]
    )
    low = Reading("Z", Quantity.POSITION, -5.01, -5.0, feature="back", axis="z")
    assert match_inspection(facing_back, inspection(low)).touches[0].touch.error_mm == pytest.approx(0.01)


def test_a_touch_is_on_the_feature_it_names_or_on_the_nearest() -> None:
    named = Touch("1", (15.0, -30.0), "Journal", measured_mm=(15.01, -30.0))
    nearest = Touch("2", (10.0, -8.0), error_mm=0.004)
    found = match_inspection(SHAFT, inspection(named, nearest, Touch("3", (17.0, -30.0), error_mm=0.0)))
    assert [(SHAFT.names[m.feature_index], m.by) for m in found.touches] == [("journal", "name"), ("tip", "geometry")]
    assert found.touches[0].touch.error_mm == pytest.approx(0.01)
    assert "2.000 mm from 'journal'" in found.left[0].reason
    ball = match_inspection(SHAFT, inspection(replace(named, measured_mm=(16.51, -30.0)), ball_radius_mm=1.5))
    assert ball.touches[0].touch.error_mm == pytest.approx(0.01)


def findings(*values: Reading, **stated: object) -> list[tuple[Severity, Code]]:
    whole = inspection(*values, **stated)
    found = match_inspection(SHAFT, whole)
    return [(each.severity, each.code) for each in check_matches(SHAFT, whole, found, {}, None)]


def sizes(*nominal: float, scale: float = 1.0) -> tuple[Reading, ...]:
    return tuple(Reading(f"D{k}", D, (one + 0.01) * scale, one * scale) for k, one in enumerate(nominal))


def test_an_inspection_of_another_part_says_how_many_of_how_many() -> None:
    whole = inspection(*sizes(30.0, 12.0, 13.0, 14.0))
    (finding,) = check_matches(SHAFT, whole, match_inspection(SHAFT, whole), {}, None)
    assert (finding.severity, finding.code) == (Severity.ERROR, Code.MSR_PART)
    assert finding.values == {"matched": 1, "values": 4}
    assert findings(*sizes(30.0, 20.0, 13.0)) == []  # most of it is on the part: one size is of something else


@pytest.mark.parametrize("factor", [MM_PER_INCH, 1.0 / MM_PER_INCH])
def test_inches_for_millimetres_are_found_by_the_factor_that_makes_them_fit(factor: float) -> None:
    whole = inspection(*sizes(30.0, 20.0, 40.0, scale=1.0 / factor))
    (finding,) = check_matches(SHAFT, whole, match_inspection(SHAFT, whole), {}, None)
    assert finding.code is Code.MSR_SCALE
    assert finding.values == {"factor": factor, "fitting": 3, "values": 3}


def test_limits_that_exclude_the_nominal_are_warned_of_and_crossed_ones_are_an_error() -> None:
    size = Reading("D1", D, 30.0, 30.0)
    assert findings(replace(size, lower_limit=29.96, upper_limit=29.98)) == [(Severity.WARNING, Code.MSR_EXCLUDED)]
    assert findings(replace(size, lower_limit=30.01)) == [(Severity.WARNING, Code.MSR_EXCLUDED)]
    assert findings(replace(size, lower_limit=30.02, upper_limit=29.98)) == [(Severity.ERROR, Code.MSR_EXCLUDED)]
    assert findings(replace(size, lower_limit=29.98, upper_limit=30.0)) == []


def test_one_characteristic_with_two_nominal_values_or_in_two_places() -> None:
    size = Reading("D1", D, 30.0, 30.0, place_mm=(-30.0,))
    assert findings(size, replace(size, actual=30.01, repeat=2)) == []
    assert findings(size, replace(size, nominal=20.0, actual=20.0, place_mm=(-8.0,))) == [
        (Severity.WARNING, Code.MSR_PLACES)
    ]
    assert findings(size, replace(size, place_mm=(-25.0,))) == [(Severity.WARNING, Code.MSR_PLACES)]


@pytest.mark.parametrize(
    ("axis", "place"), [("z", (0.0, 0.0, -18.75)), ("-z", (0.0, 0.0, 18.75)), ("-x", (18.75, 0.0, 0.0))]
)
def test_a_circle_lies_along_the_axis_of_its_frame(axis: Axis, place: tuple[float, float, float]) -> None:
    whole = inspection(Reading("D1", D, 25.0, 25.0, place_mm=place))
    (match,) = match_inspection(SHAFT, whole, axis=axis).readings
    assert (SHAFT.names[match.feature_index], match.reading.place_mm) == ("cone", (-18.75,))
    assert match_inspection(SHAFT, replace(whole, frame="device"), axis=axis).count == 0  # its place is another frame's


def test_a_diameter_at_a_place_differs_by_twice_its_distance() -> None:
    (match,) = matches(Reading("D1", D, 30.0, 30.01, place_mm=(-30.0,))).readings
    assert match.distance_mm == pytest.approx(0.01)
    assert "no feature has" in left(Reading("D1", D, 30.0, 30.03, place_mm=(-30.0,))).reason


@given(st.lists(st.floats(5.0, 50.0), min_size=1, max_size=6, unique=True), st.floats(-0.4, 0.4), st.booleans())
def test_no_diameter_goes_to_a_feature_of_another_size(radii: list[float], error_mm: float, placed: bool) -> None:
    """Steps of any radii, near ones among them: each diameter is that of its own step, or the candidates are named."""
    corners = [(20.0 + 60.0 * k, x, k) for k, x in enumerate(sorted(radii, reverse=True))]
    chain: list[Line] = []
    for z, x, k in corners:
        if chain and chain[-1].end_mm[0] - x > 1e-3:
            chain.append(Line(f"face {k}", chain[-1].end_mm, (x, chain[-1].end_mm[1])))
        start = chain[-1].end_mm if chain else (x, z - 20.0)
        chain.append(Line(f"step {k}", start, (start[0], z + 40.0)))
    profile = checked_profile(chain)
    steps = [(one.name, one.start_mm[0], (one.start_mm[1] + one.end_mm[1]) / 2) for one in chain if "step" in one.name]
    sizes_of = [Reading(name, D, 2 * (x + error_mm), 2 * x, place_mm=(z,) if placed else ()) for name, x, z in steps]
    unnamed = [replace(one, characteristic=f"D{k}") for k, one in enumerate(sizes_of)]
    found = match_inspection(profile, inspection(*unnamed))
    assert len(found.readings) + len(found.left) == len(steps)
    for match in found.readings:
        name, x, _ = steps[int(match.reading.characteristic[1:])]
        assert abs(profile.features[match.feature_index].start_mm[0] - x) <= 0.01 + 1e-9
        assert profile.names[match.feature_index] == name or not placed
    assert all(len(one.candidates) > 1 for one in found.left)
