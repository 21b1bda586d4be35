"""Drawn lines, arcs and curves in columns, of which a drawing may hold 100,000: moved, cut where they meet, chained."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.formats.cad.box_index import Pairs, overlapping
from trueloop.formats.cad.contour import cut_at
from trueloop.geometry.curve import Curve, mapped
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.intersection import TOUCH_MM, intersections

BOXED_AT: Final = np.linspace(0, 1, 17)
"""Places of a curved feature, as shares of its length, that state how far it reaches."""

Mask = NDArray[np.bool_]
Numbers = NDArray[np.int64]


@dataclass(frozen=True)
class Edges:
    """n drawn features, the layer of each; points (n, 2) are x up and z to the right."""

    start_mm: Array
    end_mm: Array
    centre_mm: Array
    """NaN of what is not an arc."""
    sweep_rad: Array
    """As that of `Arc`; 0 of a line, NaN of a curve."""
    curve: NDArray[np.object_]
    layer: NDArray[np.object_]

    @classmethod
    def of(cls, features: Sequence[Feature], layers: Sequence[str]) -> "Edges":
        """Returns features in columns."""
        arcs = [feature if isinstance(feature, Arc) else None for feature in features]
        curves = [feature if isinstance(feature, Curve) else None for feature in features]
        bent = [arc.sweep_rad if arc else np.nan if curve else 0.0 for arc, curve in zip(arcs, curves, strict=True)]
        return cls(
            start_mm=np.array([feature.start_mm for feature in features], dtype=np.float64).reshape(-1, 2),
            end_mm=np.array([feature.end_mm for feature in features], dtype=np.float64).reshape(-1, 2),
            centre_mm=np.array([arc.centre_mm if arc else (np.nan, np.nan) for arc in arcs]).reshape(-1, 2),
            sweep_rad=np.array(bent, dtype=np.float64),
            curve=_objects(curves),
            layer=_objects(layers),
        )

    @classmethod
    def of_lines(cls, start_mm: Array, end_mm: Array, layers: Sequence[str]) -> "Edges":
        """Returns lines between points (n, 2)."""
        n = len(start_mm)
        return cls(
            start_mm=start_mm,
            end_mm=end_mm,
            centre_mm=np.full((n, 2), np.nan),
            sweep_rad=np.zeros(n),
            curve=np.full(n, None, dtype=object),
            layer=_objects(layers),
        )

    @classmethod
    def joined(cls, parts: Sequence["Edges"]) -> "Edges":
        """Returns the rows of several, one after the other."""
        return cls(*(np.concatenate([getattr(part, column.name) for part in parts]) for column in fields(cls)))

    def __len__(self) -> int:
        """Returns the number of edges."""
        return len(self.sweep_rad)

    def take(self, which: Mask | Numbers) -> "Edges":
        """Returns some of the rows, by a mask or by numbers."""
        return Edges(*(getattr(self, column.name)[which] for column in fields(self)))

    def turned(self, back: Mask) -> "Edges":
        """Returns the edges, those of a mask run from end to start."""
        swap = back[:, None]
        curve = self.curve.copy()
        for k in np.flatnonzero(self.is_curve & back):
            curve[k] = curve[k].reversed()
        return Edges(
            start_mm=np.where(swap, self.end_mm, self.start_mm),
            end_mm=np.where(swap, self.start_mm, self.end_mm),
            centre_mm=self.centre_mm,
            sweep_rad=np.where(back, -self.sweep_rad, self.sweep_rad) + 0.0,
            curve=curve,
            layer=self.layer,
        )

    def mapped(self, matrix: Array, offset_mm: Array) -> "Edges":
        """Returns the edges turned, mirrored and moved: points p to `matrix` p + offset, the matrix orthogonal."""
        curve = self.curve.copy()
        for k in np.flatnonzero(self.is_curve):
            curve[k] = mapped(curve[k], matrix, offset_mm)
        start, end, centre = (at @ matrix.T + offset_mm for at in (self.start_mm, self.end_mm, self.centre_mm))
        return Edges(
            start_mm=start,
            end_mm=end,
            centre_mm=centre,
            sweep_rad=self.sweep_rad * np.sign(np.linalg.det(matrix)) + 0.0,
            curve=curve,
            layer=self.layer,
        )

    def feature(self, k: int) -> Feature:
        """Returns an edge as a feature without a name."""
        if self.curve[k] is not None:
            curve: Curve = self.curve[k]
            return curve
        (x0, z0), (x1, z1) = self.start_mm[k].tolist(), self.end_mm[k].tolist()
        if self.sweep_rad[k] == 0:
            return Line("", (x0, z0), (x1, z1))
        x, z = self.centre_mm[k].tolist()
        return Arc("", (x0, z0), (x1, z1), (x, z), float(self.sweep_rad[k]))

    @property
    def features(self) -> list[Feature]:
        """Returns all edges as features."""
        line = self.is_line.tolist()
        ends = zip(map(tuple, self.start_mm.tolist()), map(tuple, self.end_mm.tolist()), strict=True)
        return [Line("", *both) if line[k] else self.feature(k) for k, both in enumerate(ends)]

    @cached_property
    def is_line(self) -> Mask:
        """Returns which edges are straight, (n,)."""
        return np.asarray(self.sweep_rad == 0)

    @cached_property
    def is_curve(self) -> Mask:
        """Returns which edges are neither straight nor round, (n,)."""
        return np.isnan(self.sweep_rad)

    @cached_property
    def length_mm(self) -> Array:
        """Returns the arc lengths, (n,)."""
        radius = np.hypot(*(self.start_mm - self.centre_mm).T)
        length = np.where(self.is_line, np.hypot(*(self.end_mm - self.start_mm).T), radius * np.abs(self.sweep_rad))
        for k in np.flatnonzero(self.is_curve):
            length[k] = self.curve[k].length_mm
        return np.asarray(length)

    @cached_property
    def middle_mm(self) -> Array:
        """Returns the points half way along, (n, 2)."""
        middle = (self.start_mm + self.end_mm) / 2
        middle[~self.is_line] = self.take(~self.is_line).at_shares(np.array([0.5]))[:, 0]
        return middle

    @property
    def outward_at_middle(self) -> Array:
        """Returns the unit normals out of the material, to the left of the way, half way along, (n, 2)."""
        along = self.end_mm - self.start_mm
        turns = ~self.is_line & ~self.is_curve
        spoke = self.middle_mm[turns] - self.centre_mm[turns]
        along[turns] = np.sign(self.sweep_rad[turns, None]) * np.stack([-spoke[:, 1], spoke[:, 0]], axis=1)
        for k in np.flatnonzero(self.is_curve):
            along[k] = self.curve[k].tangent(self.length_mm[k] / 2)
        along = along / np.hypot(*along.T)[:, None]
        return np.stack([along[:, 1], -along[:, 0]], axis=1)

    def at_shares(self, shares: Array) -> Array:
        """Returns points at shares of the length, (m,) alike or (n, m) for each edge: (n, m, 2)."""
        shares = np.broadcast_to(shares, (len(self), shares.shape[-1]))
        points = self.start_mm[:, None] + shares[..., None] * (self.end_mm - self.start_mm)[:, None]
        arc = ~self.is_line & ~self.is_curve
        if np.any(arc):
            spoke = self.start_mm[arc] - self.centre_mm[arc]
            angle = np.arctan2(*spoke.T)[:, None] - self.sweep_rad[arc, None] * shares[arc]
            radius = np.hypot(*spoke.T)[:, None, None]
            points[arc] = self.centre_mm[arc, None] + radius * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
        for k in np.flatnonzero(self.is_curve):
            points[k] = self.curve[k].point_mm(shares[k] * self.curve[k].length_mm)
        return np.asarray(points)

    def boxes(self) -> tuple[Array, Array]:
        """Returns the lowest and the highest x and z, (n, 2) each, and a little more of what is not straight."""
        low, high = np.minimum(self.start_mm, self.end_mm), np.maximum(self.start_mm, self.end_mm)
        bent = ~self.is_line
        if np.any(bent):
            some = self.take(bent)
            points, spare = some.at_shares(BOXED_AT), some.length_mm[:, None] / len(BOXED_AT)
            low[bent], high[bent] = points.min(axis=1) - spare, points.max(axis=1) + spare
        return low, high

    def on(self, pairs: Pairs, points_mm: Array, within_mm: float, beyond_mm: float) -> Mask:
        """Returns by pair (edge, point) whether the point is on the edge, up to so far beyond its ends."""
        i, j = pairs.T
        along, aside = self.locate(i, points_mm[j])
        ends = (along > -beyond_mm) & (along < self.length_mm[i] + beyond_mm)
        return np.asarray((np.abs(aside) <= within_mm) & ends)

    def locate(self, edges: Numbers, points_mm: Array) -> tuple[Array, Array]:
        """Returns for edge `edges[k]` and point k what `Feature.locate` returns: arc length and distance, (n,) each."""
        off = points_mm - self.start_mm[edges]
        chord = self.end_mm[edges] - self.start_mm[edges]
        with np.errstate(divide="ignore", invalid="ignore"):  # a whole circle has no chord
            direction = chord / np.hypot(*chord.T)[:, None]
        along, aside = np.sum(off * direction, axis=1), -cross(direction, off)
        (round_,) = np.nonzero(~self.is_line[edges] & ~self.is_curve[edges])
        if len(round_):
            k = edges[round_]
            sweep, side = self.sweep_rad[k], np.sign(self.sweep_rad[k])
            spoke, spread = self.start_mm[k] - self.centre_mm[k], points_mm[round_] - self.centre_mm[k]
            half_gap, radius = np.pi - np.abs(sweep) / 2, np.hypot(*spoke.T)
            turned = side * (np.arctan2(*spoke.T) - np.arctan2(*spread.T)) + half_gap
            along[round_] = (turned % (2 * np.pi) - half_gap) * radius
            aside[round_] = side * (np.hypot(*spread.T) - radius)
        curved = np.flatnonzero(self.is_curve[edges])
        curved = curved[np.argsort(edges[curved], kind="stable")]
        of = edges[curved]
        for mine in np.split(curved, np.flatnonzero(np.diff(of)) + 1) if len(of) else ():
            along[mine], aside[mine] = self.curve[edges[mine[0]]].locate(points_mm[mine])
        return along, aside

    def cut(self, edges: Numbers, points_mm: Array, within_mm: float) -> "Edges":
        """Returns the edges in pieces, edge `edges[k]` cut at `points_mm[k]`, in their order."""
        if not len(edges):
            return self
        order = np.argsort(edges, kind="stable")
        which, first = np.unique(edges[order], return_index=True)
        features, of = list[Feature](), list[int]()
        for k, places in zip(which.tolist(), np.split(points_mm[order], first[1:]), strict=True):
            pieces = cut_at(self.feature(k), [(x, z) for x, z in places.tolist()], within_mm)
            features += pieces
            of += [k] * len(pieces)
        whole = np.setdiff1d(np.arange(len(self)), which)
        parts = Edges.joined([self.take(whole), Edges.of(features, self.layer[of].tolist())])
        return parts.take(np.argsort(np.concatenate([whole, of]), kind="stable"))


def _objects(values: Iterable[object]) -> NDArray[np.object_]:
    values = list(values)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def cross(a: Array, b: Array) -> Array:
    """Returns a_x b_z − a_z b_x, (n,)."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


PARALLEL: Final = 1e-13
"""Sine of the angle below which two lines count as parallel."""
MEETS_MM: Final = 1e-6
"""Ends of curves that lie closer are one point when it is judged which way they go from there."""
AHEAD: Final = 0.5
"""A chord runs away from another edge by more than this share of its length: the difference of their directions."""
CHORDS: Final = len(BOXED_AT) - 1
"""Number of chords of an edge, of one arc length."""
TAUT: Final = 0.95
"""A chord of at least this share of its arc has no loop or spike beside it."""


def cut_where_met(edges: Edges, within_mm: float) -> Edges:
    """Returns edges cut where others meet or cross them between their ends; what is drawn twice, once."""
    if not len(edges):
        return edges
    low, high = edges.boxes()
    points = np.concatenate([edges.start_mm, edges.end_mm, all_crossings(edges, low, high)])
    points = points[_first_of_each(points)]
    pairs = overlapping(low - within_mm, high + within_mm, points, points)
    i, j = pairs[edges.on(pairs, points, within_mm, -within_mm)].T
    return _once(edges.cut(i, points[j], within_mm), within_mm)


def _first_of_each(rows: Array) -> Numbers:
    """Numbers of the rows, ascending, of which none before is equal."""
    order = np.lexsort(rows.T)  # stable: of equal rows the first comes first
    new = np.any(np.diff(rows[order], axis=0, prepend=np.nan) != 0, axis=1)
    return np.sort(order[new])


def _once(pieces: Edges, within_mm: float) -> Edges:
    """The pieces without those that run, in either direction, through the places of an earlier one."""
    start, end = pieces.start_mm, pieces.end_mm
    exchanged = (start[:, 0] > end[:, 0]) | ((start[:, 0] == end[:, 0]) & (start[:, 1] > end[:, 1]))
    places = pieces.turned(exchanged)
    runs = np.concatenate([places.start_mm, places.end_mm, pieces.middle_mm], axis=1)
    return pieces.take(_first_of_each(np.rint(runs / within_mm)))


def all_crossings(edges: Edges, low: Array, high: Array) -> Array:
    """Returns the places where edges cross each other, (n, 2)."""
    pairs = overlapping(low, high, low, high)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    curved = edges.is_curve[pairs].any(axis=1)
    smooth = pairs[curved]
    smooth = smooth[~_part_for_good(edges, smooth)]
    bent = {k: edges.feature(k) for k in np.unique(smooth).tolist()}
    found = [
        point
        for i, j in smooth.tolist()
        for point in intersections(bent[i], bent[j])
        if all(0 < float(one.locate(point)[0]) < one.length_mm for one in (bent[i], bent[j]))
    ]
    straight = edges.is_line[pairs].all(axis=1)
    return np.concatenate(
        [
            _line_crossings(edges, pairs[straight]),
            _circle_crossings(edges, pairs[~straight & ~curved]),
            np.array(found, dtype=np.float64).reshape(-1, 2),
        ]
    )


def _part_for_good(edges: Edges, pairs: Pairs) -> Mask:
    """Pairs of edges that share an end and diverge from it chord by chord, so that they do not cross elsewhere.

    Chords do not show a hook in a piece shorter than a chord: curves with such pieces are left to `intersections`.
    """
    numbers, row = np.unique(pairs, return_inverse=True)
    some, row = edges.take(numbers), row.reshape(pairs.shape)
    points = some.at_shares(BOXED_AT)
    taut = TAUT * np.diff(BOXED_AT) * some.length_mm[:, None]
    even = np.array([one is None or np.diff(one.breaks_mm).min() >= one.length_mm / CHORDS for one in some.curve])
    parts = np.zeros(len(pairs), dtype=bool)
    ways = ((points[k], points[k, ::-1]) for k in row.T)
    for first, second in product(*ways):
        meet = np.hypot(*(first[:, 0] - second[:, 0]).T) <= MEETS_MM
        a, b = np.diff(first, axis=1), np.diff(second, axis=1)
        away = a[:, 0] / np.hypot(*a[:, 0].T)[:, None] - b[:, 0] / np.hypot(*b[:, 0].T)[:, None]
        for chords, sign, k in ((a, 1.0, 0), (b, -1.0, 1)):
            ahead, chord = sign * np.einsum("nki,ni->nk", chords, away), np.linalg.norm(chords, axis=2)
            meet &= np.all((chord > taut[row[:, k]]) & (ahead > AHEAD * chord), axis=1)
        parts |= meet
    return np.asarray(parts & even[row].all(axis=1))


def _circle_crossings(edges: Edges, pairs: Pairs) -> Array:
    """Returns the places where arcs cross lines or arcs between their ends, (n, 2)."""
    swap = edges.is_line[pairs[:, 1]]
    i, j = np.where(swap[:, None], pairs[:, ::-1], pairs).T  # j is an arc
    centre, start, line = edges.centre_mm, edges.start_mm, edges.is_line[i]
    radius = np.hypot(*(start - centre).T)
    way = np.where(line[:, None], edges.end_mm[i] - start[i], centre[j] - centre[i])
    apart = np.hypot(*way.T)
    with np.errstate(divide="ignore", invalid="ignore"):  # of concentric ones there is none
        way = way / apart[:, None]
        foot = start[i] + np.sum((centre[j] - start[i]) * way, axis=1)[:, None] * way
        to_chord = (apart + (radius[i] - radius[j]) * (radius[i] + radius[j]) / apart) / 2
        foot = np.where(line[:, None], foot, centre[i] + to_chord[:, None] * way)
        off = np.where(line, np.hypot(*(centre[j] - foot).T), np.abs(to_chord))
        of = np.where(line, radius[j], radius[i])
        half = np.sqrt(np.maximum((of - off) * (of + off), 0.0))
        met = (off <= of + TOUCH_MM) & (apart > TOUCH_MM)
    across = np.where(line[:, None], way, np.stack([way[:, 1], -way[:, 0]], axis=1))
    places = np.concatenate([foot - half[:, None] * across, foot + half[:, None] * across])[np.tile(met, 2)]
    on = np.ones(len(places), dtype=bool)
    for one in (i, j):
        of = np.tile(one, 2)[np.tile(met, 2)]
        along = edges.locate(of, places)[0]
        on &= (along > 0) & (along < edges.length_mm[of])
    return np.asarray(places[on])


def _line_crossings(edges: Edges, pairs: Pairs) -> Array:
    """Returns the places where pairs of lines cross between their ends, (n, 2)."""
    start, (i, j), along = edges.start_mm, pairs.T, edges.end_mm - edges.start_mm
    apart = start[j] - start[i]
    sine = cross(along[i], along[j])
    crossing = np.abs(sine) > PARALLEL * edges.length_mm[i] * edges.length_mm[j]
    safe = np.where(crossing, sine, 1.0)
    first, second = cross(apart, along[j]) / safe, cross(apart, along[i]) / safe
    on = crossing & (first > 0) & (first < 1) & (second > 0) & (second < 1)
    crossings: Array = (start[i] + first[:, None] * along[i])[on]
    return crossings
