"""Feed moves for tests: a centre path as a program would cut it."""

from collections.abc import Iterable, Sequence

import numpy as np

from tests.support.profiles import simple
from trueloop.geometry.feature import Feature, Line, Point
from trueloop.nc.match.matching import ContourMatch
from trueloop.nc.program.along import FeedMove


def cut(paths: Iterable[Feature], first: int = 0, chain: int = 0) -> list[FeedMove]:
    """One uninterrupted chain; move k stands in line 10 (k + 1)."""
    return [FeedMove(k, 10 * (k + 1), chain, simple(path)) for k, path in enumerate(paths, start=first)]


def backwards(paths: Sequence[Feature]) -> list[Feature]:
    return [path.reversed() for path in reversed(paths)]


def to(start: Point, end: Point) -> Line:
    return Line("", start, end)


def largest_deviation_mm(match: ContourMatch) -> float:
    """The largest |deviation| of the moves from the features they cut, at 65 places of each."""
    shares = np.linspace(0.0, 1.0, 65)
    return max(float(np.abs(one.deviation_mm(shares * one.feature.length_mm)).max()) for one in match.features)
