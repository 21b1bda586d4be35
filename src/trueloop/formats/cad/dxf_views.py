"""The views of a sheet: which of its centre lines are axes of turned parts, and what contours are drawn about each."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.contour import Contour, middle_mm
from trueloop.formats.cad.dxf_cells import Half, Hatched, Walled, halves, walled
from trueloop.formats.cad.dxf_edges import Edges
from trueloop.formats.cad.dxf_entities import CentreLine
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
    """A contour that a drawing may mean, its material on the right; `by_lines`: no hatching tells its bore."""

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
