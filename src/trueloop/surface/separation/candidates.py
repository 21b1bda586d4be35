"""Which sizes a spline surface may have at given places, and the search for the likeliest of them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.surface.separation.places import Places
from trueloop.surface.separation.spline_surface import Size

DEGREES: Final = (2, 3)
"""Degree 2 is the least that keeps second derivatives finite where pieces meet [MPM §5]."""
FULLEST: Final = 0.8
"""Most control points a direction, as a share of the rows measured: along both, 64 % of the places' freedom is then
followed, and the other third is what the tests judge by.
"""
SEEN: Final = 900
"""So many control points are tried in any case, and twice those of the best before the search ends: 30 × 30 are more
than 25 × 25 places can have, so that only scans are searched in part.
"""


def sizes(places: Places, degrees: Sequence[int] = DEGREES) -> Iterator[Size]:
    """Sizes by growing number of control points, spaced alike along both sides; at each, degrees in ascending order."""
    length = places.sides_mm
    if places.rows is not None and places.columns is not None:
        most = (int(FULLEST * len(places.rows)), int(FULLEST * len(places.columns)))
    else:
        most_in_all = FULLEST**2 * len(places.u)
        ratio = np.sqrt(length[0] / length[1])
        most = (int(np.sqrt(most_in_all) * ratio), int(np.sqrt(most_in_all) / ratio))
    shorter = min(length)
    least = min(degrees) + 1
    for count in range(least, max(most) + 1):
        rows, columns = (
            min(max(least, round(count * side / shorter)), top) for side, top in zip(length, most, strict=True)
        )
        for degree in degrees:
            if min(rows, columns) > degree:
                yield Size(rows, columns, degree)
        if (rows, columns) == most:
            return


def thinner(size: Size) -> list[Size]:
    """Sizes with one control point fewer along one direction."""
    fewer = (replace(size, rows=size.rows - 1), replace(size, columns=size.columns - 1))
    return [size for size in fewer if min(size.rows, size.columns) > size.degree]


def thicker(size: Size) -> list[Size]:
    """Sizes with one control point more along one direction."""
    return [replace(size, rows=size.rows + 1), replace(size, columns=size.columns + 1)]


def most_likely(candidates: Sequence[Size], likely: Callable[[Size], float]) -> Size:
    """The likeliest of the candidates, in order; then with more or fewer control points along one direction alone."""
    best, most = candidates[0], candidates[-1]
    for size in candidates:
        if size.controls > max(SEEN, 2 * best.controls):
            break
        best = max(best, size, key=likely)

    def around(size: Size) -> list[Size]:
        either = thinner(size) + thicker(size)
        return [near for near in either if near.rows <= most.rows and near.columns <= most.columns]

    return climbed(best, likely, around, lambda _: True)


def climbed(
    best: Size,
    likely: Callable[[Size], float],
    neighbours: Callable[[Size], list[Size]],
    allowed: Callable[[Size], bool],
) -> Size:
    """From neighbour to allowed neighbour as long as that is more likely."""
    while True:
        better = [size for size in neighbours(best) if likely(size) > likely(best) and allowed(size)]
        if not better:
            return best
        best = max(better, key=likely)
