"""ISO 286 against printed tables of ISO 286-2, and rules that its classes keep."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.errors import Code, TrueloopError
from trueloop.tolerances.text import ABOVE_ZERO_UM, BELOW_ZERO_UM, FINE_MM, GRADE_UM, LETTERS, MAIN_MM, deviations_mm

PRINTED = Path(__file__).parent / "iso286_limits.txt"


def printed() -> Iterator[tuple[str, float, float, str]]:
    """Name of the row, both ends of the range, and what is printed there."""
    over: list[float] = []
    up_to: list[float] = []
    for line in PRINTED.read_text().splitlines():
        name, *cells = line.split()
        if name == "over":
            over = list(map(float, cells))
        elif name == "upto":
            up_to = list(map(float, cells))
        elif name != "#":
            rows = zip(cells, over, up_to, strict=True)
            yield from ((name, low, high, cell) for cell, low, high in rows if cell != "?")


@pytest.mark.parametrize("name", sorted({row[0] for row in printed()}))
def test_limits_are_those_of_the_printed_tables(name: str) -> None:
    for _, over, up_to, cell in (row for row in printed() if row[0] == name):
        for size in (over + 1e-6, 0.5 * (over + up_to), up_to):
            lower, upper = (
                1000.0 * one for one in deviations_mm(name.replace("ei:", "") + "6" * ("ei:" in name), size)
            )
            expected = [float(one) for one in reversed(cell.split("/"))]
            assert [lower, upper][: len(expected)] == pytest.approx(expected), (name, size)


def test_hundreds_of_printed_values_are_held() -> None:
    assert sum(1 + ("/" in cell) for *_, cell in printed()) > 1500


@given(
    letter=st.sampled_from([one for one in LETTERS if len(one) == 1 and one not in "kmnj"]),
    grade=st.integers(8, 18),
    size=st.floats(1.5, 3150.0),
)
def test_a_hole_is_its_shaft_turned_over(letter: str, grade: int, size: float) -> None:
    try:
        lower, upper = deviations_mm(f"{letter}{grade}", size)
    except TrueloopError:
        return
    assert deviations_mm(f"{letter.upper()}{grade}", size) == pytest.approx((-upper, -lower))


@given(size=st.floats(3.1, 500.0), letter=st.sampled_from(["N", "P", "R", "S"]), grade=st.sampled_from([5, 6, 7]))
def test_holes_of_one_grade_coarser_give_the_fit_of_their_shafts(size: float, letter: str, grade: int) -> None:
    """What Δ is for: H7/p6 and P7/h6 have the same interference."""
    hole = deviations_mm(f"{letter}{grade}", size)
    shaft = deviations_mm(f"{letter.lower()}{grade - 1}", size)
    basic_hole, basic_shaft = deviations_mm(f"H{grade}", size), deviations_mm(f"h{grade - 1}", size)

    assert hole[0] - basic_shaft[1] == pytest.approx(basic_hole[0] - shaft[1])
    assert hole[1] - basic_shaft[0] == pytest.approx(basic_hole[1] - shaft[0])


def test_a_table_ascends_with_the_size_and_the_grade() -> None:
    """A slip of a digit would break the order that all rows and columns keep, but k, which is zero over 500 mm."""
    rows = [row.numbers for name, row in (ABOVE_ZERO_UM | BELOW_ZERO_UM | GRADE_UM).items() if name != "k"]
    rows += list(zip(*(row.numbers for row in GRADE_UM.values()), strict=True))
    for row in rows:
        known = [number for number in row if number is not None]
        assert known == sorted(known)


def test_five_grades_make_a_factor_of_ten() -> None:
    """From grade 6 on, to the rounding of the table."""
    for n in range(6, 14):
        pairs = zip(GRADE_UM[str(n)].numbers, GRADE_UM[str(n + 5)].numbers, strict=True)
        for finer, coarser in pairs:
            assert finer is not None and coarser is not None
            assert coarser == pytest.approx(10.0 * finer, rel=0.065)


def test_rows_have_as_many_numbers_as_ranges() -> None:
    """Up to 3150 mm, up to 500 mm, or, of the letters in between, up to 50 mm."""
    lengths = {name: len(row.numbers) for name, row in (ABOVE_ZERO_UM | BELOW_ZERO_UM).items()}

    assert {n for name, n in lengths.items() if name in ("d", "e", "f", "g", "h", "k", "m", "n", "p")} == {len(MAIN_MM)}
    assert {n for name, n in lengths.items() if name in "rstu"} == {len(FINE_MM)}
    assert {lengths[name] for name in ("a", "b", "c", "v", "x", "y", "z", "za", "zb", "zc")} == {25}
    assert {lengths[name] for name in ("cd", "ef", "fg")} == {6}


@pytest.mark.parametrize("name", ["h66", "h19", "w6", "Hh6", "i5", "l7", "o7", "q8", "h", "7", "h6H7", "jS7"])
def test_a_class_that_the_standard_does_not_have_is_refused(name: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        deviations_mm(name, 40.0)
    assert refused.value.code is Code.TOL_FIT


@pytest.mark.parametrize(
    ("name", "size"),
    [
        *[("h6", 3150.1), ("h6", 0.0), ("h6", -40.0), ("zc8", 501.0), ("t6", 24.0), ("v6", 14.0), ("y6", 18.0)],
        *[
            ("cd8", 51.0),
            ("a9", 1.0),
            ("h14", 1.0),
            ("h01", 501.0),
            ("K9", 40.0),
            ("j8", 3.1),
            ("j9", 2.0),
            ("N2", 40.0),
        ],
    ],
)
def test_a_size_outside_of_its_tables_is_refused(name: str, size: float) -> None:
    with pytest.raises(TrueloopError) as refused:
        deviations_mm(name, size)
    assert refused.value.code is Code.TOL_SIZE
