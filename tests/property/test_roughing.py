"""Roughing cycles of Fanuc lathes (G71 to G73): every move is that of the definition."""

from typing import Final

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.support.columns import assert_cleared, sampled
from tests.support.roughing_reference import Cycle, Piece, Row, cuts, gouges_mm, pattern
from trueloop.arrays import Array
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

QUADRANT: Final = ((5, 0), (4, 3), (3, 4), (0, 5))
"""Points of a circle of radius 5 whose coordinates are whole numbers."""
COARSE: Final = st.integers(1, 12).map(lambda steps: steps / 4)


@st.composite
def shapes(draw: st.DrawFn) -> list[Piece]:
    """Contours (deep, along) that begin deepest and come out as they run on: lines and arcs of whole coordinates.

    Depths fall to zero or above, where the cycle starts.
    """
    pieces, steps = [], [draw(_steps()) for _ in range(draw(st.integers(1, 5)))]
    deep, along = sum(out for out, _, _ in steps) + draw(st.integers(0, 2)), 0.0
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

    def blocks(self, feeds_down: bool, *, pockets: bool) -> str:
        """The contour between N1 and N2; one with pockets names both axes first, and its half turns are one arc."""
        x, z = self.contour[0].start
        place = f"X{2 * x:.4f} Z{z:.4f}" if pockets else f"Z{z:.4f}" if self.facing else f"X{2 * x:.4f}"
        lines, begun = [f"N1 G0{int(feeds_down)} {place}"], self.contour[0].start
        for piece, after in zip(self.contour, [*self.contour[1:], None], strict=True):
            if pockets and after is not None and piece.centre is not None and after.centre == piece.centre:
                continue
            (x0, z0), (x1, z1), (x, z) = begun, piece.start, piece.end
            code, centre, begun = "G01", "", piece.end
            if piece.centre is not None:
                i, k = piece.centre[0] - x0, piece.centre[1] - z0
                # z to the right, x up: the centre lies to the left of the last quarter.
                way = (piece.centre[0] - x1) * (z - z1) - (piece.centre[1] - z1) * (x - x1)
                code, centre = f"G0{3 if way > 0 else 2}", f" I{i:.4f} K{k:.4f}"
            lines.append(f"{code} X{2 * x:.4f} Z{z:.4f}{centre}")
        return "\n".join([*lines, "N2 G01"])

    def program(self, cycle: str, allowance: tuple[float, float], feeds_down: bool, *, pockets: bool = False) -> str:
        """All of it."""
        u, w = allowance
        first, code = cycle, cycle[:3]
        return (
            f"G21 G18\nG00 X{2 * self.start[0]:.4f} Z{self.start[1]:.4f}\n{first}\n"
            f"{code} P1 Q2 U{2 * u:.4f} W{w:.4f} F.3\n{self.blocks(feeds_down, pockets=pockets)}\nM30\n"
        )

    def own(self, points: Array) -> Array:
        """(along, deep) of positions (n, 3) from the start."""
        deep, along = (points[:, 2], points[:, 0]) if self.facing else (points[:, 0], points[:, 2])
        return np.column_stack([self.signs[1] * along, self.signs[0] * deep])


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


HALVES: Final = st.sampled_from([0.5, 1.0, 2.0]).map(lambda r: [(r, r, (0.0, r)), (-r, r, (-r, 0.0))])
"""Half turns, as two pieces about one centre."""


@st.composite
def pocketed(draw: st.DrawFn) -> list[Piece]:
    """Contours (deep, along) from the cycle's start on that run on, and go down and come out as they like.

    The first piece is the first block's, which may lead nowhere.
    """
    deep, along = draw(st.integers(0, 24)) / 4, draw(st.integers(0, 4)) / 2
    pieces = [Piece((0.0, 0.0), (deep, along))]
    for _ in range(draw(st.integers(2, 7))):
        steps = draw(st.one_of(_steps().map(lambda step: [step]), HALVES))
        sign = draw(st.sampled_from([-1, 1]))
        sign = sign if 0 <= deep - sign * steps[0][0] <= 14 else -sign
        slit = steps[0][1] == 0 and pieces[-1].end[1] == pieces[-1].start[1]
        if slit or not 0 <= deep - sign * steps[0][0] <= 14:
            continue
        for out, on, about in steps:
            start, end = (deep, along), (deep - sign * out, along + on)
            pieces.append(Piece(start, end, about and (deep - sign * about[0], along + about[1])))
            deep, along = end
    return pieces


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


OFF_LEVELS: Final = st.sampled_from([0.0, 0.0313])
"""Taken off the depth of cut: then no level is at the height of a piece of the contour."""


@given(
    pocketed(), st.booleans(), st.booleans(), st.tuples(signs, signs), allowances, COARSE, OFF_LEVELS, st.integers(0, 4)
)
def test_pockets_are_cleared_level_by_level(
    shape: list[Piece],
    facing: bool,
    feeds_down: bool,
    inwards_onwards: tuple[int, int],
    allowance: tuple[float, float],
    depth: float,
    off_levels: float,
    escape: int,
) -> None:
    """Outside and inside, along either axis; a level at the height of a piece of the contour is no cut of its own."""
    assume(shape[-1].end[1] > shape[-1].start[1] and max(piece.end[0] for piece in shape) > 0)
    depth -= off_levels
    words = Words(shape[1:], facing, *inwards_onwards, (40.0, 3.0))
    said = f"G72 W{depth:.4f} R{escape / 4:.4f}" if facing else f"G71 U{depth:.4f} R{escape / 4:.4f}"
    path = read_program(words.program(said, allowance, feeds_down, pockets=True).encode(), "fanuc-lathe").run()
    assert {found.severity for found in path.findings} <= {"note"}
    off = (words.start[0] + allowance[0], 0.0, words.start[1] + allowance[1])
    moves = [
        (kind, words.own(points - off)) for kind, points in sampled(path, np.flatnonzero(path.line == 4)[1:-1].tolist())
    ]
    assert_cleared(moves, shape, depth, stock_first=feeds_down, ordered=bool(off_levels))
