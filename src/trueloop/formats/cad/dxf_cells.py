"""The material in a view: its halves, the cells between their lines, and which of these are the bore of a section."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from trueloop.arrays import Array
from trueloop.formats.cad.box_index import overlapping
from trueloop.formats.cad.contour import Contour, Piece, chained
from trueloop.formats.cad.dxf_edges import Edges, Mask, Numbers, cut_where_met
from trueloop.geometry.intersection import sign_changes

Hatched: TypeAlias = Callable[[Array], Mask]
"""Maps places of the half view, (n, 2) of x and z, to whether they are hatched."""

ASIDE_MM: Final = 0.02
"""The distance inside its edges at which a cell is sampled; less where an edge is short."""
AXIS: Final = "axis"
_UP: Final = np.diag([-1.0, 1.0])


@dataclass(frozen=True)
class Half:
    """One half of a view, above the axis or turned up from below it; `twins` of its pieces are drawn on the other side
    too, `unlike` pieces of the other side are not like any of it.
    """

    edges: Edges
    twins: Edges
    unlike: int
    turned_up: bool = False

    @property
    def mirrored(self) -> int:
        """Returns the number of pieces drawn on both sides."""
        return len(self.twins)

    def are_mirrored(self, places: Array, within_mm: float) -> Mask:
        """Returns whether a piece at each of the places, (n, 2), is drawn on the other side too."""
        low, high = self.twins.boxes()
        pairs = overlapping(low - within_mm, high + within_mm, places, places)
        on = pairs[self.twins.on(pairs, places, within_mm, within_mm), 1]
        return np.asarray(np.bincount(on, minlength=len(places)) > 0)


def halves(edges: Edges, within_mm: float) -> list[Half]:
    """Returns the drawing above the axis, cut where it crosses it, and that below, turned up, if it differs."""
    pieces = edges.cut(*_on_axis(edges), within_mm)
    above = pieces.middle_mm[:, 0] > 0
    upper, lower = pieces.take(above), pieces.take(~above).mapped(_UP, np.zeros(2))
    if not len(upper):
        return [Half(lower, upper, 0, turned_up=True)]
    twins = lower.take(_like(lower, upper, within_mm))
    first = Half(upper, twins, len(lower) - len(twins))
    return [first, Half(lower, twins, 0, turned_up=True)] if first.unlike else [first]


def _on_axis(edges: Edges) -> tuple[Numbers, Array]:
    """Edges that cross the axis or whose whole circle does, and where."""
    (x0, z0), (x1, z1), (x, z) = edges.start_mm.T, edges.end_mm.T, edges.centre_mm.T
    lines = np.flatnonzero(edges.is_line & (x0 * x1 < 0))
    at = (z0 + (z1 - z0) * x0 / np.where(x0 == x1, 1.0, x0 - x1))[lines]
    radius = np.hypot(x0 - x, z0 - z)
    arcs = np.flatnonzero(np.abs(x) < radius)  # a centre of NaN is none
    aside = np.sqrt(radius[arcs] ** 2 - x[arcs] ** 2)
    curves = np.flatnonzero(edges.is_curve)
    on = [one.point_mm(sign_changes(one, lambda points: points[:, 0]))[:, 1] for one in edges.curve[curves]]
    which = np.concatenate([lines, arcs, arcs, np.repeat(curves, [len(one) for one in on])])
    along = np.concatenate([at, z[arcs] - aside, z[arcs] + aside, *on])
    return which.astype(np.int64), np.stack([np.zeros(len(along)), along], axis=1)


def _like(pieces: Edges, others: Edges, within_mm: float) -> Mask:
    """Which of the pieces run through the same places as one of the others, in either direction."""
    low, high = pieces.middle_mm - within_mm, pieces.middle_mm + within_mm
    pairs = overlapping(low, high, others.middle_mm, others.middle_mm)
    a, b = pieces.take(pairs[:, 0]), others.take(pairs[:, 1])
    middle = _apart(a.middle_mm, b.middle_mm)
    same = _apart(a.start_mm, b.start_mm) + _apart(a.end_mm, b.end_mm)
    turned = _apart(a.start_mm, b.end_mm) + _apart(a.end_mm, b.start_mm)
    alike = (middle <= within_mm) & (np.minimum(same, turned) <= 2 * within_mm)
    return np.bincount(pairs[alike, 0], minlength=len(pieces)) > 0


def _apart(a: Array, b: Array) -> Array:
    return np.asarray(np.hypot(*(a - b).T))


@dataclass(frozen=True)
class Walled:
    """A connected part of a half view: the pieces that bound what of it is material, on their right.

    `hollow`: a bore was told from the material by its hatching, `True`, by its lines alone, `False`; None: no bore.
    """

    contours: tuple[Contour, ...]
    hollow: bool | None
    hatched: bool
    full: tuple[Contour, ...]
    """The contours as if there were no bore."""


def walled(edges: Edges, hatched: Hatched, within_mm: float) -> Iterator[Walled]:
    """Yields every connected part of a half view that closes cells, with the axis or without it."""
    if not len(edges):
        return
    cells = _Cells(cut_where_met(edges, within_mm), within_mm)
    full = cells.hatched(hatched)
    bore = cells.bore(full)
    for steps in cells.by_part():
        mine = np.unique(cells.cell_of[steps])
        whole = tuple(cells.contours(steps, bore & False))
        hollow = bool(np.any(full[mine])) if np.any(bore[mine]) else None
        yield Walled(
            whole if hollow is None else tuple(cells.contours(steps, bore)), hollow, bool(np.any(full[mine])), whole
        )


class _Cells:
    """The cells between pieces: closed walks with the cell on the right.

    A step is a piece and a way along it: 2 k + 1 runs piece k forwards, 2 k backwards, and step ^ 1 leads back.
    """

    def __init__(self, pieces: Edges, within_mm: float) -> None:
        self.within_mm = within_mm
        ends = np.stack([pieces.start_mm, pieces.end_mm], axis=1)
        points, nodes = _met(ends.reshape(-1, 2), within_mm)
        nodes = nodes.reshape(-1, 2)
        joined = coo_array((np.ones(len(nodes)), tuple(nodes.T)), shape=(len(points), len(points)))
        part = connected_components(joined, directed=False)[1].astype(np.int64)  # numbered by the lowest point
        on_axis = np.abs(points[:, 0]) <= within_mm
        kept = _leading_on(nodes, on_axis)
        met = np.isin(np.arange(len(points)), nodes[kept]) & on_axis
        axis = _along_axis(points, part, np.flatnonzero(met))
        closing = Edges.of_lines(points[axis[:, 0]], points[axis[:, 1]], [AXIS] * len(axis))
        self.pieces = Edges.joined([closing, pieces.take(kept)])
        self.axis = np.repeat(np.arange(len(self.pieces)) < len(axis), 2)
        nodes = np.concatenate([axis, nodes[kept]])
        origin = nodes[:, ::-1].ravel() if len(nodes) else np.zeros(0, dtype=np.int64)
        back = np.arange(len(origin)) ^ 1
        self.flat, first = _cycles(_next_about(origin, _headings(self.pieces))[back])
        area = np.add.reduceat(self._areas(points, nodes)[self.flat], first) if len(first) else np.zeros(0)
        number = np.where(area < -(within_mm**2), np.cumsum(area < -(within_mm**2)) - 1, -1)
        self.count = int(number.max(initial=-1)) + 1
        self.cell_of = np.zeros(len(origin), dtype=np.int64)
        self.cell_of[self.flat] = np.repeat(number, np.diff([*first, len(self.flat)]))
        self.flat = self.flat[self.cell_of[self.flat] >= 0]
        self.part = part[origin]
        self.outer = (self.cell_of >= 0) & (self.cell_of[back] < 0) & ~self.axis
        self.at_end = self._at_ends()

    def hatched(self, hatched: Hatched) -> Mask:
        """Returns by cell whether it is hatched at most places beside its edges."""
        if not len(self.flat):
            return np.zeros(0, dtype=bool)
        ways = self.pieces.take(self.flat // 2).turned(self.flat % 2 == 0)
        aside = np.minimum(ASIDE_MM, ways.length_mm / 10)[:, None]
        inside = hatched(ways.middle_mm - aside * ways.outward_at_middle)
        cell = self.cell_of[self.flat]
        return np.asarray(2 * np.bincount(cell, inside, self.count) > np.bincount(cell, minlength=self.count))

    def bore(self, full: Mask) -> Mask:
        """Returns by cell whether it is a bore: on the axis, not hatched, and open at end faces, if through others."""
        on_axis, mouth = self._any(self.axis), self._any(self.outer & self.at_end)
        inner = ~full & on_axis & ~self._any(self.outer & ~self.at_end)
        both = self.cell_of[self.flat], self.cell_of[self.flat ^ 1]
        beside = (both[1] >= 0) & inner[both[0]] & inner[both[1]]
        a, b = both[0][beside], both[1][beside]
        label = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(self.count,) * 2), directed=False)[1]
        air = inner & np.isin(label, label[inner & mouth])
        part = np.zeros(self.count, dtype=np.int64)
        part[self.cell_of[self.flat]] = self.part[self.flat]
        return np.asarray(air & np.isin(part, part[~air]))

    def by_part(self) -> Iterator[Numbers]:
        """Yields the steps about the cells of each connected part, cell by cell."""
        if len(self.flat):
            order = np.argsort(self.part[self.flat], kind="stable")
            part = self.part[self.flat[order]]
            yield from np.split(self.flat[order], np.flatnonzero(np.diff(part)) + 1)

    def contours(self, steps: Numbers, bore: Mask) -> Iterator[Contour]:
        """Returns the contours of what is material of a part."""
        material = np.append(~bore, False)  # the cell −1 is the outside
        cell, behind = self.cell_of[steps], self.cell_of[steps ^ 1]
        walls = steps[material[cell] & ~material[behind] & ~self.axis[steps]]
        ways = self.pieces.take(walls // 2).turned(walls % 2 == 0)
        pieces = [Piece(one, layer=layer) for one, layer in zip(ways.features, ways.layer, strict=True)]
        return iter(chained(pieces, "", self.within_mm))

    def _any(self, steps: Mask) -> Mask:
        """By cell, whether it is true of any step about it."""
        return np.bincount(self.cell_of[self.flat], steps[self.flat], self.count) > 0

    def _at_ends(self) -> Mask:
        """By step, whether it is part of an end face of its connected part."""
        z = np.stack([self.pieces.start_mm[:, 1], self.pieces.end_mm[:, 1]], axis=1)
        part, count = self.part[::2], int(self.part.max(initial=-1)) + 1
        low, high = np.full(count, np.inf), np.full(count, -np.inf)
        np.minimum.at(low, part, z.min(axis=1))
        np.maximum.at(high, part, z.max(axis=1))
        aside = [np.max(np.abs(z - end[part][:, None]), axis=1, initial=0.0) for end in (low, high)]
        return np.repeat(np.minimum(*aside) < self.within_mm, 2)

    def _areas(self, points: Array, nodes: Numbers) -> Array:
        """By step, its share of the area of a walk: positive where the walk turns left about it."""
        by_piece = _left_of(np.stack([points[nodes[:, 0]], points[nodes[:, 1]]], axis=1))
        bent = ~self.pieces.is_line
        along = self.pieces.take(bent).at_shares(np.linspace(0, 1, 9))
        along[:, 0], along[:, -1] = points[nodes[bent, 0]], points[nodes[bent, 1]]
        by_piece[bent] = _left_of(along)
        return np.stack([-by_piece, by_piece], axis=1).ravel()


def _left_of(points: Array) -> Array:
    """Areas of the fans from zero to the ways through points, (n, m, 2) → (n,)."""
    x, z = points[..., 0], points[..., 1]
    return np.asarray(np.sum(z[:, :-1] * x[:, 1:] - x[:, :-1] * z[:, 1:], axis=1) / 2)


def _along_axis(points: Array, part: Numbers, nodes: Numbers) -> Numbers:
    """The axis between the first and the last place where a connected part meets it: pairs of points, (n, 2)."""
    nodes = nodes[np.lexsort((-points[nodes, 1], part[nodes]))]
    pairs = np.stack([nodes[1:], nodes[:-1]], axis=1)
    return np.asarray(pairs[part[nodes[1:]] == part[nodes[:-1]]])


def _headings(pieces: Edges) -> Array:
    """By step, its direction by a short chord: tangents do not distinguish a line from an arc that leaves it."""
    share = np.minimum(0.1 / np.maximum(pieces.length_mm, 1e-9), 0.25)[:, None]
    first, near, far, last = np.moveaxis(
        pieces.at_shares(np.concatenate([0 * share, share, 1 - share, 0 * share + 1], axis=1)), 1, 0
    )
    chords = np.stack([far - last, near - first], axis=1).reshape(-1, 2)
    return np.asarray(np.arctan2(chords[:, 0], chords[:, 1]))


def _next_about(origin: Numbers, heading_rad: Array) -> Numbers:
    """By step, the next to the left of it of those that set out from its point; after the last comes the first.

    To arrive by a step's way back and go on by this is the sharpest turn to the right.
    """
    order = np.lexsort((heading_rad, origin))
    new = np.diff(origin[order], prepend=-1) != 0
    group = np.cumsum(new) - 1
    first = order[new]
    after = np.append(order, -1)[1:]
    last = np.append(new, True)[1:]
    after[last] = first[group[last]]
    found = np.empty_like(order)
    found[order] = after
    return found


def _cycles(onward: Numbers) -> tuple[Numbers, Numbers]:
    """The steps in the order of closed walks, and where each walk begins."""
    to, done = onward.tolist(), bytearray(len(onward))
    flat, first = list[int](), list[int]()
    for begin in range(len(to)):
        if not done[begin]:
            first.append(len(flat))
        step = begin
        while not done[step]:
            done[step] = 1
            flat.append(step)
            step = to[step]
    return np.array(flat, dtype=np.int64), np.array(first, dtype=np.int64)


def _leading_on(nodes: Numbers, on_axis: Mask) -> Mask:
    """Which pieces, by their points (n, 2), are left when those that end in the open go, one after the other."""
    degree = np.bincount(nodes.ravel(), minlength=len(on_axis))
    last = np.zeros(len(on_axis), dtype=np.int64)  # of all pieces at a point, by exclusive or: the one that is left
    np.bitwise_xor.at(last, nodes.ravel(), np.repeat(np.arange(len(nodes)), 2))
    kept, at, left = np.ones(len(nodes), dtype=bool), last.tolist(), degree.tolist()
    ends, fixed = nodes.tolist(), on_axis.tolist()
    open_ends = np.flatnonzero((degree == 1) & ~on_axis).tolist()
    while open_ends:
        node = open_ends.pop()
        if left[node] != 1:
            continue
        piece = at[node]
        kept[piece] = False
        for end in ends[piece]:
            left[end] -= 1
            at[end] ^= piece
            if left[end] == 1 and not fixed[end]:
                open_ends.append(end)
    return kept


def _met(ends: Array, within_mm: float) -> tuple[Array, NDArray[np.int64]]:
    """Points that are apart, and by end which of them it is: the first within the tolerance; else it is a new one."""
    _, first, which = np.unique((ends + 0.0).view(np.complex128).ravel(), return_index=True, return_inverse=True)
    order = np.argsort(first)  # places in the order in which they come first
    places, which = ends[first[order]], np.argsort(order)[which]
    near: dict[int, list[int]] = {}
    for i, j in KDTree(places).query_pairs(within_mm, output_type="ndarray").tolist():
        near.setdefault(max(i, j), []).append(min(i, j))
    founder, number = np.ones(len(places), dtype=bool), np.arange(len(places))
    for k in sorted(near):
        met = [j for j in near[k] if founder[j]]
        if met:
            founder[k], number[k] = False, min(met)
    return places[founder], (np.cumsum(founder) - 1)[number][which]
