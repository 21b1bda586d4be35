"""Characteristics on the page: tightest first, in or out by sign and word, the right numbers in the right unit."""

import re
from dataclasses import replace

import pytest

from trueloop.domain.characteristic import Characteristic, Judged, Judgement, Quantity
from trueloop.report.markup import text_of
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.characteristic_table import characteristic_table, tightest_first

SEAT = Judged(
    Characteristic("bearing seat", Quantity.DIAMETER, "seat", 25.4, 25.387, 25.4, at_z_mm=-12.7, tolerance="h6"),
    Judgement(25.4127, 0.0004, None, 0.0, -0.0127, "out"),
    Judgement(25.3936, 0.0025, None, 0.9834, 0.0064, "undecided"),
)
LENGTH = Judged(
    Characteristic("length <b>", Quantity.LENGTH, "face", 50.0, 49.9, 50.1),
    None,
    Judgement(50.0, 0.001, 12, 0.99999, 0.1, "in"),
)
ANGLE = Judged(
    Characteristic("taper", Quantity.ANGLE, "cone", 30.0, None, 30.5),
    Judgement(30.6, 0.01, None, 0.0, -0.1, "out"),
    Judgement(30.7, 0.01, None, 1e-9, -0.2, "out"),
)


def rows(html: str) -> list[list[str]]:
    (body,) = re.findall("<tbody>(.*?)</tbody>", html, re.DOTALL)
    return [re.findall("<td[^>]*>(.*?)</td>", row, re.DOTALL) for row in re.findall("<tr>(.*?)</tr>", body, re.DOTALL)]


def test_the_tightest_stands_first() -> None:
    assert [one.characteristic.name for one in tightest_first([LENGTH, SEAT, ANGLE])] == [
        "taper", "bearing seat", "length <b>",
    ]  # fmt: skip


def test_limits_values_and_verdicts_by_sign_and_word() -> None:
    (seat,) = rows(characteristic_table([SEAT]))
    said = [text_of(cell.replace("<br>", " ")) for cell in seat[:9]]
    assert said == [
        "bearing seat diameter, seat, at z −12.700 mm", "25.4000 mm h6", "25.3870 25.4000", "25.4127", "✗ out",
        "25.3936 ± 0.0049", "? undecided", "98.3 %", "0.0064",
    ]  # fmt: skip
    assert 'class="verdict-out"' in seat[4] and 'class="verdict-undecided"' in seat[6]


def test_in_inches_and_in_german() -> None:
    (seat,) = rows(characteristic_table([SEAT], Texts("de", "inch")))
    said = [text_of(cell.replace("<br>", " ")) for cell in seat[:9]]
    assert said[1:4] == ["1,00000 in h6", "0,99949 1,00000", "1,00050"]
    assert (said[4], said[7]) == ("✗ n. i. O.", "98,3 %")


def test_an_angle_stays_in_degrees_and_what_was_not_judged_is_a_dash() -> None:
    angle, length = rows(characteristic_table([LENGTH, ANGLE], Texts("en", "inch")))
    assert [text_of(cell.replace("<br>", " ")) for cell in angle[1:4]] == ["30.0000 °", "– 30.5000", "30.6000"]
    assert (length[3], length[4]) == ("–", "–")
    assert length[7] == "over 99.9 %" and angle[7] == "under 0.1 %"


def test_names_are_text_not_markup() -> None:
    assert "length <b>" not in characteristic_table([LENGTH])


def bar_places(judged: Judged) -> tuple[list[float], float]:
    """Where limits and the expected value stand in the bar, px."""
    html = characteristic_table([judged])
    limits = [float(x) for x in re.findall(r'<path d="M([\d.]+) 1V17" class="limit"/>', html)]
    (value,) = re.findall(r'<path d="M([\d.]+) [\d.]+l4.5 4.5', html)
    return limits, float(value)


@pytest.mark.parametrize(("value", "share"), [(25.387, 0.0), (25.3935, 0.5), (25.4, 1.0)])
def test_the_bar_is_to_scale(value: float, share: float) -> None:
    (low, high), at = bar_places(replace(SEAT, after=replace(SEAT.after, value=value)))
    assert low < high
    assert at == pytest.approx(low + share * (high - low), abs=0.11)


def test_without_characteristics_the_page_says_how_to_state_them() -> None:
    html = characteristic_table([])
    assert "[[part.characteristic]]" in html and "<table" not in html
