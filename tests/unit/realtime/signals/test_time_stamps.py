"""How old a value is by the time stamp that comes with it."""

import math
from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.controllers.linuxcnc.realtime.signals.readings import NEVER_S, NOTHING, Board, Reading, reported_s, unix_s

moments = st.datetimes(datetime(2001, 1, 1), datetime(2090, 1, 1), timezones=st.just(UTC))


@given(moments)
def test_a_stamp_is_the_same_moment_however_it_is_written(moment: datetime) -> None:
    seconds = moment.timestamp()
    for written in (moment.isoformat(), moment.isoformat().replace("+00:00", "Z"), seconds, 1000 * seconds):
        assert unix_s(written) == pytest.approx(seconds, abs=1e-3)
    assert unix_s(moment.replace(tzinfo=None).isoformat()) == pytest.approx(seconds, abs=1e-3)


@pytest.mark.parametrize("stamp", ["", "yesterday", None, True, math.nan, math.inf, [1], "12:30"])
def test_what_is_no_time_is_refused(stamp: object) -> None:
    with pytest.raises(ValueError, match=r"time|isoformat"):
        unix_s(stamp)


@given(st.floats(0, 1e6), st.floats(0, 1e6))
def test_age_is_the_difference_of_the_sources_clock(age: float, now: float) -> None:
    assert now - reported_s(1e9, 1e9 + age, now, 1.0) == pytest.approx(age, abs=1e-6)


@given(st.floats(0, 1e4), st.floats(0, 1e4))
def test_a_stamp_of_the_future_is_taken_for_now_or_refused(ahead: float, skew: float) -> None:
    if ahead < skew:
        assert reported_s(1e9 + ahead, 1e9, 5.0, skew + 1e-6) == 5.0
    elif ahead > skew + 1e-5:
        with pytest.raises(ValueError, match="future"):
            reported_s(1e9 + ahead, 1e9, 5.0, skew)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_the_board_takes_numbers_alone(value: float) -> None:
    board = Board()
    board.put("T1", 20.0, 1.0)
    board.put("T1", value, 2.0)
    assert board.readings() == {"T1": Reading(20.0, 1.0)}


def test_the_board_keeps_the_later_reading_whichever_comes_last() -> None:
    board = Board({"T1": lambda value: value / 2})
    board.put("T1", 40.0, 5.0)
    board.put("T1", 80.0, 4.0)
    assert board.readings()["T1"] == Reading(20.0, 5.0)


def test_what_was_never_read_is_no_number_and_old() -> None:
    assert math.isnan(NOTHING.value)
    assert NOTHING.age_s(0.0) >= NEVER_S
