from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.geometry.feature import Line
from trueloop.geometry.validate import checked_profile
from trueloop.turned.readings.matches import feature_named, match_by_name

PROFILE = checked_profile(
    [
        Line("Seat 1", (20.0, -30.0), (20.0, -10.0)),
        Line("shoulder", (20.0, -10.0), (15.0, -10.0)),
        Line("seat-2", (15.0, -10.0), (15.0, 0.0)),
        Line("SEAT2", (15.0, 0.0), (0.0, 0.0)),
    ]
)


def reading(feature: str, other: str = "", characteristic: str = "") -> Reading:
    return Reading(characteristic, Quantity.LENGTH, 10.0, feature=feature, other=other)


def test_a_name_is_found_as_it_is_or_where_case_and_signs_alone_differ() -> None:
    assert feature_named(PROFILE, "seat-2") == 2
    assert feature_named(PROFILE, "SEAT2") == 3
    assert feature_named(PROFILE, "seat_1") == 0
    assert feature_named(PROFILE, "seat 2") is None, "two features have that name but for its signs"
    assert feature_named(PROFILE, "") is None
    assert feature_named(PROFILE, "--") is None


def test_a_reading_belongs_to_the_feature_that_it_names_or_else_to_that_of_its_characteristic() -> None:
    found = match_by_name(PROFILE, reading("shoulder", characteristic="seat-2"))
    assert found is not None
    assert (found.feature_index, found.other_index, found.by, found.distance_mm) == (1, None, "name", 0.0)
    by_characteristic = match_by_name(PROFILE, reading("", characteristic="seat-2"))
    assert by_characteristic is not None
    assert by_characteristic.feature_index == 2
    assert match_by_name(PROFILE, reading("bore")) is None


def test_a_length_needs_both_of_its_features() -> None:
    found = match_by_name(PROFILE, reading("shoulder", "SEAT2"))
    assert found is not None
    assert (found.feature_index, found.other_index) == (1, 3)
    assert match_by_name(PROFILE, reading("shoulder", "bore")) is None
