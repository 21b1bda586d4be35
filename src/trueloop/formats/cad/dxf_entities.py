"""Entities of a drawing as features in mm, x up and z to the right on the sheet."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from trueloop.formats.cad.dxf_chain import Segment
from trueloop.formats.cad.dxf_lines import layer_of
from trueloop.geometry.curve_kinds import b_spline
from trueloop.geometry.feature import Arc, Line, Point

CHAIN_WITHIN_MM: Final = 1e-3
"""Ends of drawn entities that lie closer are one point."""
MOST_MM: Final = 1e9
"""No part lies as far from its zero; beyond, a point is damage."""
READ: Final = {"LINE", "ARC", "LWPOLYLINE", "POLYLINE", "SPLINE", "ELLIPSE"}
DEEPEST: Final = 8
"""Blocks within blocks are read so deep."""


def unfolded(entities: Sequence[Any], deep: int = 0) -> Iterator[Any]:
    """Yields the entities, those of blocks in place of the block, on its layer where theirs is 0."""
    for entity in entities:
        if entity.dxftype() != "INSERT" or deep >= DEEPEST:
            yield entity
            continue
        parts = list(entity.virtual_entities())
        for part in parts:
            if layer_of(part) == "0":
                part.dxf.layer = layer_of(entity)
        yield from unfolded(parts, deep + 1)


def segments_of(entities: Sequence[Any], mm_per_unit: float) -> Iterator[Segment]:
    """Yields lines, arcs, polylines with bulges, ellipses, splines, each on its layer; no circles and no others."""
    for entity in entities:
        kind, layer = entity.dxftype(), layer_of(entity)
        if kind in ("LWPOLYLINE", "POLYLINE"):
            for part in segments_of(list(entity.virtual_entities()), mm_per_unit):
                yield replace(part, layer=layer)
        elif kind == "LINE":
            ends = (_point(entity.dxf.start, mm_per_unit), _point(entity.dxf.end, mm_per_unit))
            if math.dist(*ends) > CHAIN_WITHIN_MM:
                yield Segment(Line("", *ends), layer)
        elif kind == "ARC":
            if (arc := _arc(entity, mm_per_unit)).length_mm > CHAIN_WITHIN_MM:
                yield Segment(arc, layer)
        elif kind in ("SPLINE", "ELLIPSE") and (curve := _spline(entity)) is not None:
            yield _curve(curve, mm_per_unit, layer)


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
    point = float(vector.y) * mm_per_unit, float(vector.x) * mm_per_unit
    if not all(abs(value) <= MOST_MM for value in point):
        raise ValueError(f"a point at {vector}")
    return point
