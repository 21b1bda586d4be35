"""Pieces of a section, their material on the right, chained to contours: the outside, and what goes into the part."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, compress, pairwise

import numpy as np
from scipy.optimize import brentq
from scipy.spatial import KDTree

from trueloop.formats.cad.turned_faces import WITHIN_MM
from trueloop.geometry.curve import Curve, part_of
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.intersection import intersections
from trueloop.geometry.profile import Side


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a meridian, its material on the right, which there is at `share` of the angles about the axis."""

    feature: Feature
    share: float = 1.0
    layer: str = ""


@dataclass(frozen=True)
class Contour:
    """A chain of pieces along the outside or a bore, in the direction of travel: the material is on the right.

    `body` is the name of its solid. An end is open where what is not turned cuts the chain off: `open_at`.
    """

    side: Side
    pieces: tuple[Piece, ...]
    body: str
    open_at: tuple[Point, ...] = ()
    by_most: bool = False

    @property
    def ends(self) -> tuple[Point, Point]:
        """Returns its first and last point."""
        return self.pieces[0].feature.start_mm, self.pieces[-1].feature.end_mm


def chained(pieces: Sequence[Piece], body: str, within_mm: float = WITHIN_MM) -> list[Contour]:
    """Chains pieces in any order into contours; ends within `within_mm` meet; open where one ends inside."""
    if not pieces:
        return []
    z = [z for piece in pieces for _, z in (piece.feature.start_mm, piece.feature.end_mm)]
    poles = {
        k: list(_poles(one.feature, within_mm)) for k, one in enumerate(pieces) if not isinstance(one.feature, Line)
    }
    z += [z for own in poles.values() for _, z in own]
    low, high = min(z), max(z)
    extremes = {k: [at for at in own if min(at[1] - low, high - at[1]) < within_mm] for k, own in poles.items()}
    if any(extremes.values()):
        parts = (cut_at(one.feature, extremes.get(k, ()), within_mm) for k, one in enumerate(pieces))
        pieces = [replace(one, feature=part) for one, of in zip(pieces, parts, strict=True) for part in of]
    chains = _chains(pieces, within_mm)
    return [found for chain in chains for found in _sides(chain, (low, high), body, within_mm)]


def _poles(feature: Feature, within_mm: float) -> Iterator[Point]:
    """Where an arc or a curve runs straight across, between its ends: its lowest and highest z are there."""
    if isinstance(feature, Arc):
        (x, z), radius = feature.centre_mm, feature.radius_mm
        both = [(x, z - radius), (x, z + radius)]
        inside = (within_mm < s < feature.length_mm - within_mm for s in feature.locate(both)[0].tolist())
        yield from compress(both, inside)
    elif isinstance(feature, Curve):
        s = feature.sampled_mm[0]
        along = feature.tangent(s)[:, 1]
        for k in np.flatnonzero(along[:-1] * along[1:] < 0):
            x, z = feature.point_mm(brentq(lambda at: float(feature.tangent(at)[1]), s[k], s[k + 1], xtol=1e-12))
            yield float(x), float(z)


def crossing(contours: Sequence[Contour], within_mm: float = WITHIN_MM) -> Point | None:
    """Returns where two pieces of a section cross between their ends, as those of a solid never do; else None."""
    features = [piece.feature for contour in contours for piece in contour.pieces]
    for a, b in combinations(features, 2):
        for point in intersections(a, b):
            along = [(float(feature.locate(point)[0]), feature.length_mm) for feature in (a, b)]
            if all(within_mm < s < length - within_mm for s, length in along):
                return point
    return None


def _chains(pieces: Sequence[Piece], within_mm: float) -> Iterator[list[Piece]]:
    """Pieces head to tail, first those nothing leads to; of several the sharpest right turn: on the same material."""
    starts = np.array([piece.feature.start_mm for piece in pieces])
    ends = np.array([piece.feature.end_mm for piece in pieces])
    near = KDTree(ends).sparse_distance_matrix(KDTree(starts), 2 * within_mm, output_type="ndarray")
    after: list[list[int]] = [[] for _ in pieces]
    for end, start in sorted(zip(near["i"].tolist(), near["j"].tolist(), strict=True)):
        after[end].append(start)
    led_to, done = set(near["j"].tolist()), set[int]()
    for first in sorted(range(len(pieces)), key=lambda k: k in led_to):
        if first in done:
            continue
        chain = [first]
        done.add(first)
        while onward := [k for k in after[chain[-1]] if k not in done]:
            chain.append(_rightmost(pieces, chain[-1], onward))
            done.add(chain[-1])
        yield [pieces[k] for k in chain]


def _rightmost(pieces: Sequence[Piece], last: int, onward: Sequence[int]) -> int:
    return onward[0] if len(onward) == 1 else max(onward, key=lambda k: _right(pieces[last].feature, pieces[k].feature))


def _right(before: Feature, after: Feature) -> float:
    """How far one turns to the right, rad."""
    (x0, z0), (x1, z1) = _along(before, before.length_mm), _along(after, 0.0)
    return math.atan2(x0 * z1 - z0 * x1, x0 * x1 + z0 * z1)


def _along(feature: Feature, arc_length_mm: float) -> Point:
    """A tangent; that of a line by floats, of any length: a drawing has many."""
    if isinstance(feature, Line):
        (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
        return x1 - x0, z1 - z0
    x, z = feature.tangent(arc_length_mm)
    return float(x), float(z)


def _sides(chain: Sequence[Piece], extremes: tuple[float, float], body: str, within_mm: float) -> Iterator[Contour]:
    """The outside of a chain is what it runs along from the chuck end to the last it touches of the free end."""
    closed = math.dist(chain[0].feature.start_mm, chain[-1].feature.end_mm) <= 2 * within_mm
    chain = _from_low(chain, extremes, within_mm) if closed else chain
    first, last = _outside(chain, extremes, within_mm)
    for side, part in ((Side.INSIDE, chain[:first]), (Side.OUTSIDE, chain[first:last]), (Side.INSIDE, chain[last:])):
        if part:
            yield _contour(side, _joined(part, within_mm), extremes, body, within_mm)


def _outside(chain: Sequence[Piece], extremes: tuple[float, float], within_mm: float) -> tuple[int, int]:
    low, high = extremes
    lows = [k for k, piece in enumerate(chain) if abs(piece.feature.start_mm[1] - low) < within_mm]
    lows += [len(chain)] if abs(chain[-1].feature.end_mm[1] - low) < within_mm else []
    highs = [0] if abs(chain[0].feature.start_mm[1] - high) < within_mm else []
    highs += [k for k, piece in enumerate(chain, 1) if abs(piece.feature.end_mm[1] - high) < within_mm]
    if not lows and not highs:
        rises = chain[-1].feature.end_mm[1] > chain[0].feature.start_mm[1]
        return (0, len(chain)) if rises else (0, 0)
    last = max(highs, default=len(chain))
    before = [k for k in lows if k <= last]
    return min(before, default=0), last


def _from_low(chain: Sequence[Piece], extremes: tuple[float, float], within_mm: float) -> list[Piece]:
    """A closed chain begun where the way back from the free end first touches the chuck end again."""
    (low, high), came_from, begin = extremes, "", 0
    for k in [*range(len(chain)), *range(len(chain))]:
        z = chain[k].feature.start_mm[1]
        at = "low" if abs(z - low) < within_mm else "high" if abs(z - high) < within_mm else ""
        if at == "low" and came_from == "high":
            begin = k
        came_from = at or came_from
    return [*chain[begin:], *chain[:begin]]


def _contour(
    side: Side, pieces: Sequence[Piece], extremes: tuple[float, float], body: str, within_mm: float
) -> Contour:
    ends = (pieces[0].feature.start_mm, pieces[-1].feature.end_mm)
    cavity = math.dist(*ends) <= 2 * within_mm
    open_at = tuple(
        (x, z) for x, z in ends if x > within_mm and min(abs(z - at) for at in extremes) > within_mm and not cavity
    )
    return Contour(side, tuple(pieces), body, open_at)


def _joined(pieces: Sequence[Piece], within_mm: float) -> list[Piece]:
    """Pieces of one line or one circle that follow each other made one."""
    found = [pieces[0]]
    for piece in pieces[1:]:
        one = _one(found[-1], piece, within_mm)
        found[-1:] = [one] if one else [found[-1], piece]
    return found


def _one(first: Piece, second: Piece, within_mm: float) -> Piece | None:
    a, b, share = first.feature, second.feature, max(first.share, second.share)
    if isinstance(a, Line) and isinstance(b, Line):
        return Piece(Line(a.name, a.start_mm, b.end_mm), share, first.layer) if _straight(a, b, within_mm) else None
    if math.dist(a.end_mm, b.start_mm) > 2 * within_mm:
        return None
    if isinstance(a, Arc) and isinstance(b, Arc):
        apart = math.dist(a.centre_mm, b.centre_mm) + abs(a.radius_mm - b.radius_mm)
        same = apart < within_mm and a.sweep_rad * b.sweep_rad > 0
        whole_arc = replace(a, end_mm=b.end_mm, sweep_rad=a.sweep_rad + b.sweep_rad)
        return replace(first, feature=whole_arc, share=share) if same else None
    return None


def _straight(a: Line, b: Line, within_mm: float) -> bool:
    """Returns whether two lines continue each other; by floats: a drawing has many."""
    (x0, z0), (x1, z1), (x2, z2), (x3, z3) = a.start_mm, a.end_mm, b.start_mm, b.end_mm
    if math.hypot(x2 - x1, z2 - z1) > 2 * within_mm:
        return False
    ax, az, bx, bz, x, z = x1 - x0, z1 - z0, x3 - x2, z3 - z2, x3 - x0, z3 - z0
    aside = abs(ax * z - az * x) < within_mm * math.hypot(x, z)
    return aside and math.atan2(ax * bz - az * bx, ax * bx + az * bz) < 1


def cut_at(feature: Feature, points: Sequence[Point], within_mm: float) -> list[Feature]:
    """Returns the feature in pieces, cut at points that lie on it, those at its ends aside."""
    where = (float(feature.locate(point)[0]) for point in points)
    inner: list[float] = []
    for s in sorted(s for s in where if within_mm < s < feature.length_mm - within_mm):
        if not inner or s - inner[-1] > within_mm:
            inner.append(s)
    at = [0.0, *inner, feature.length_mm]
    return [_part(feature, a, b) for a, b in pairwise(at)] if inner else [feature]


def _part(feature: Feature, low: float, high: float) -> Feature:
    if isinstance(feature, Curve):
        return part_of(feature, low, high)
    start, end = (
        tuple(map(float, feature.point_mm(s))) if 0 < s < feature.length_mm else whole
        for s, whole in ((low, feature.start_mm), (high, feature.end_mm))
    )
    if isinstance(feature, Line):
        return replace(feature, start_mm=(start[0], start[1]), end_mm=(end[0], end[1]))
    share = (high - low) / feature.length_mm
    return Arc(feature.name, (start[0], start[1]), (end[0], end[1]), feature.centre_mm, feature.sweep_rad * share)


def alike(a: Feature, b: Feature, within_mm: float) -> bool:
    """Returns whether two features coincide, in either direction."""
    middle = math.dist(a.point_mm(a.length_mm / 2), b.point_mm(b.length_mm / 2))
    same = math.dist(a.start_mm, b.start_mm) + math.dist(a.end_mm, b.end_mm)
    turned = math.dist(a.start_mm, b.end_mm) + math.dist(a.end_mm, b.start_mm)
    return middle <= within_mm and min(same, turned) <= 2 * within_mm


def middle_mm(feature: Feature) -> Point:
    """Returns the point half way along; that of a line by floats: a drawing has many."""
    if isinstance(feature, Line):
        (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
        return (x0 + x1) / 2, (z0 + z1) / 2
    x, z = feature.point_mm(feature.length_mm / 2)
    return float(x), float(z)
