"""Numbers, ticks and labels as people read them."""

import math

import pytest

from trueloop.report.style import LEFT_ON, SOFT, TAKEN, colour_of, label, padded, plain, round_step, signed


@pytest.mark.parametrize(
    ("value", "told"),
    [(2.94, "+2.9"), (-18.733, "−18.7"), (0.0, "0.0"), (-0.04, "0.0"), (0.04, "0.0"), (math.nan, "–")],
)
def test_errors_have_a_sign_unless_they_are_written_as_zero(value: float, told: str) -> None:
    assert signed(value) == told


def test_a_plain_number_keeps_only_a_minus() -> None:
    assert plain(1.04, 2) == "1.04"
    assert plain(-1.04, 2) == "−1.04"


@pytest.mark.parametrize(
    ("span", "about", "step"), [(100, 8, 20), (9.6, 5, 2), (0.3, 6, 0.05), (1.0, 10, 0.1), (7, 1, 10)]
)
def test_ticks_stand_at_round_numbers(span: float, about: int, step: float) -> None:
    assert round_step(span, about) == pytest.approx(step, rel=1e-12)


def test_red_is_left_on_blue_is_taken_and_what_reads_as_zero_is_neither() -> None:
    assert [colour_of(e) for e in (0.06, -0.06, 0.04, -0.04, 0.0)] == [LEFT_ON, TAKEN, SOFT, SOFT, SOFT]


def test_a_range_holds_zero_and_what_is_known() -> None:
    assert padded([10.0, math.nan, 5.0], 0.1) == (-1.0, 11.0)


def test_text_in_a_figure_is_shown_not_obeyed() -> None:
    assert label("<b>5 & 6</b>") == "&lt;b&gt;5 &amp; 6&lt;/b&gt;"
