"""The material in a half view: the cells between its lines, less those that are the bore of a section."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trueloop.formats.cad.contour import Contour, Piece, chained
from trueloop.formats.cad.dxf_chain import Segment
from trueloop.formats.cad.dxf_outline import Graph, cut_where_met, heading, turn_rad
from trueloop.geometry.feature import Feature, Line, Point

Hatched: TypeAlias = Callable[[Point], bool]
"""Maps a place of the half view, (x, z), to whether it is hatched."""

ASIDE_MM: Final = 0.02
"""The distance inside its edges at which a cell is sampled; less where an edge is short."""
AXIS: Final = "axis"


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


def walled(segments: Sequence[Segment], hatched: Hatched, within_mm: float) -> list[Walled]:
    """Returns every connected part of a half view that closes cells, with the axis or without it."""
    graph = Graph(cut_where_met(segments, within_mm), within_mm)
    found = []
    for component in graph.components():
        cells = _Cells(graph, graph.leading_on(component), within_mm)
        if cells.bounded:
            full = cells.hatched(hatched)
            bore, whole = cells.bore(full), tuple(cells.contours(set()))
            hollow = bool(full) if bore else None
            found.append(Walled(tuple(cells.contours(bore)) if bore else whole, hollow, bool(full), whole))
    return found


Step: TypeAlias = tuple[int, bool]
"""A piece and whether it is run forwards."""


class _Cells:
    """The cells of one component: closed walks with the cell on the right."""

    def __init__(self, graph: Graph, edges: set[int], within_mm: float) -> None:
        self.graph, self.within_mm = graph, within_mm
        self.pieces = {index: graph.pieces[index] for index in edges}
        self.ends = {index: graph.ends[index] for index in edges}
        self._close_on_axis()
        self.at: dict[int, list[Step]] = {}
        for index, (a, b) in self.ends.items():
            self.at.setdefault(a, []).append((index, True))
            self.at.setdefault(b, []).append((index, False))
        walks = list(self._walks())
        self.bounded = [walk for walk in walks if self._area(walk) < -(within_mm**2)]
        self.cell_of = {step: number for number, walk in enumerate(self.bounded) for step in walk}
        z = [end[1] for piece in self.pieces.values() for end in piece.ends]
        self.extremes = (min(z), max(z)) if z else (0.0, 0.0)

    def hatched(self, hatched: Hatched) -> set[int]:
        """Returns the cells that are hatched."""
        return {number for number, walk in enumerate(self.bounded) if self._is_hatched(walk, hatched)}

    def bore(self, full: set[int]) -> set[int]:
        """Returns the cells that are air: they lie on the axis, are not hatched, meet the outside at end faces alone,
        and are open there, themselves or by way of others.
        """
        inner = {
            number
            for number, walk in enumerate(self.bounded)
            if number not in full and any(self._is_axis(step) for step in walk) and self._meets_ends_only(walk)
        }
        found = {number for number in inner if any(self._is_mouth(step) for step in self.bounded[number])}
        while more := {n for n in inner - found if self._beside(n) & found}:
            found |= more
        return found if len(found) < len(self.bounded) else set()

    def contours(self, bore: set[int]) -> Iterator[Contour]:
        """Returns the contours of what is material."""
        material = set(range(len(self.bounded))) - bore
        pieces = []
        for number in material:
            for step in self.bounded[number]:
                if not self._is_axis(step) and self.cell_of.get(_back(step)) not in material:
                    pieces.append(Piece(self._feature(step), layer=self.pieces[step[0]].layer))
        return iter(chained(pieces, "", self.within_mm))

    def _close_on_axis(self) -> None:
        """The axis between the first and the last place where the pieces meet it."""
        nodes = {node for ends in self.ends.values() for node in ends if self.graph.on_axis(node)}
        along = sorted(nodes, key=lambda node: self.graph.points[node][1])
        for k, (a, b) in enumerate(pairwise(along)):
            index = -1 - k
            self.ends[index] = (a, b)
            self.pieces[index] = Segment(Line("", self.graph.points[a], self.graph.points[b]), AXIS)

    def _walks(self) -> Iterator[list[Step]]:
        done = set[Step]()
        for first in sorted(step for steps in self.at.values() for step in steps):
            if first in done:
                continue
            walk, step = [first], self._onward(first)
            while step != first and len(walk) <= 2 * len(self.pieces):
                walk.append(step)
                step = self._onward(step)
            done |= set(walk)
            yield walk

    def _onward(self, step: Step) -> Step:
        """The sharpest turn to the right at its end; back only where nothing else leads on."""
        index, forwards = step
        node = self.ends[index][1 if forwards else 0]
        onward = [one for one in self.at[node] if one != _back(step)]
        if not onward:
            return _back(step)
        if len(onward) == 1:
            return onward[0]
        arriving = heading(self._feature(step), first=False)
        return min(onward, key=lambda one: turn_rad(arriving, heading(self._feature(one), first=True)))

    def _feature(self, step: Step) -> Feature:
        feature = self.pieces[step[0]].feature
        return feature if step[1] else feature.reversed()

    def _area(self, walk: Sequence[Step]) -> float:
        """Positive where the walk turns left about it, which those about the bounded cells do not."""
        points: list[ArrayLike] = []
        for feature in map(self._feature, walk):
            line = isinstance(feature, Line)
            points += [feature.start_mm] if line else [*feature.point_mm(np.linspace(0, feature.length_mm, 9)[:-1])]
        x, z = np.array(points).T
        return float(np.sum(z * np.roll(x, -1) - x * np.roll(z, -1))) / 2

    def _is_axis(self, step: Step) -> bool:
        return self.pieces[step[0]].layer is AXIS

    def _is_hatched(self, walk: Sequence[Step], hatched: Hatched) -> bool:
        """At most places beside its edges."""
        places = []
        for feature in map(self._feature, walk):
            length = feature.length_mm
            aside = min(ASIDE_MM, length / 10)
            if isinstance(feature, Line):  # written out: a drawing has many
                (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
                right = aside / length
                places.append(hatched(((x0 + x1) / 2 - right * (z1 - z0), (z0 + z1) / 2 + right * (x1 - x0))))
            else:
                x, z = feature.point_mm(length / 2) - aside * feature.outward_normal(length / 2)
                places.append(hatched((float(x), float(z))))
        return sum(places) > len(places) / 2

    def _meets_ends_only(self, walk: Sequence[Step]) -> bool:
        outer = [step for step in walk if not self._is_axis(step) and _back(step) not in self.cell_of]
        return all(self._at_end(step) for step in outer)

    def _is_mouth(self, step: Step) -> bool:
        return not self._is_axis(step) and _back(step) not in self.cell_of and self._at_end(step)

    def _at_end(self, step: Step) -> bool:
        """Whether a piece is part of an end face."""
        (_, z0), (_, z1) = self.pieces[step[0]].ends
        return any(max(abs(z0 - end), abs(z1 - end)) < self.within_mm for end in self.extremes)

    def _beside(self, number: int) -> set[int]:
        return {self.cell_of[_back(step)] for step in self.bounded[number] if _back(step) in self.cell_of}


def _back(step: Step) -> Step:
    return step[0], not step[1]
