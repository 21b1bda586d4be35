"""A drawing as it lies on its sheet: its edges, its axes, and every contour of a turned part about them.

The views of a sheet: which of its centre lines are axes of turned parts, and what contours are drawn about each.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.contour import Contour, middle_mm
from trueloop.formats.cad.dxf_cells import Half, Hatched, Walled, halves, walled
from trueloop.formats.cad.dxf_document import Document, DrawnEntity
from trueloop.formats.cad.dxf_edges import Edges, Mask
from trueloop.formats.cad.dxf_entities import (
    CHAIN_WITHIN_MM,
    READ,
    CentreLine,
    Meanings,
    centre_lines,
    edges_of,
    unfolded,
)
from trueloop.geometry.feature import Feature, Line, Point
from trueloop.geometry.profile import Side

LIKE: Final = 0.5
"""At least this share of what is drawn on either side of an axis is drawn on the other side too, or one is empty."""


@dataclass(frozen=True)
class View:
    """The drawing about one axis, x counted from it; of a vertical axis z grows upwards."""

    axis: CentreLine
    halves: tuple[Half, ...]
    hatched: Hatched
    within_mm: float
    on_axis: int = 0
    """Lines that lie on the axis."""

    @cached_property
    def walls(self) -> tuple[list[Walled], ...]:
        """Returns the parts of each half that close cells."""

        def of_half(half: Half) -> list[Walled]:
            up = np.array([-1.0 if half.turned_up else 1.0, 1.0])
            return list(walled(half.edges, lambda places: self.hatched(places * up), self.within_mm))

        return tuple(map(of_half, self.halves))

    def on_sheet(self, places: Array) -> Array:
        """Returns the places on the sheet, to the right and up, of the view's (x, z), (n, 2) each."""
        x, z = places.T
        return np.stack([self.axis.at_mm - x, z] if self.axis.vertical else [z, self.axis.at_mm + x], axis=1)

    @property
    def likeness(self) -> float:
        """Returns the share of the pieces that are drawn on both sides; 1 where one side is empty."""
        half = self.halves[0]
        return 1.0 if not half.unlike and not half.mirrored else half.mirrored / max(half.mirrored + half.unlike, 1)


@dataclass(frozen=True)
class Candidate:
    """A contour that may be the part's, its material on the right; `by_lines`: its bore follows from no hatching."""

    side: Side
    features: tuple[Feature, ...]
    layers: tuple[str, ...]
    view: View
    by_lines: bool = False

    @property
    def from_section(self) -> bool:
        """Returns whether its ends are away from the axis, as those of a hollow part in section."""
        return self.features[0].start_mm[0] > 0 and self.features[-1].end_mm[0] > 0

    @cached_property
    def box_mm(self) -> tuple[float, float, float]:
        """Returns the largest x and the lowest and the highest z of the ends of its features."""
        points = np.array([end for feature in self.features for end in (feature.start_mm, feature.end_mm)])
        return float(points[:, 0].max()), float(points[:, 1].min()), float(points[:, 1].max())

    @property
    def described(self) -> str:
        """Describes the number of features, where they begin, and their layers."""
        x, z = self.features[0].start_mm
        return f"{len(self.features)} features from x = {x:.3f} mm, z = {z:.3f} mm on {', '.join(self.layers)}"


def view_about(axis: CentreLine, edges: Edges, hatched: Hatched, within: float) -> View:
    """Returns the view of an axis: all that lies beside it."""
    here = not axis.vertical and axis.at_mm == 0
    placed = edges if here else edges.mapped(*_seen_from(axis))
    z = np.stack([placed.start_mm[:, 1], placed.end_mm[:, 1]])
    x = np.abs(np.stack([placed.start_mm[:, 0], placed.end_mm[:, 0]]))
    overlaps = (z.max(axis=0) > axis.low_mm) & (z.min(axis=0) < axis.high_mm)
    on_axis = placed.is_line & (x.max(axis=0) < within)
    beside = halves(placed.take(overlaps & ~on_axis), within)
    view = View(axis, tuple(beside), hatched, within, int(on_axis.sum()))
    return replace(view, hatched=lambda places: hatched(view.on_sheet(places)))


def candidates_of(view: View, within: float, *, alone: bool) -> list[Candidate]:
    """Returns the contours of a view: of the upper half, and those bores that only the lower one shows.

    What does not meet the axis is a part's if it is drawn on both sides of it or, where nothing meets it, if it is
    hatched or `alone` on the sheet.
    """
    found: list[Candidate] = []
    for number, (half, parts) in enumerate(zip(view.halves, view.walls, strict=True)):
        new = list(_of_half(view, half, parts, within, alone))
        if number == 0:
            found += new
        elif not any(candidate.side is Side.INSIDE for candidate in found):
            found += [candidate for candidate in new if candidate.side is Side.INSIDE]
    # less the borders: rectangles around another contour
    return [
        candidate
        for candidate in found
        if not (is_box(candidate) and any(_encloses(candidate, other) for other in found))
    ]


def chosen_views(views: Sequence[View], within: float) -> tuple[list[View], list[str]]:
    """Returns the independent views, not those about centre lines of holes within another one, and notes."""
    kept: list[View] = []
    parts: list[list[Candidate]] = []
    notes: list[str] = []
    for view in sorted(views, key=lambda one: (-round(one.likeness, 2), -one.axis.length_mm)):
        if not any(len(half.edges) for half in view.halves):
            continue
        outer = next((other for other, part in zip(kept, parts, strict=True) if _within(view.axis, other, part)), None)
        if outer is not None:
            notes.append(f"The centre line at {view.axis.where} lies in the part about {outer.axis.where}: a hole's.")
        elif view.likeness >= LIKE or not kept:
            kept.append(view)
            parts.append(candidates_of(view, within, alone=False))
    return kept, notes


def same_shape(a: Candidate, b: Candidate, within: float) -> bool:
    """Returns whether two contours differ in nothing but their place along z and the reach of their end faces."""
    if a.side is not b.side or len(a.features) != len(b.features):
        return False
    by, last = b.features[0].start_mm[1] - a.features[0].start_mm[1], len(a.features) - 1
    pairs = [
        (p, q)
        for k, (one, other) in enumerate(zip(a.features, b.features, strict=True))
        for p, q in ((one.start_mm, other.start_mm), (middle_mm(one), middle_mm(other)), (one.end_mm, other.end_mm))
        if not (k in (0, last) and _is_face(one) and _is_face(other))
    ]
    return bool(pairs) and all(math.dist((p[0], p[1] + by), q) < 10 * within for p, q in pairs)


def _of_half(view: View, half: Half, parts: Sequence[Walled], within: float, alone: bool) -> Iterator[Candidate]:
    meeting = [any(abs(x) <= within for contour in part.full for x, _ in _ends(contour)) for part in parts]
    for part, meets in zip(parts, meeting, strict=True):
        by_itself = (alone or part.hatched) and not any(meeting)
        if not (meets or by_itself or _twice(part.full, half, within)):
            continue
        outside = [contour for contour in (part.contours if part.hollow else part.full) if contour.side is Side.OUTSIDE]
        inside = [contour for contour in part.contours if contour.side is Side.INSIDE]
        for contour in (contour for contour in (*outside, *inside) if math.dist(*contour.ends) > within):
            yield _candidate(contour, view, contour.side is Side.INSIDE and part.hollow is False)


def _candidate(contour: Contour, view: View, by_lines: bool) -> Candidate:
    layers = tuple(sorted({piece.layer for piece in contour.pieces}))
    return Candidate(contour.side, tuple(piece.feature for piece in contour.pieces), layers, view, by_lines)


def is_box(candidate: Candidate) -> bool:
    """Returns whether it is a rectangle, or a part of one."""
    return len(candidate.features) <= 3 and all(isinstance(feature, Line) for feature in candidate.features)


def _encloses(outer: Candidate, inner: Candidate) -> bool:
    (x0, low0, high0), (x1, low1, high1) = outer.box_mm, inner.box_mm
    return x1 < x0 and low0 < low1 and high1 < high0


def _within(axis: CentreLine, other: View, candidates: Sequence[Candidate]) -> bool:
    """Returns whether a centre line runs through the part that is drawn about another one."""
    boxes = [candidate.box_mm for candidate in candidates]
    if not boxes:
        return False
    x, low, high = max(x for x, _, _ in boxes), min(z for _, z, _ in boxes), max(z for _, _, z in boxes)
    if axis.vertical == other.axis.vertical:
        return abs(axis.at_mm - other.axis.at_mm) < x and axis.low_mm < high and axis.high_mm > low
    near = axis.low_mm < other.axis.at_mm + x and axis.high_mm > other.axis.at_mm - x
    return low < axis.at_mm < high and near


def _seen_from(axis: CentreLine) -> tuple[Array, Array]:
    """A turn and a move by which x counts from an axis; (x, z) of the sheet are up and right."""
    if axis.vertical:
        return np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([axis.at_mm, 0.0])
    return np.eye(2), np.array([-axis.at_mm, 0.0])


def _twice(contours: Sequence[Contour], half: Half, within: float) -> bool:
    """Returns whether most of it is drawn below the axis too."""
    places = np.array([middle_mm(piece.feature) for contour in contours for piece in contour.pieces]).reshape(-1, 2)
    return bool(2 * half.are_mirrored(places, within).sum() > len(places))


def _ends(contour: Contour) -> Iterator[Point]:
    for piece in contour.pieces:
        yield piece.feature.start_mm
        yield piece.feature.end_mm


def _is_face(feature: Feature) -> bool:
    return isinstance(feature, Line) and feature.start_mm[1] == feature.end_mm[1]


FLAT: Final = 0.01
"""Outlines of hatched areas are taken as straight between places so near to them, in drawing units."""
AT_ONCE: Final = 2_000_000
"""Places by sides of a hatched area that are looked at together."""
MOST_AXES: Final = 100
"""So many centre lines, the longest, are looked at as axes; a sheet has a dozen."""
MOST_ALIKE: Final = 300
"""More level lines one above the other are a hatching drawn in lines, and tell of no axis."""
AT_ZERO: Final = CentreLine(False, 0.0, -np.inf, np.inf, "y = 0")


@dataclass(frozen=True)
class Sheet:
    """`edges` in mm, x up and z to the right; `views` with contours; in words what was left out of them."""

    edges: Edges
    views: tuple[View, ...]
    left_out: tuple[str, ...]

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """Returns the contours of all views, from the left; they are sought only where a drawing has several chains."""
        return self._found[0]

    @property
    def notes(self) -> tuple[str, ...]:
        """Returns in words what was decided."""
        return self.left_out if len(self.views) == 1 else (*self.left_out, *self._found[1])

    @cached_property
    def _found(self) -> tuple[tuple[Candidate, ...], tuple[str, ...]]:
        found, again = _candidates(self.views)
        return tuple(found), tuple(again)


def read_sheet(document: Document, mm_per_unit: float, layer: str | None = None, *, hidden: bool = False) -> Sheet:
    """Reads the model space, on one layer or on all; with `hidden` its hidden edges as if they were visible."""
    wanted = None if layer is None else layer.casefold()
    meanings = Meanings(document.drawing)
    everything = unfolded(document.entities)
    entities = everything if wanted is None else [entity for entity in everything if entity.layer.casefold() == wanted]
    drawn = [entity for entity in entities if meanings.is_edge(entity) or (hidden and meanings.is_hidden_edge(entity))]
    edges = edges_of(drawn, mm_per_unit)
    axes = centre_lines(edges_of([entity for entity in everything if meanings.is_centre(entity)], mm_per_unit))
    hatched = _hatched([entity for entity in entities if entity.kind == "HATCH"], mm_per_unit)
    views, notes = _views(edges, axes, hatched)
    return Sheet(edges, tuple(views), (*_left_out(entities, drawn, hidden), *notes))


def _views(edges: Edges, axes: Sequence[CentreLine], hatched: Hatched) -> tuple[list[View], list[str]]:
    """About the centre lines; where there is none, about y = 0 or, if all lies off that, about what it mirrors at.

    What mirrors may be a plain ring beside its axis as well, if it is a rectangle: then there are both.
    """
    within = CHAIN_WITHIN_MM
    if axes:
        longest = sorted(axes, key=lambda axis: -axis.length_mm)[:MOST_AXES]
        views, notes = chosen_views([view_about(axis, edges, hatched, within) for axis in longest], within)
        kept = [view.axis for view in views]
        left_out = [f"{len(axes) - MOST_AXES} shorter centre lines were left out."] * (len(axes) > MOST_AXES)
        return [view_about(axis, _nearest(edges, axis, kept), hatched, within) for axis in kept], [*left_out, *notes]
    at_zero = view_about(AT_ZERO, edges, hatched, within)
    mirror, heights = _mirror_of(edges), np.concatenate([edges.start_mm[:, 0], edges.end_mm[:, 0]])
    if mirror is None or heights.min() * heights.max() <= 0:
        return [at_zero], []
    about = view_about(mirror, edges, hatched, within)
    if not about.halves[0].mirrored or about.likeness < LIKE:
        return [at_zero], []
    plain = [candidate for candidate in candidates_of(about, within, alone=True) if is_box(candidate)]
    return ([about, at_zero] if plain else [about]), []


def _nearest(edges: Edges, axis: CentreLine, axes: Sequence[CentreLine]) -> Edges:
    """The edges to which none of the other axes is nearer."""
    least = axis.distance_mm(edges.middle_mm)
    nearer = [other.distance_mm(edges.middle_mm) < least for other in axes if other is not axis]
    return edges.take(~np.any(nearer, axis=0)) if nearer else edges


def _mirror_of(edges: Edges) -> CentreLine | None:
    """The height at which most horizontal lines have their like on the other side."""
    (y0, x0), (y1, x1) = edges.start_mm.T, edges.end_mm.T
    flat = edges.is_line & (np.abs(y0 - y1) <= CHAIN_WITHIN_MM)
    ends = np.round(np.sort(np.stack([x0, x1], axis=1)[flat], axis=1), 2)
    level: dict[tuple[float, float], list[float]] = {}
    for left, right, y in np.column_stack([ends, y0[flat]]).tolist():
        level.setdefault((left, right), []).append(y)
    votes = Counter(
        round((a + b) / 2, 3)
        for heights in level.values()
        if len(heights) <= MOST_ALIKE
        for a, b in combinations(heights, 2)
    )
    if not votes:
        return None
    return CentreLine(False, votes.most_common(1)[0][0], -np.inf, np.inf, "mirror line of both halves")


def _candidates(views: Sequence[View]) -> tuple[list[Candidate], list[str]]:
    """Each shape once, from the left; and how many more times it is drawn."""
    by_view = [candidates_of(view, CHAIN_WITHIN_MM, alone=view.axis is AT_ZERO) for view in views]
    if not any(by_view):
        by_view = [candidates_of(view, CHAIN_WITHIN_MM, alone=True) for view in views]
    found: list[Candidate] = []
    again = 0
    for candidate in sorted(
        (candidate for each in by_view for candidate in each), key=lambda candidate: not candidate.from_section
    ):
        if any(same_shape(candidate, other, CHAIN_WITHIN_MM) and candidate.view is not other.view for other in found):
            again += 1
        else:
            found.append(candidate)
    return sorted(found, key=_from_left), [f"{again} contours are drawn again in another view."] * bool(again)


def _from_left(candidate: Candidate) -> tuple[float, float]:
    lower = min((candidate.features[0].start_mm, candidate.features[-1].end_mm), key=lambda point: point[1])
    ((across, up),) = candidate.view.on_sheet(np.array([lower])).tolist()
    return across, up


def _hatched(hatches: Sequence[DrawnEntity], mm_per_unit: float) -> Hatched:
    """Returns whether places of the sheet, to the right and up, are in a hatched area; islands are not."""
    from ezdxf import path

    outlines = [list(way.flattening(FLAT)) for hatch in hatches for way in path.from_hatch(hatch.entity)]
    rings = [np.array([(point.x, point.y) for point in way]) * mm_per_unit for way in outlines if len(way) > 2]

    def hatched(places: Array) -> Mask:
        inside = np.zeros(len(places), dtype=bool)
        for ring in rings:
            inside ^= _are_in(ring, places)
        return inside

    return hatched


def _are_in(ring: Array, places: Array) -> Mask:
    """Counts how often a way to the right crosses the ring; an odd count is inside."""
    found = np.zeros(len(places), dtype=bool)
    near = np.flatnonzero(np.all((places >= ring.min(axis=0)) & (places <= ring.max(axis=0)), axis=1))
    (x0, y0), (x1, y1) = ring.T, np.roll(ring, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):  # a level side is crossed by none
        for some in np.array_split(near, len(near) * len(ring) // AT_ONCE + 1):
            x, y = places[some, :, None].transpose(1, 0, 2)
            crossed = ((y0 > y) != (y1 > y)) & (x0 + (y - y0) * (x1 - x0) / (y1 - y0) > x)
            found[some] = np.count_nonzero(crossed, axis=1) % 2 == 1
    return found


def _left_out(entities: Sequence[DrawnEntity], drawn: Sequence[DrawnEntity], hidden: bool) -> Iterator[str]:
    for kind, count in sorted(Counter(e.kind for e in entities if e.kind not in {*READ, "HATCH"}).items()):
        yield f"{count} {kind} entities were not read."
    read, kept = (sum(e.kind in READ for e in some) for some in (entities, drawn))
    if (aside := read - kept) > 0:
        yield f"{aside} entities on hidden layers or not drawn in a continuous line were left out."
    if hidden:
        yield "Hidden (dashed) edges were read: no bore is drawn in continuous lines."
