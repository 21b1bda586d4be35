"""Entities of a drawing as edges in mm, x up and z to the right, and the meanings of their line types (ISO 128)."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.box_index import TooDenseError
from trueloop.formats.cad.dxf_document import DrawnEntity, drawn
from trueloop.formats.cad.dxf_edges import Edges
from trueloop.geometry.curve_kinds import b_spline
from trueloop.geometry.feature import Arc, Feature, Line, Point

if TYPE_CHECKING:
    from ezdxf.document import Drawing

CHAIN_WITHIN_MM: Final = 1e-3
"""Ends of drawn entities that lie closer are one point."""
MOST_MM: Final = 1e9
"""No part lies as far from its zero; beyond, a point is damage."""
READ: Final = {"LINE", "ARC", "LWPOLYLINE", "POLYLINE", "SPLINE", "ELLIPSE"}
DEEPEST: Final = 8
"""Blocks within blocks are read so deep."""
MOST_ENTITIES: Final = 150_000
NOT_PLOTTED: Final = "defpoints"
"""The layer on which CAD systems keep what belongs to dimensions."""
CENTRE: Final = ("center", "centre", "dashdot", "chain", "iso10", "iso04", "acad_iso10", "acad_iso04", "mitte", "achse")
"""Beginnings of the names of line types, and of layers, of axes."""
HIDDEN: Final = ("hidden", "dashed", "verdeckt", "iso02", "acad_iso02")
"""Beginnings of the names of line types of hidden edges."""
ONE_MM: Final = 1e-3
"""Axes whose places differ by less are one."""


@dataclass(frozen=True)
class CentreLine:
    """A horizontal or vertical line of the sheet, mm, from lower to higher end; `source`: the rule that found it."""

    vertical: bool
    at_mm: float
    low_mm: float
    high_mm: float
    source: str

    @property
    def length_mm(self) -> float:
        """Returns the length from end to end."""
        return self.high_mm - self.low_mm

    def distance_mm(self, places: Array) -> Array:
        """Returns the distances of places of the sheet, (n, 2) up and right, from the line or its nearer end."""
        across, along = places[:, ::-1].T if self.vertical else places.T
        beyond = np.maximum(np.maximum(self.low_mm - along, along - self.high_mm), 0.0)
        return np.asarray(np.hypot(across - self.at_mm, beyond))

    @property
    def where(self) -> str:
        """Its place on the sheet."""
        return f"{'x' if self.vertical else 'y'} = {self.at_mm:g} mm"


class Meanings:
    """The meaning of a drawing's lines, by their own line type and their layer, of which a drawing has few."""

    def __init__(self, drawing: "Drawing") -> None:
        self._layers = drawing.layers
        self._edge, self._hidden, self._centre = map(
            lru_cache(maxsize=4096), (self._is_edge, self._is_hidden, self._is_centre)
        )

    def is_edge(self, entity: DrawnEntity) -> bool:
        """Returns whether it is drawn as visible edges are: in a continuous line, and not on a layer of axes."""
        return self._edge(entity.layer, entity.line_type)

    def is_hidden_edge(self, entity: DrawnEntity) -> bool:
        """Returns whether it is drawn as hidden edges are: dashed."""
        return self._hidden(entity.layer, entity.line_type)

    def is_centre(self, entity: DrawnEntity) -> bool:
        """Returns whether it is drawn as axes are, by its line type or its layer's name."""
        return self._centre(entity.layer, entity.line_type)

    def _is_edge(self, layer: str, own: str) -> bool:
        plain = self._line_type(layer, own) in ("continuous", "byblock", "")
        return self._is_shown(layer) and plain and not self._is_centre(layer, own)

    def _is_hidden(self, layer: str, own: str) -> bool:
        return self._is_shown(layer) and self._line_type(layer, own).startswith(HIDDEN)

    def _is_centre(self, layer: str, own: str) -> bool:
        return self._line_type(layer, own).startswith(CENTRE) or layer.casefold().startswith(CENTRE)

    def _is_shown(self, layer: str) -> bool:
        """Returns whether a layer is shown and plotted."""
        known = self._layer(layer)
        return (known is None or not (known.is_off() or known.is_frozen())) and layer.casefold() != NOT_PLOTTED

    def _line_type(self, layer: str, own: str) -> str:
        if own != "bylayer":
            return own
        known = self._layer(layer)
        return "continuous" if known is None else str(known.dxf.get("linetype", "CONTINUOUS")).casefold()

    def _layer(self, name: str) -> Any:
        return self._layers.get(name) if name in self._layers else None


def centre_lines(edges: Edges) -> list[CentreLine]:
    """Returns horizontal and vertical lines of those drawn as axes; those in one line with a gap between are one."""
    found: list[CentreLine] = []
    at: dict[tuple[bool, int], list[int]] = {}  # those in the same µm or beside it: a drawing may have thousands
    for line in _level(edges):
        row = round(line.at_mm / ONE_MM)
        near = sorted(k for each in (row - 1, row, row + 1) for k in at.get((line.vertical, each), ()))
        for k in near:
            known = found[k]
            if abs(known.at_mm - line.at_mm) <= ONE_MM and _meet(known, line):
                low, high = min(known.low_mm, line.low_mm), max(known.high_mm, line.high_mm)
                found[k] = CentreLine(line.vertical, known.at_mm, low, high, known.source)
                break
        else:
            at.setdefault((line.vertical, row), []).append(len(found))
            found.append(line)
    return found


def _level(edges: Edges) -> Iterator[CentreLine]:
    lines = edges.take(edges.is_line)
    for (y0, x0), (y1, x1) in zip(lines.start_mm.tolist(), lines.end_mm.tolist(), strict=True):
        if abs(y0 - y1) <= ONE_MM:
            yield CentreLine(False, y0, min(x0, x1), max(x0, x1), "centre line")
        elif abs(x0 - x1) <= ONE_MM:
            yield CentreLine(True, x0, min(y0, y1), max(y0, y1), "centre line")


def _meet(a: CentreLine, b: CentreLine) -> bool:
    """Returns whether two pieces on one line are closer than the shorter of them is long."""
    gap = max(a.low_mm, b.low_mm) - min(a.high_mm, b.high_mm)
    return gap <= min(a.length_mm, b.length_mm)


def unfolded(entities: Iterable[DrawnEntity]) -> list[DrawnEntity]:
    """Returns the entities with blocks replaced by theirs. Raises TooDenseError: ten within ten within ten."""
    found = list(islice(_unfolded(entities, 0), MOST_ENTITIES + 1))
    if len(found) > MOST_ENTITIES:
        raise TooDenseError(f"more than {MOST_ENTITIES} entities, those of blocks included")
    return found


def _unfolded(entities: Iterable[DrawnEntity], deep: int) -> Iterator[DrawnEntity]:
    for entity in entities:
        if entity.kind != "INSERT" or deep >= DEEPEST:
            yield entity
            continue
        parts = map(drawn, entity.entity.virtual_entities())
        own = (part._replace(layer=entity.layer) if part.layer == "0" else part for part in parts)
        yield from _unfolded(own, deep + 1)


def edges_of(entities: Iterable[DrawnEntity], mm_per_unit: float) -> Edges:
    """Returns lines, arcs, polylines with bulges, ellipses, splines, each on its layer; no circles and no others."""
    everything = list(_of_polylines(entities))
    lines = [k for k, entity in enumerate(everything) if entity.kind == "LINE" and not entity.entity]
    numbers = np.array([everything[k].numbers for k in lines]).reshape(-1, 2, 2) * mm_per_unit
    for x, y in numbers[np.any(np.abs(numbers) > MOST_MM, axis=2)] / mm_per_unit:
        _at(float(x), float(y), mm_per_unit)
    plain = Edges.of_lines(numbers[:, 0, ::-1], numbers[:, 1, ::-1], [everything[k].layer for k in lines])
    others = [
        k for k, entity in enumerate(everything) if entity.kind in READ and (entity.kind != "LINE" or entity.entity)
    ]
    features = [_feature(everything[k], mm_per_unit) for k in others]
    read = [(k, feature) for k, feature in zip(others, features, strict=True) if feature is not None]
    rest = Edges.of([feature for _, feature in read], [everything[k].layer for k, _ in read])
    found = Edges.joined([plain, rest]).take(np.argsort([*lines, *(k for k, _ in read)], kind="stable"))
    return found.take(found.is_curve | (found.length_mm > CHAIN_WITHIN_MM))


def _of_polylines(entities: Iterable[DrawnEntity]) -> Iterator[DrawnEntity]:
    """The entities, polylines as their parts."""
    for entity in entities:
        if entity.kind in ("LWPOLYLINE", "POLYLINE"):
            yield from _of_polylines(
                drawn(part)._replace(layer=entity.layer) for part in entity.entity.virtual_entities()
            )
        else:
            yield entity


def _feature(entity: DrawnEntity, mm_per_unit: float) -> Feature | None:
    if entity.kind == "LINE":
        return Line("", _point(entity.entity.dxf.start, mm_per_unit), _point(entity.entity.dxf.end, mm_per_unit))
    if entity.kind == "ARC":
        return _arc(entity.entity, mm_per_unit) if entity.entity else _plain_arc(entity.numbers, mm_per_unit)
    return None if (curve := _spline(entity.entity)) is None else _curve(curve, mm_per_unit)


def _plain_arc(numbers: Sequence[float], mm_per_unit: float) -> Arc:
    """An arc in the plane, counter-clockwise on the sheet from one angle to the other."""
    x, y, radius, first, last = numbers
    turns = [math.radians(angle) for angle in (first, last)]
    start, end = (_at(abs(radius) * math.cos(a) + x, abs(radius) * math.sin(a) + y, mm_per_unit) for a in turns)
    return Arc("", start, end, _at(x, y, mm_per_unit), -math.radians((last - first) % 360 or 360))


def _arc(entity: Any, mm_per_unit: float) -> Arc:
    """Drawn counter-clockwise, clockwise when the entity is seen from behind; +y up is +x up: the sense stays."""
    counter_clockwise = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360 or 360)
    sweep_rad = math.copysign(counter_clockwise, -entity.dxf.extrusion.z)
    centre = entity.ocs().to_wcs(entity.dxf.center)
    start, end, middle = (_point(p, mm_per_unit) for p in (entity.start_point, entity.end_point, centre))
    return Arc("", start, end, middle, sweep_rad)


def _spline(entity: Any) -> Any:
    """The B-spline of an entity; None of a closed one, which is not an edge of a turned part."""
    from ezdxf.math import BSpline

    if entity.dxftype() == "ELLIPSE":
        ellipse = entity.construction_tool()
        return None if ellipse.param_span > 2 * math.pi - 1e-9 else BSpline.from_ellipse(ellipse)
    return None if entity.closed else entity.construction_tool()


def _curve(spline: Any, mm_per_unit: float) -> Feature:
    """Raises GEO-CURVE where it has a corner or a cusp. A straight one is a line."""
    control = np.array([_point(point, mm_per_unit) for point in spline.control_points])
    start, end = ((float(x), float(z)) for x, z in (control[0], control[-1]))
    chord = Line("", start, end)
    if math.dist(start, end) > CHAIN_WITHIN_MM and np.max(np.abs(chord.locate(control)[1])) < CHAIN_WITHIN_MM:
        return chord
    weights = np.array(spline.weights(), dtype=np.float64) if spline.is_rational else None
    return b_spline("", control, np.array(spline.knots()), spline.degree, weights)


def _point(vector: Any, mm_per_unit: float) -> Point:
    return _at(float(vector.x), float(vector.y), mm_per_unit)


def _at(x: float, y: float, mm_per_unit: float) -> Point:
    point = y * mm_per_unit, x * mm_per_unit
    if not (abs(point[0]) <= MOST_MM and abs(point[1]) <= MOST_MM):
        raise ValueError(f"a point at x = {x:g}, y = {y:g}")
    return point
