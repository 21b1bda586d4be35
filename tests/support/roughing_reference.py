"""Roughing cycles from their definition, slowly: every cut ends where the contour, moved by the allowance, stands.

The contour and all results are points (x, z) in mm, x a radius. Where a cut ends is found by bisection along each piece
of the contour, in coordinates of the machine: no formula for a crossing, no sign turned round.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

Point = tuple[float, float]
Row = tuple[str, float, float]
HALVINGS: Final = 200


@dataclass(frozen=True)
class Piece:
    """A line, or with `centre` the shorter arc about it."""

    start: Point
    end: Point
    centre: Point | None = None

    def at(self, share: float) -> Point:
        """The point that share of the way along."""
        (x0, z0), (x1, z1) = self.start, self.end
        if self.centre is None:
            return x0 + share * (x1 - x0), z0 + share * (z1 - z0)
        cx, cz = self.centre
        first = math.atan2(x0 - cx, z0 - cz)
        turn = math.remainder(math.atan2(x1 - cx, z1 - cz) - first, math.tau)
        radius, angle = math.hypot(x0 - cx, z0 - cz), first + share * turn
        return cx + radius * math.sin(angle), cz + radius * math.cos(angle)

    def moved(self, by: Point) -> "Piece":
        """The same piece elsewhere."""
        centre = None if self.centre is None else _sum(self.centre, by)
        return Piece(_sum(self.start, by), _sum(self.end, by), centre)

    def row(self) -> Row:
        """The cut along it."""
        return "line" if self.centre is None else "arc", *self.end


@dataclass(frozen=True)
class Cycle:
    """A roughing cycle: where the tool stands, what it cuts down to, and what its words say, lengths on the radius."""

    start: Point
    contour: Sequence[Piece]
    allowance: Point
    feeds_down: bool = False

    @property
    def down(self) -> str:
        """How the tool goes down."""
        return "line" if self.feeds_down else "rapid"

    def along_contour(self, off: Point) -> list[Row]:
        """One cut along the contour, off by as much."""
        return [(self.down, *_sum(self.contour[0].start, off)), *(piece.moved(off).row() for piece in self.contour)]


def cuts(cycle: Cycle, depth: float, escape: float, *, facing: bool = False) -> list[Row]:
    """G71, or with `facing` G72: straight cuts deeper by `depth` each, then one along the contour, and back."""
    along, deep = (0, 1) if facing else (1, 0)
    begin = _sum(cycle.start, cycle.allowance)
    contour = [piece.moved(cycle.allowance) for piece in cycle.contour]
    into = math.copysign(1.0, contour[0].start[deep] - begin[deep])
    onward = math.copysign(1.0, contour[-1].end[along] - begin[along])
    rows: list[Row] = [("rapid", *begin)]
    number = 1
    while into * (contour[0].start[deep] - (begin[deep] + into * number * depth)) >= 1e-9:
        level = begin[deep] + into * number * depth
        number += 1

        def point(across: float, height: float) -> Point:
            return (across, height) if facing else (height, across)

        end = _stop(contour, level, along, deep, into)
        rows.append((cycle.down, *point(begin[along], level)))
        if onward * (end - begin[along]) > 1e-9:
            rows.append(("line", *point(end, level)))
            rows.append(("rapid", *point(end - onward * escape, level - into * escape)))
            rows.append(("rapid", *point(begin[along], level - into * escape)))
    return [*rows, *cycle.along_contour(cycle.allowance), ("rapid", *cycle.start)]


def pattern(cycle: Cycle, relief: Point, passes: int) -> list[Row]:
    """G73: the contour so often, the first time off by relief and allowance, the last by the allowance."""
    rows: list[Row] = []
    for number in range(passes):
        share = 1.0 - number / (passes - 1) if passes > 1 else 0.0
        off = _sum(cycle.allowance, (relief[0] * share, relief[1] * share))
        rows += [("rapid", *_sum(cycle.start, off)), *cycle.along_contour(off)]
    return [*rows, ("rapid", *cycle.start)]


def _stop(contour: Sequence[Piece], level: float, along: int, deep: int, into: float) -> float:
    """Where a cut at a level meets the contour: the first place at which that is not deeper any more."""
    for piece in contour:
        if into * (piece.end[deep] - level) < 0:
            if into * (piece.start[deep] - level) <= 0:
                return piece.start[along]
            low, high = 0.0, 1.0
            for _ in range(HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if into * (piece.at(middle)[deep] - level) > 0 else (low, middle)
            return piece.at(low)[along]
    return contour[-1].end[along]


def gouges_mm(rows: Sequence[Row], cycle: Cycle, *, facing: bool = False) -> Iterator[float]:
    """How far the ends of moves lie below the contour moved by the allowance, where they lie below it."""
    along, deep = (0, 1) if facing else (1, 0)
    contour = [piece.moved(cycle.allowance) for piece in cycle.contour]
    into = math.copysign(1.0, contour[0].start[deep] - cycle.start[deep])
    for _, *place in rows:
        for piece in contour:
            ends = sorted((piece.start[along], piece.end[along]))
            if ends[0] < place[along] < ends[1]:
                points = [piece.at(share / 500) for share in range(501)]
                nearest = min(points, key=lambda point: abs(point[along] - place[along]))
                yield into * (place[deep] - nearest[deep])


def _sum(a: Point, b: Point) -> Point:
    return a[0] + b[0], a[1] + b[1]


def stock_removal(cycle: Cycle, depth: float, lift: float, *, facing: bool = False) -> list[Row]:
    """CYCLE95: equal infeeds of at most `depth`, each cut to the contour and along that up to the level above.

    The contour begins at its deepest. `cycle.start` is not used: the cycle works out where the tool stands.
    """
    along, deep = (0, 1) if facing else (1, 0)
    contour = [piece.moved(cycle.allowance) for piece in cycle.contour]
    first, top = contour[0].start, contour[-1].end[deep]
    into = math.copysign(1.0, first[deep] - top)
    onward = math.copysign(1.0, contour[-1].end[along] - first[along])

    def point(across: float, height: float) -> Point:
        return (across, height) if facing else (height, across)

    stand = (first[along] - onward * lift, top - into * lift)
    count = math.ceil(abs(first[deep] - top) / depth - 1e-9)
    rows: list[Row] = [("rapid", *point(*stand))]
    for number in range(1, count + 1):
        level, above = (top + (first[deep] - top) * k / count for k in (number, number - 1))
        begin, end = (_stop(contour, height, along, deep, into) for height in (level, above))
        if number == 1:
            end = next(piece.end[along] for piece in contour if abs(piece.end[deep] - top) < 1e-9)
        if number == count:
            begin = first[along]
        flat = [p.end[along] for p in contour if max(abs(p.end[deep] - level), abs(p.start[deep] - level)) < 1e-9]
        begin = flat[-1] if flat else begin
        rows += [("rapid", *point(stand[0], level)), ("line", *point(begin, level))]
        for piece in contour:
            low, high = sorted((piece.start[deep], piece.end[deep]), key=lambda height: into * height)
            if into * (level - low) > 1e-9 and into * (high - above) > 1e-9:
                to = piece.end if into * (piece.end[deep] - above) > -1e-9 else point(end, above)
                rows.append((piece.row()[0], *to))
            elif high == low and into * (level - low) > 1e-9 and into * (low - above) > 1e-9:
                rows.append(("line", *piece.end))
        last = (rows[-1][1], rows[-1][2])
        off = (last[along] - onward * lift, last[deep] - into * lift)
        rows += [("rapid", *point(*off)), ("rapid", *point(stand[0], off[1]))]
    return [*rows, ("rapid", *point(*stand))]
