"""What a file says twice is compared, and what nobody measured is found."""

from dataclasses import replace

import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.shared.checks import (
    filled_in,
    half_digits,
    numbered,
    stated_deviations,
    stated_verdicts,
    within,
)

BORE = Reading("D1", Quantity.DIAMETER, 10.02, 10.0, 9.99, 10.03, line=7)


def _part(*readings: Reading, serial: str = "A01") -> Inspection:
    return Inspection(Part(PartType("cover"), serial), "readings", "0" * 64, len(readings), readings)


@pytest.mark.parametrize(
    ("printed", "half"), [("4.530", 0.0005), ("4,5", 0.05), ("12", 0.5), ("1.8003E+1", 0.0005), ("2e-3", 0.0005)]
)
def test_half_of_the_last_digit(printed: str, half: float) -> None:
    assert half_digits(printed) == pytest.approx(half, rel=1e-12)
    assert half_digits(printed, printed) == pytest.approx(2 * half, rel=1e-12)


def test_any_exponent_has_a_last_digit() -> None:
    assert half_digits("1e99999") == float("inf")
    assert half_digits("1e-99999") == 0.0


def test_a_deviation_is_actual_minus_nominal() -> None:
    assert stated_deviations([(BORE, 0.02, 0.0)]) == ()
    assert stated_deviations([(BORE, 0.0204, 0.0005)]) == (), "rounded when it was printed"
    assert stated_deviations([(replace(BORE, nominal=None), 5.0, 0.0)]) == ()


@pytest.mark.parametrize(
    ("stated", "says"),
    [(-0.02, "nominal − actual"), (0.01, "that of the radius"), (0.5, "not that"), (-0.01, "not that")],
)
def test_a_deviation_counted_otherwise_is_reported_once(stated: float, says: str) -> None:
    (remark,) = stated_deviations([(BORE, stated, 0.0)] * 3 + [(BORE, 0.02, 0.0)])
    assert "3 of 4 deviations" in remark.text and says in remark.text and remark.line == 7
    assert "+0.02 mm" in remark.text and f"{stated:+g}" in remark.text


def test_only_a_diameter_can_deviate_by_half() -> None:
    (remark,) = stated_deviations([(replace(BORE, quantity=Quantity.LENGTH), 0.01, 0.0)])
    assert "not that" in remark.text


@pytest.mark.parametrize(("actual", "good"), [(9.98, False), (9.99, True), (10.0, True), (10.03, True), (10.04, False)])
def test_limits_are_still_good(actual: float, good: bool) -> None:
    reading = replace(BORE, actual=actual)
    assert within(reading) is good
    assert stated_verdicts([(reading, good)]) == ()
    (remark,) = stated_verdicts([(reading, not good)])
    assert ("outside" if good else "inside") in remark.text and "[9.99, 10.03] mm" in remark.text


def test_one_limit_is_enough_and_none_judges_nothing() -> None:
    assert within(replace(BORE, lower_limit=None, actual=0.0)) is True
    assert within(replace(BORE, upper_limit=None, actual=0.0)) is False
    assert within(replace(BORE, lower_limit=None, upper_limit=None)) is None
    assert stated_verdicts([(replace(BORE, lower_limit=None, upper_limit=None), False)]) == ()


def test_one_name_measured_often_is_numbered() -> None:
    other = replace(BORE, feature="bore 2")
    assert [one.repeat for one in numbered([BORE, other, BORE, replace(BORE, axis="x"), BORE])] == [1, 1, 2, 1, 3]


def test_all_diameters_nominal_were_filled_in() -> None:
    nominal = replace(BORE, actual=10.0)
    length = Reading("L1", Quantity.LENGTH, 5.3, 5.0)
    (remark,) = filled_in([_part(nominal, nominal, length, serial="B7"), _part(nominal, BORE), _part(nominal, length)])
    assert remark.text == "filled in, not measured: all 2 diameters of part 'B7' are exactly nominal"
    assert remark.line == 7
