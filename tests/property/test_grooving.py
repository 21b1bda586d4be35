"""Grooving cycles of Fanuc lathes (G74, G75): every move is that of the definition, written out slowly."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.unit.nc.test_turning_cycles import rows
from trueloop.nc.program.program import read_program

Row = tuple[str, float, float]
NONE = 1e-9


def places(first: float, last: float, apart: float | None) -> list[float]:
    """From the first by steps, and the last one where the next step would lead to it or beyond."""
    found, way = [first], 1 if last > first else -1
    while apart is not None and way * (last - found[-1]) > apart + NONE:
        found.append(found[-1] + way * apart)
    return found if abs(last - found[-1]) <= NONE else [*found, last]


def grooves(
    start: tuple[float, float], end: tuple[float, float], peck: float, step: float | None, back: float, relief: float
) -> list[Row]:
    """Points are (deep, across). Pecks go back by `back`, never past the start; at each bottom but the first the tool
    gives way by `relief`, back to where the groove before was; it comes out at rapid, and goes on at rapid."""
    made: list[Row] = []
    out = 1 if start[0] > end[0] else -1
    side = 1 if start[1] > end[1] else -1
    for number, across in enumerate(places(start[1], end[1], step)):
        made += [("rapid", start[0], across)] if number else []
        bottoms = places(start[0], end[0], peck)[1:]
        for bottom in bottoms[:-1]:
            made += [("line", bottom, across), ("rapid", bottom + out * min(back, abs(bottom - start[0])), across)]
        made.append(("line", end[0], across))
        away = across + (side * relief if number else 0.0)
        made += [("rapid", end[0], away), ("rapid", start[0], away)]
    return [*made, ("rapid", *start)]


def that_lead_anywhere(made: list[Row], start: tuple[float, float]) -> list[Row]:
    before = [start, *(row[1:] for row in made)]
    return [row for row, (deep, across) in zip(made, before, strict=False) if row[1:] != (deep, across)]


QUARTERS = st.integers(1, 40).map(lambda count: count / 4)
WIDTHS = st.integers(-40, 40).map(lambda count: count / 4)


@given(st.booleans(), st.sampled_from([-1, 1]), QUARTERS, WIDTHS, QUARTERS, QUARTERS, QUARTERS, st.integers(0, 2))
def test_grooves_are_pecked_side_by_side(
    facing: bool, inwards: int, depth: float, width: float, peck: float, step: float, back: float, relief: int
) -> None:
    """Along X and along Z, in both directions of each; X is a diameter, all that is no position a radius."""
    start = (2.0, 30.0) if facing else (30.0, 2.0)
    end = (start[0] + inwards * depth, start[1] + width)
    x, z = end[::-1] if facing else end
    along_x, along_z = (step, peck) if facing else (peck, step)
    code = "G74" if facing else "G75"
    words = f"X{2 * x} Z{z} P{round(1000 * along_x)} Q{round(1000 * along_z)} R{relief / 4} F.1"
    path = read_program(f"G21\nG00 X60. Z2.\n{code} R{back}\n{code} {words}\n".encode(), "fanuc-lathe").run()
    assert path.findings == ()
    expected = that_lead_anywhere(grooves(start, end, peck, step, back, relief / 4), start)
    found = [(kind, z, x) if facing else (kind, x, z) for kind, x, z in rows(path)]
    assert [row[0] for row in found] == [row[0] for row in expected]
    for one, other in zip(found, expected, strict=True):
        assert one[1:] == pytest.approx(other[1:], abs=1e-9)
