"""Many numbers at once are what each of them is alone."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.errors import TrueloopError
from trueloop.formats.inspections.shared.text import number_in, numbers_in

FILE = Path("points.qif")
WORD = st.text("0123456789+-.,eE_naif", min_size=1, max_size=8) | st.floats(-1e6, 1e6).map(str)


def one_by_one(words: list[str]) -> list[float] | str:
    try:
        return [number_in(word, FILE, 7) for word in words]
    except TrueloopError as refused:
        return str(refused)


@given(st.lists(WORD, max_size=6))
def test_read_at_once_or_one_by_one(words: list[str]) -> None:
    try:
        found: list[float] | str = numbers_in(" ".join(words), FILE, 7)
    except TrueloopError as refused:
        found = str(refused)
    assert found == one_by_one(words)


@pytest.mark.parametrize("word", ["1e16", "9" * 20, "1.2.3", "-", "nan", "1_000", "1,234.5"])
def test_what_is_no_number_is_refused_among_good_ones(word: str) -> None:
    with pytest.raises(TrueloopError, match="MSR-NUMBER"):
        numbers_in(f"1.5 -2 {word} .25", FILE, 7)
