"""The turned outline in a view as it is drawn: both halves, edges of shoulders across the part, lines apart."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from trueloop.formats.cad.dxf_chain import Segment
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_building import mapped, part_of
from trueloop.geometry.curve_crossings import sign_changes
from trueloop.geometry.feature import Arc, Feature, Line, Point


@dataclass(frozen=True)
class Half:
    """The upper half of a drawing, and how much of the lower one was left out: what mirrors the upper one, what not."""

    segments: tuple[Segment, ...]
    mirrored: int
    unlike: int


@dataclass(frozen=True)
class Outline:
    """The outermost way from axis to axis, and how many pieces of the view lie inside it."""

    chain: tuple[Segment, ...]
    inside: int


def upper_half(segments: Sequence[Segment], within_mm: float) -> Half:
    """What is drawn above the axis, cut where it crosses it. A drawing of the lower half alone is turned up."""
    pieces = [piece for segment in segments for piece in _cut(segment, _crossings(segment.feature), within_mm)]
    upper, lower = list[Segment](), list[Segment]()
    for piece in pieces:
        at = float(piece.feature.point_mm(piece.feature.length_mm / 2)[0])
        (upper if at > 0 else lower).append(piece)
    turned = [replace(piece, feature=_mirrored(piece.feature)) for piece in lower]
    if not upper:
        return Half(tuple(turned), 0, 0)
    like = sum(any(alike(piece.feature, other.feature, within_mm) for other in upper) for piece in turned)
    return Half(tuple(upper), like, len(turned) - like)


def outlines(segments: Sequence[Segment], within_mm: float) -> list[Outline]:
    """Of every connected drawing above the axis that meets it in two places: the way along its outside, from the left.

    Ends that meet a line between its ends cut it there; what leads nowhere is dropped.
    """
    ends = [end for segment in segments for end in segment.ends]
    pieces = [
        (source, piece)
        for source, segment in enumerate(segments)
        for piece in _cut(segment, [end for end in ends if _near(segment.feature, end, within_mm)], within_mm)
    ]
    graph = _Graph([piece for _, piece in pieces], within_mm)
    found = []
    for component in graph.components():
        if (walked := graph.outside(component)) is not None:
            joined = _joined([(pieces[index][0], segment) for index, segment in walked], segments)
            found.append(Outline(tuple(joined), len(component) - len(walked)))
    return sorted(found, key=lambda outline: outline.chain[0].feature.start_mm[1])


class _Graph:
    """Pieces as edges between the points where their ends meet."""

    def __init__(self, pieces: Sequence[Segment], within_mm: float) -> None:
        self.pieces, self.within_mm = pieces, within_mm
        self.points: list[Point] = []
        self.ends = [tuple(self._node(end) for end in piece.ends) for piece in pieces]
        self.at: list[list[int]] = [[] for _ in self.points]
        for index, (a, b) in enumerate(self.ends):
            self.at[a].append(index)
            self.at[b].append(index)

    def _node(self, point: Point) -> int:
        for node, known in enumerate(self.points):
            if math.dist(known, point) <= self.within_mm:
                return node
        self.points.append(point)
        return len(self.points) - 1

    def on_axis(self, node: int) -> bool:
        return abs(self.points[node][0]) <= self.within_mm

    def components(self) -> Iterator[set[int]]:
        left = set(range(len(self.pieces)))
        while left:
            found, new = set[int](), {min(left)}
            while new:
                found |= new
                new = {other for index in new for node in self.ends[index] for other in self.at[node]} - found
            left -= found
            yield found

    def outside(self, component: set[int]) -> list[tuple[int, Segment]] | None:
        """The way from the axis at the left to the axis again, keeping to the left at every point; None where there
        is none.
        """
        edges = self._leading_on(component)
        touching = sorted(
            {node for index in edges for node in self.ends[index] if self.on_axis(node)},
            key=lambda node: self.points[node][1],
        )
        if len(touching) < 2:
            return None
        node, heading, way = touching[0], 0.0, list[tuple[int, Segment]]()
        while not way or not self.on_axis(node):
            onward = [index for index in self.at[node] if index in edges and not (way and index == way[-1][0])]
            if not onward or len(way) > len(edges):
                return None
            ways = [(index, self._from(index, node)) for index in onward]
            index, segment = max(ways, key=lambda one: _turn(heading, _heading(one[1].feature, first=True)))
            way.append((index, segment))
            heading = _heading(segment.feature, first=False)
            a, b = self.ends[index]
            node = b if a == node else a
        return way if node != touching[0] else None

    def _leading_on(self, component: set[int]) -> set[int]:
        """Without the pieces that end in the open, one after the other."""
        edges = set(component)
        while True:
            loose = {
                index
                for index in edges
                for node in self.ends[index]
                if not self.on_axis(node) and sum(other in edges for other in self.at[node]) == 1
            }
            if not loose:
                return edges
            edges -= loose

    def _from(self, index: int, node: int) -> Segment:
        piece = self.pieces[index]
        return piece if self.ends[index][0] == node else piece.reversed()


def _heading(feature: Feature, *, first: bool) -> float:
    """Direction of travel at the beginning or the end, by a chord short enough: tangents cannot tell a line from an arc
    that leaves it.
    """
    short = min(0.1, feature.length_mm / 4)
    s = (0.0, short) if first else (feature.length_mm - short, feature.length_mm)
    (x0, z0), (x1, z1) = feature.point_mm(s[0]), feature.point_mm(s[1])
    return math.atan2(x1 - x0, z1 - z0)


def _turn(before: float, after: float) -> float:
    """How far one turns to the left, from −π (back, right about) to π."""
    return (after - before + math.pi) % (2 * math.pi) - math.pi


def _crossings(feature: Feature) -> list[Point]:
    """Where a line, a circle or a curve crosses the axis."""
    if isinstance(feature, Curve):
        return [(0.0, float(z)) for _, z in feature.point_mm(sign_changes(feature, lambda points: points[:, 0]))]
    if isinstance(feature, Line):
        (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
        return [(0.0, z0 + (z1 - z0) * x0 / (x0 - x1))] if x0 * x1 < 0 else []
    (x, z), r = feature.centre_mm, feature.radius_mm
    aside = math.sqrt(max(r * r - x * x, 0.0))
    return [(0.0, z - aside), (0.0, z + aside)] if abs(x) < r else []


def _near(feature: Feature, point: Point, within_mm: float) -> bool:
    return abs(float(feature.locate(point)[1])) <= within_mm


def _cut(segment: Segment, points: Sequence[Point], within_mm: float) -> list[Segment]:
    """The segment cut at points on it, those at its ends aside."""
    feature = segment.feature
    where = (float(feature.locate(point)[0]) for point in points)
    inner: list[float] = []
    for s in sorted(s for s in where if within_mm < s < feature.length_mm - within_mm):
        if not inner or s - inner[-1] > within_mm:
            inner.append(s)
    at = [0.0, *inner, feature.length_mm]
    return [replace(segment, feature=_part(feature, a, b)) for a, b in pairwise(at)] if inner else [segment]


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


def _joined(way: Sequence[tuple[int, Segment]], segments: Sequence[Segment]) -> Iterator[Segment]:
    """Pieces of one drawn line that follow each other made one again."""
    k = 0
    while k < len(way):
        source, last = way[k][0], k
        while last + 1 < len(way) and way[last + 1][0] == source:
            last += 1
        first, end = way[k][1].feature, way[last][1].feature.end_mm
        if isinstance(first, Arc):
            sweep = math.fsum(part.feature.sweep_rad for _, part in way[k : last + 1] if isinstance(part.feature, Arc))
            yield replace(segments[source], feature=replace(first, end_mm=end, sweep_rad=sweep))
        elif isinstance(first, Curve):
            whole = segments[source].feature
            from_mm, to_mm = (float(whole.locate(point)[0]) for point in (first.start_mm, end))
            yield replace(segments[source], feature=_part(whole, from_mm, to_mm))
        else:
            yield replace(segments[source], feature=replace(first, end_mm=end))
        k = last + 1


def cut_at(feature: Feature, points: Sequence[Point], within_mm: float) -> list[Feature]:
    """The feature in pieces, cut at points that lie on it."""
    return [piece.feature for piece in _cut(Segment(feature, ""), points, within_mm)]


def moved(feature: Feature, by_mm: float) -> Feature:
    """The feature moved along x."""

    def out(point: Point) -> Point:
        return point[0] + by_mm, point[1]

    if isinstance(feature, Curve):
        return mapped(feature, np.eye(2), np.array([by_mm, 0.0]))
    if isinstance(feature, Line):
        return Line(feature.name, out(feature.start_mm), out(feature.end_mm))
    return replace(
        feature, start_mm=out(feature.start_mm), end_mm=out(feature.end_mm), centre_mm=out(feature.centre_mm)
    )


def _mirrored(feature: Feature) -> Feature:
    def up(point: Point) -> Point:
        return -point[0], point[1]

    if isinstance(feature, Curve):
        return mapped(feature, np.diag([-1.0, 1.0]), np.zeros(2))
    if isinstance(feature, Line):
        return Line(feature.name, up(feature.start_mm), up(feature.end_mm))
    return Arc(feature.name, up(feature.start_mm), up(feature.end_mm), up(feature.centre_mm), -feature.sweep_rad)


def alike(a: Feature, b: Feature, within_mm: float) -> bool:
    """Whether two features run through the same places, in either direction."""
    middle = math.dist(a.point_mm(a.length_mm / 2), b.point_mm(b.length_mm / 2))
    same = math.dist(a.start_mm, b.start_mm) + math.dist(a.end_mm, b.end_mm)
    turned = math.dist(a.start_mm, b.end_mm) + math.dist(a.end_mm, b.start_mm)
    return middle <= within_mm and min(same, turned) <= 2 * within_mm
