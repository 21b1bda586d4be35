"""A drawing as it lies on its sheet: its edges, its axes, and every contour of a turned part about them."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.dxf_cells import Hatched
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
from trueloop.formats.cad.dxf_views import (
    LIKE,
    Candidate,
    View,
    candidates_of,
    chosen_views,
    is_box,
    same_shape,
    view_about,
)

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
