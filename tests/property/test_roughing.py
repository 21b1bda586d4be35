"""Roughing cycles of Fanuc lathes (G71 to G73): every move is that of the definition."""

from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.roughing_reference import Cycle, Piece, Row, cuts, gouges_mm, pattern
from trueloop.nc.program import read_program
from trueloop.nc.tool_path import Motion, ToolPath

QUADRANT: Final = ((5, 0), (4, 3), (3, 4), (0, 5))
"""Points of a circle of radius 5 whose coordinates are whole numbers."""
COARSE: Final = st.integers(1, 12).map(lambda steps: steps / 4)


@st.composite
def shapes(draw: st.DrawFn) -> list[Piece]:
    """Contours (deep, along) that begin deepest and come out as they run on: lines and arcs of whole coordinates.

    Depths fall to zero or above, where the cycle starts.
    """
    pieces, steps = [], [draw(_steps()) for _ in range(draw(st.integers(1, 5)))]
    deep, along = sum(out for out, _, _ in steps) + draw(st.integers(0, 2)), float(draw(st.integers(0, 3)))
    for out, on, centre in steps:
        start, end = (deep, along), (deep - out, along + on)
        about = None if centre is None else (deep - centre[0], along + centre[1])
        pieces.append(Piece(start, end, about))
        deep, along = end
    return [*pieces, Piece((deep, along), (0.0, along))] if deep > 0 else pieces


@st.composite
def _steps(draw: st.DrawFn) -> tuple[float, float, tuple[float, float] | None]:
    """How far a piece comes out and runs on, and where its centre lies from its start, likewise."""
    if draw(st.booleans()):
        out, on = draw(st.sampled_from([(0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (1.0, 2.0), (3.0, 1.0)]))
        size = draw(COARSE)
        return out * size, on * size, None
    first, last = sorted(draw(st.lists(st.integers(0, 3), min_size=2, max_size=2, unique=True)))
    size = draw(st.sampled_from([0.25, 0.5, 1.0]))
    (a, b), (c, d) = QUADRANT[first], QUADRANT[last]
    if draw(st.booleans()):  # the centre lies outwards: a hollow
        return size * (a - c), size * (d - b), (size * a, -size * b)
    return size * (d - b), size * (a - c), (-size * b, size * a)


class Words:
    """A cycle in Fanuc's words: X and the allowance U are diameters, everything else is not."""

    def __init__(
        self, shape: list[Piece], facing: bool, inwards: int, onwards: int, start: tuple[float, float]
    ) -> None:
        self.facing, self.signs, self.start = facing, (inwards, onwards), start
        self.contour = [
            Piece(self.place(p.start), self.place(p.end), None if p.centre is None else self.place(p.centre))
            for p in shape
        ]

    def place(self, point: tuple[float, float]) -> tuple[float, float]:
        """(x, z) of (deep, along)."""
        deep, along = self.signs[0] * point[0], self.signs[1] * point[1]
        x, z = (along, deep) if self.facing else (deep, along)
        return self.start[0] + x, self.start[1] + z

    def blocks(self, feeds_down: bool) -> str:
        """The contour between N1 and N2."""
        x, z = self.contour[0].start
        lines = [f"N1 G0{int(feeds_down)} X{2 * x:.4f} Z{z:.4f}"]
        for piece in self.contour:
            (x0, z0), (x, z) = piece.start, piece.end
            code, centre = "G01", ""
            if piece.centre is not None:
                i, k = piece.centre[0] - x0, piece.centre[1] - z0
                clockwise = i * (z - z0) - k * (x - x0) > 0  # z to the right, x up
                code, centre = f"G0{2 if clockwise else 3}", f" I{i:.4f} K{k:.4f}"
            lines.append(f"{code} X{2 * x:.4f} Z{z:.4f}{centre}")
        return "\n".join([*lines, "N2 G01"])

    def program(self, cycle: str, allowance: tuple[float, float], feeds_down: bool) -> str:
        """All of it."""
        u, w = allowance
        first, code = cycle, cycle[:3]
        return (
            f"G21 G18\nG00 X{2 * self.start[0]:.4f} Z{self.start[1]:.4f}\n{first}\n"
            f"{code} P1 Q2 U{2 * u:.4f} W{w:.4f} F.3\n{self.blocks(feeds_down)}\nM30\n"
        )


def rows(path: ToolPath) -> list[Row]:
    """Kind and end of the moves of line 4, in the order they are made."""
    return [
        (Motion(path.motion[k]).name.lower(), float(path.end_mm[k, 0]), float(path.end_mm[k, 2]))
        for k in range(len(path))
        if path.line[k] == 4
    ]


def assert_same(found: list[Row], expected: list[Row]) -> None:
    assert [row[0] for row in found] == [row[0] for row in expected]
    for one, other in zip(found, expected, strict=True):
        assert one[1:] == pytest.approx(other[1:], abs=1e-9)


signs = st.sampled_from([-1, 1])
allowances = st.tuples(st.integers(-4, 4), st.integers(-4, 4)).map(lambda pair: (pair[0] / 8, pair[1] / 8))


@given(shapes(), st.booleans(), signs, signs, allowances, COARSE, st.integers(0, 4), st.booleans())
def test_straight_cuts_end_at_the_contour_and_the_last_follows_it(
    shape: list[Piece],
    facing: bool,
    inwards: int,
    onwards: int,
    allowance: tuple[float, float],
    depth: float,
    escape: int,
    feeds_down: bool,
) -> None:
    """Outside and inside, towards the chuck and away from it, with allowances of either sign."""
    words = Words(shape, facing, inwards, onwards, (40.0, 3.0))
    if shape[0].start[0] <= 0:
        return  # nothing to rough out
    said = f"G72 W{depth:.4f} R{escape / 4:.4f}" if facing else f"G71 U{depth:.4f} R{escape / 4:.4f}"
    path = read_program(words.program(said, allowance, feeds_down).encode(), "fanuc-lathe").run()
    assert path.findings == ()
    cycle = Cycle(words.start, words.contour, allowance, feeds_down)
    found = rows(path)
    assert_same(found, cuts(cycle, depth, escape / 4, facing=facing))
    assert max(gouges_mm(found[:-1], cycle, facing=facing), default=0.0) < 0.05  # points lie that near to one another


@given(shapes(), signs, signs, allowances, allowances, st.integers(1, 5), st.booleans())
def test_a_pattern_comes_nearer_by_equal_steps(
    shape: list[Piece],
    inwards: int,
    onwards: int,
    allowance: tuple[float, float],
    relief: tuple[float, float],
    passes: int,
    feeds_down: bool,
) -> None:
    words = Words(shape, False, inwards, onwards, (40.0, 3.0))
    said = f"G73 U{relief[0]:.4f} W{relief[1]:.4f} R{passes}"
    path = read_program(words.program(said, allowance, feeds_down).encode(), "fanuc-lathe").run()
    assert path.findings == ()
    assert_same(rows(path), pattern(Cycle(words.start, words.contour, allowance, feeds_down), relief, passes))
