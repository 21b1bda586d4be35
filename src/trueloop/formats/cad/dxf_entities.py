"""Entities of a drawing as features in mm, x up and z to the right on the sheet."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, Final

import numpy as np

from trueloop.formats.cad.dxf_chain import Segment
from trueloop.formats.cad.dxf_document import Drawn, drawn
from trueloop.geometry.curve_kinds import b_spline
from trueloop.geometry.feature import Arc, Feature, Line, Point

CHAIN_WITHIN_MM: Final = 1e-3
"""Ends of drawn entities that lie closer are one point."""
MOST_MM: Final = 1e9
"""No part lies as far from its zero; beyond, a point is damage."""
READ: Final = {"LINE", "ARC", "LWPOLYLINE", "POLYLINE", "SPLINE", "ELLIPSE"}
DEEPEST: Final = 8
"""Blocks within blocks are read so deep."""


def unfolded(entities: Iterable[Drawn], deep: int = 0) -> Iterator[Drawn]:
    """Yields the entities, those of blocks in place of the block, on its layer where theirs is 0."""
    for one in entities:
        if one.kind != "INSERT" or deep >= DEEPEST:
            yield one
            continue
        parts = map(drawn, one.entity.virtual_entities())
        yield from unfolded([part._replace(layer=one.layer) if part.layer == "0" else part for part in parts], deep + 1)


def segments_of(entities: Iterable[Drawn], mm_per_unit: float) -> Iterator[Segment]:
    """Yields lines, arcs, polylines with bulges, ellipses, splines, each on its layer; no circles and no others."""
    for one in entities:
        feature: Feature | None = None
        if one.kind in ("LWPOLYLINE", "POLYLINE"):
            parts = (drawn(part)._replace(layer=one.layer) for part in one.entity.virtual_entities())
            yield from segments_of(parts, mm_per_unit)
        elif one.kind == "LINE":
            feature = _line(one, mm_per_unit)
        elif one.kind == "ARC":
            feature = _arc(one.entity, mm_per_unit) if one.entity else _plain_arc(one.numbers, mm_per_unit)
        elif one.kind in ("SPLINE", "ELLIPSE") and (curve := _spline(one.entity)) is not None:
            yield _curve(curve, mm_per_unit, one.layer)
        if feature is not None and feature.length_mm > CHAIN_WITHIN_MM:
            yield Segment(feature, one.layer)


def _line(one: Drawn, mm_per_unit: float) -> Line:
    if one.entity:
        return Line("", _point(one.entity.dxf.start, mm_per_unit), _point(one.entity.dxf.end, mm_per_unit))
    x0, y0, x1, y1 = one.numbers
    return Line("", _at(x0, y0, mm_per_unit), _at(x1, y1, mm_per_unit))


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
    """The B-spline of an entity; None of a closed one, which is no edge of a turned part."""
    from ezdxf.math import BSpline

    if entity.dxftype() == "ELLIPSE":
        ellipse = entity.construction_tool()
        return None if ellipse.param_span > 2 * math.pi - 1e-9 else BSpline.from_ellipse(ellipse)
    return None if entity.closed else entity.construction_tool()


def _curve(spline: Any, mm_per_unit: float, layer: str) -> Segment:
    """Raises GEO-CURVE where it has a corner or a cusp. A straight one is a line."""
    control = np.array([_point(point, mm_per_unit) for point in spline.control_points])
    start, end = ((float(x), float(z)) for x, z in (control[0], control[-1]))
    chord = Line("", start, end)
    if math.dist(start, end) > CHAIN_WITHIN_MM and np.max(np.abs(chord.locate(control)[1])) < CHAIN_WITHIN_MM:
        return Segment(chord, layer)
    weights = np.array(spline.weights(), dtype=np.float64) if spline.is_rational else None
    return Segment(b_spline("", control, np.array(spline.knots()), spline.degree, weights), layer)


def _point(vector: Any, mm_per_unit: float) -> Point:
    return _at(float(vector.x), float(vector.y), mm_per_unit)


def _at(x: float, y: float, mm_per_unit: float) -> Point:
    point = y * mm_per_unit, x * mm_per_unit
    if not (abs(point[0]) <= MOST_MM and abs(point[1]) <= MOST_MM):
        raise ValueError(f"a point at x = {x:g}, y = {y:g}")
    return point
