"""The halves of a view as it is drawn, cut where its lines meet, as a graph."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from trueloop.arrays import Array
from trueloop.formats.cad.box_index import Pairs, overlapping
from trueloop.formats.cad.dxf_chain import Segment
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_building import mapped, part_of
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.intersection import intersections, sign_changes

PARALLEL: Final = 1e-13
"""Sine of the angle below which two lines count as parallel."""
BOXED_AT: Final = 17
"""Places of a curved feature that say how far it reaches."""


@dataclass(frozen=True)
class Half:
    """One half of a view, above the axis or turned up from below it; `twins` of its pieces are drawn on the other side
    too, `unlike` pieces of the other side are not like any of it.
    """

    segments: tuple[Segment, ...]
    twins: tuple[Feature, ...]
    unlike: int
    turned_up: bool = False

    @property
    def mirrored(self) -> int:
        """Returns the number of pieces drawn on both sides."""
        return len(self.twins)

    def is_mirrored(self, place: Point, within_mm: float) -> bool:
        """Returns whether a piece at the place is drawn on the other side too."""
        for twin in self.twins:
            along, aside = (float(value) for value in twin.locate(place))
            if abs(aside) <= within_mm and -within_mm <= along <= twin.length_mm + within_mm:
                return True
        return False


def halves(segments: Sequence[Segment], within_mm: float) -> list[Half]:
    """Returns the drawing above the axis, cut where it crosses it, and that below, turned up, if it differs."""
    upper, lower = list[Segment](), list[Segment]()
    for segment in segments:
        for piece in _cut(segment, _crossings(segment.feature), within_mm):
            (upper if _place_of(piece.feature)[0] > 0 else lower).append(piece)
    turned = [replace(piece, feature=mapped_feature(piece.feature, _UP, np.zeros(2))) for piece in lower]
    if not upper:
        return [Half(tuple(turned), (), 0, turned_up=True)]
    like = _like(turned, upper, within_mm)
    twins = tuple(piece.feature for piece, is_like in zip(turned, like, strict=True) if is_like)
    above = Half(tuple(upper), twins, len(turned) - len(twins))
    return [above, Half(tuple(turned), twins, 0, turned_up=True)] if above.unlike else [above]


_UP: Final = np.diag([-1.0, 1.0])


def _like(pieces: Sequence[Segment], others: Sequence[Segment], within_mm: float) -> list[bool]:
    """Which of the pieces run through the same places as one of the others, in either direction."""
    if not pieces or not others:
        return [False] * len(pieces)
    tree = KDTree([_place_of(other.feature) for other in others])
    near = tree.query_ball_point([_place_of(piece.feature) for piece in pieces], 2 * within_mm)
    return [
        any(alike(piece.feature, others[k].feature, within_mm) for k in found)
        for piece, found in zip(pieces, near, strict=True)
    ]


def _place_of(feature: Feature) -> Point:
    if isinstance(feature, Line):
        (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
        return (x0 + x1) / 2, (z0 + z1) / 2
    x, z = feature.point_mm(feature.length_mm / 2)
    return float(x), float(z)


def cut_where_met(segments: Sequence[Segment], within_mm: float) -> list[Segment]:
    """Segments cut where others meet or cross them between their ends; what is drawn twice, once."""
    if not segments:
        return []
    ends = _ends(segments)
    low, high = ends.min(axis=1), ends.max(axis=1)
    for index, segment in enumerate(segments):
        if not isinstance(segment.feature, Line):
            low[index], high[index] = _box(segment.feature)
    points = np.concatenate([ends.reshape(-1, 2), _all_crossings(segments, ends, low, high)])
    pairs = overlapping(low - within_mm, high + within_mm, points, points)
    on = _points_on(segments, ends, pairs, points, within_mm)
    pieces: list[Segment] = []
    for index, segment in enumerate(segments):
        if index in on:
            pieces += _cut(segment, [(float(x), float(z)) for x, z in points[on[index]]], within_mm)
        else:
            pieces.append(segment)
    return _once(pieces, within_mm)


def _ends(segments: Sequence[Segment]) -> Array:
    """Starts and ends, (n, 2, 2)."""
    flat = [value for one in segments for end in one.ends for value in end]
    return np.array(flat, dtype=np.float64).reshape(-1, 2, 2)


def _once(pieces: Sequence[Segment], within_mm: float) -> list[Segment]:
    """The pieces without those that run, in either direction, through the places of an earlier one."""
    ends = _ends(pieces)
    exchanged = (ends[:, 0, 0] > ends[:, 1, 0]) | ((ends[:, 0, 0] == ends[:, 1, 0]) & (ends[:, 0, 1] > ends[:, 1, 1]))
    ends[exchanged] = ends[exchanged][:, ::-1]
    places = np.array([value for piece in pieces for value in _place_of(piece.feature)]).reshape(-1, 2)
    runs = np.rint(np.concatenate([ends.reshape(-1, 4), places], axis=1) / within_mm)
    order = np.lexsort(runs.T)  # stable: of equal rows the first comes first
    new = np.any(np.diff(runs[order], axis=0, prepend=np.nan) != 0, axis=1)
    return [pieces[k] for k in np.sort(order[new]).tolist()]


def _points_on(
    segments: Sequence[Segment], ends: Array, pairs: Pairs, points: Array, within_mm: float
) -> dict[int, list[int]]:
    """By segment, which points lie on it between its ends, of those whose box they are in."""
    lines = np.array([isinstance(segment.feature, Line) for segment in segments])
    start, end = ends[:, 0], ends[:, 1]
    length = np.array([segment.feature.length_mm for segment in segments])
    i, j = pairs[lines[pairs[:, 0]]].T
    direction, off = (end[i] - start[i]) / length[i, None], points[j] - start[i]
    along = np.sum(off * direction, axis=1)
    aside = off[:, 0] * direction[:, 1] - off[:, 1] * direction[:, 0]
    on = (np.abs(aside) <= within_mm) & (along > within_mm) & (along < length[i] - within_mm)
    found: dict[int, list[int]] = {}
    for segment, point in zip(i[on].tolist(), j[on].tolist(), strict=True):
        found.setdefault(segment, []).append(point)
    for segment in np.unique(pairs[~lines[pairs[:, 0]], 0]).tolist():
        near = pairs[pairs[:, 0] == segment, 1]
        along, aside = segments[segment].feature.locate(points[near])
        on = (np.abs(aside) <= within_mm) & (along > within_mm) & (along < length[segment] - within_mm)
        if np.any(on):
            found[segment] = near[on].tolist()
    return found


def _all_crossings(segments: Sequence[Segment], ends: Array, low: Array, high: Array) -> Array:
    """Where segments cross each other, (n, 2)."""
    features = [segment.feature for segment in segments]
    pairs = overlapping(low, high, low, high)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    lines = np.array([isinstance(feature, Line) for feature in features])
    both = lines[pairs].all(axis=1)
    found = [
        point
        for i, j in pairs[~both].tolist()
        for point in intersections(features[i], features[j])
        if all(0 < float(feature.locate(point)[0]) < feature.length_mm for feature in (features[i], features[j]))
    ]
    return np.concatenate([_line_crossings(ends, pairs[both]), np.array(found, dtype=np.float64).reshape(-1, 2)])


def _line_crossings(ends: Array, pairs: Pairs) -> Array:
    """Where pairs of lines cross between their ends, (n, 2)."""
    start, (i, j), along = ends[:, 0], pairs.T, ends[:, 1] - ends[:, 0]
    apart = start[j] - start[i]
    sine = _cross(along[i], along[j])
    length = np.linalg.norm(along, axis=1)
    crossing = np.abs(sine) > PARALLEL * length[i] * length[j]
    safe = np.where(crossing, sine, 1.0)
    first, second = _cross(apart, along[j]) / safe, _cross(apart, along[i]) / safe
    on = crossing & (first > 0) & (first < 1) & (second > 0) & (second < 1)
    crossings: Array = (start[i] + first[:, None] * along[i])[on]
    return crossings


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _box(feature: Feature) -> tuple[Array, Array]:
    """The lowest and highest x and z of a curved feature, and a little more."""
    points = feature.point_mm(np.linspace(0, feature.length_mm, BOXED_AT))
    spare = feature.length_mm / BOXED_AT
    return points.min(axis=0) - spare, points.max(axis=0) + spare


class Graph:
    """Pieces as edges between the points where their ends meet."""

    def __init__(self, pieces: Sequence[Segment], within_mm: float) -> None:
        self.pieces, self.within_mm = pieces, within_mm
        self.points, nodes = _met(_ends(pieces).reshape(-1, 2), within_mm)
        self.ends = [(a, b) for a, b in nodes.reshape(-1, 2).tolist()]
        self.at: list[list[int]] = [[] for _ in self.points]
        for index, (a, b) in enumerate(self.ends):
            self.at[a].append(index)
            self.at[b].append(index)

    def on_axis(self, node: int) -> bool:
        """Returns whether a point of the graph is on the axis."""
        return abs(self.points[node][0]) <= self.within_mm

    def components(self) -> Iterator[list[int]]:
        """Yields the connected components, as ascending numbers of pieces, those with the lowest first."""
        if not self.pieces:
            return
        a, b = np.array(self.ends).T
        count = len(self.points)
        _, labels = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(count, count)), directed=False)
        found: dict[int, list[int]] = {}
        for index, label in enumerate(labels[a].tolist()):
            found.setdefault(label, []).append(index)
        yield from found.values()

    def leading_on(self, component: Sequence[int]) -> set[int]:
        """Returns the component without pieces that end in the open, removed one after the other."""
        edges, left = set(component), list(component)
        count: dict[int, int] = {}
        for index in component:
            for node in self.ends[index]:
                count[node] = count.get(node, 0) + 1
        while left:
            index = left.pop()
            if index in edges and any(count[node] == 1 and not self.on_axis(node) for node in self.ends[index]):
                edges.remove(index)
                for node in self.ends[index]:
                    count[node] -= 1
                    if count[node] == 1:
                        left += [other for other in self.at[node] if other in edges]
        return edges


def _met(ends: Array, within_mm: float) -> tuple[list[Point], NDArray[np.int64]]:
    """Points that are apart, and by end which of them it is: the first within the tolerance; else it is a new one."""
    _, first, which = np.unique((ends + 0.0).view(np.complex128).ravel(), return_index=True, return_inverse=True)
    order = np.argsort(first)  # places in the order in which they come first
    places, which = ends[first[order]], np.argsort(order)[which]
    near: dict[int, list[int]] = {}
    for i, j in KDTree(places).query_pairs(within_mm * (1 + 1e-12), output_type="ndarray").tolist():
        near.setdefault(max(i, j), []).append(min(i, j))
    number, points = np.zeros(len(places), dtype=np.int64), list[Point]()
    founder = dict[int, bool]()
    for k, (x, z) in enumerate(places.tolist()):
        met = sorted(j for j in near.get(k, ()) if founder[j] and math.dist(places[j], (x, z)) <= within_mm)
        founder[k] = not met
        number[k] = number[met[0]] if met else len(points)
        if not met:
            points.append((x, z))
    return points, number[which]


def heading(feature: Feature, *, first: bool) -> float:
    """Returns the direction of travel at the beginning or the end, by a short chord: tangents do not distinguish a line
    from an arc that leaves it.
    """
    short = min(0.1, feature.length_mm / 4)
    s = (0.0, short) if first else (feature.length_mm - short, feature.length_mm)
    (x0, z0), (x1, z1) = feature.point_mm(s[0]), feature.point_mm(s[1])
    return math.atan2(x1 - x0, z1 - z0)


def turn_rad(before: float, after: float) -> float:
    """Returns the turn to the left, from −π (back, right about) to π."""
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


def _cut(segment: Segment, points: Sequence[Point], within_mm: float) -> list[Segment]:
    """The segment cut at points on it, those at its ends aside."""
    if not points:
        return [segment]
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


def cut_at(feature: Feature, points: Sequence[Point], within_mm: float) -> list[Feature]:
    """Returns the feature in pieces, cut at points that lie on it."""
    return [piece.feature for piece in _cut(Segment(feature, ""), points, within_mm)]


def mapped_feature(feature: Feature, matrix: Array, offset_mm: Array) -> Feature:
    """Returns the feature turned, mirrored and moved: points p to `matrix` p + offset, the matrix orthogonal."""
    if isinstance(feature, Curve):
        return mapped(feature, matrix, offset_mm)

    ((xx, xz), (zx, zz)), (dx, dz) = matrix.tolist(), offset_mm.tolist()

    def to(point: Point) -> Point:
        x, z = point
        return xx * x + xz * z + dx, zx * x + zz * z + dz

    if isinstance(feature, Line):
        return Line(feature.name, to(feature.start_mm), to(feature.end_mm))
    turn = math.copysign(1.0, float(np.linalg.det(matrix)))
    return Arc(feature.name, to(feature.start_mm), to(feature.end_mm), to(feature.centre_mm), feature.sweep_rad * turn)


def alike(a: Feature, b: Feature, within_mm: float) -> bool:
    """Returns whether two features coincide, in either direction."""
    middle = math.dist(a.point_mm(a.length_mm / 2), b.point_mm(b.length_mm / 2))
    same = math.dist(a.start_mm, b.start_mm) + math.dist(a.end_mm, b.end_mm)
    turned = math.dist(a.start_mm, b.end_mm) + math.dist(a.end_mm, b.start_mm)
    return middle <= within_mm and min(same, turned) <= 2 * within_mm
