"""Drawn lines, arcs and curves cut where they meet or cross: lines and arcs in columns, curves two by two."""

from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.box_index import Pairs, overlapping
from trueloop.formats.cad.dxf_edges import BOXED_AT, Edges, Mask, Numbers, cross
from trueloop.geometry.intersection import TOUCH_MM, intersections

PARALLEL: Final = 1e-13
"""Sine of the angle below which two lines count as parallel."""
MEETS_MM: Final = 1e-6
"""Ends of curves that lie closer are one point when it is judged which way they go from there."""
AHEAD: Final = 0.5
"""A chord runs away from another edge by more than this share of its length, along the difference of the unit vectors
in which the two set out."""
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
