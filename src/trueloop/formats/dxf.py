"""Reads a profile from a DXF drawing: lines and arcs, single or in polylines with bulges, chained by their ends.

The drawing's x runs along the spindle (z of the part), its y is the part's x. Only the upper half of the part counts:
lines on the axis are left out, so that a closed outline of the half section works as well as an open profile.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.dxf_chain import Segment, chains_of
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.validate import from_chuck
from trueloop.units import MM_PER_INCH

if TYPE_CHECKING:
    from ezdxf.document import Drawing

MM_PER_UNIT: Final = {1: MM_PER_INCH, 2: 12 * MM_PER_INCH, 4: 1.0, 5: 10.0, 6: 1000.0, 9: MM_PER_INCH / 1000, 13: 1e-3}
"""DXF header $INSUNITS: inch, foot, mm, cm, m, mil, µm."""

UNIT_CODES: Final = {"mm": 4, "inch": 1}

CHAIN_WITHIN_MM: Final = 1e-3
"""Ends of drawn entities that lie closer are one point."""

MOST_MM: Final = 1e9
"""No part lies as far from its zero; beyond, a point is damage."""


@dataclass(frozen=True)
class DxfProfile:
    """Features from chuck end to free end, not yet checked as a profile, and in words how the drawing was read."""

    features: tuple[Feature, ...]
    notes: tuple[str, ...]


def read_dxf(
    path: Path,
    *,
    layer: str | None = None,
    unit: Literal["mm", "inch"] | None = None,
    x_is: Literal["radius", "diameter"] = "radius",
    name_by: Literal["kind", "layer"] = "kind",
) -> DxfProfile:
    """The one chain of lines and arcs in the drawing's model space (on `layer`, if given).

    `unit` is needed only where the drawing does not state one, and overrides it. Features are named line-1, arc-1… or,
    `name_by` layer, after the layers they are drawn on. Raises GEO-DXF (unreadable, nothing to read, arcs in a drawing
    of diameters), GEO-DXF-UNIT, GEO-DXF-CHOICE (several chains, or a branch), GEO-GAP.
    """
    with _refusing_damage(path):
        drawing = _open(path)
        mm_per_unit, unit_note = _scale(drawing, unit, path)
        entities = [entity for entity in drawing.modelspace() if layer is None or _layer(entity) == layer]
        segments = list(_segments(entities, mm_per_unit, 0.5 if x_is == "diameter" else 1.0, path))
    off_axis = [segment for segment in segments if not _on_axis(segment.feature)]
    notes = [unit_note, *_left_out(entities, len(segments) - len(off_axis))]
    chain = _only_chain(chains_of(off_axis, CHAIN_WITHIN_MM, path), layer, drawing, path)
    return DxfProfile(_named(_from_chuck(chain), name_by), tuple(notes))


def _open(path: Path) -> "Drawing":
    # ezdxf takes a tenth of a second to import, and most jobs have no drawing.
    from ezdxf.filemanagement import readfile

    return readfile(path)


@contextmanager
def _refusing_damage(path: Path) -> Iterator[None]:
    """What ezdxf raises over a damaged file, while it is opened or as its entities are asked, in words."""
    from ezdxf.lldxf.const import DXFError

    damage = (
        *(OSError, ValueError, ArithmeticError, LookupError, TypeError, AttributeError, RecursionError, DXFError),
        StopIteration,  # a header that does not end
    )
    try:
        yield
    except damage as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise _refusal(path, f"the drawing cannot be read: {reason}", "save it again as DXF R12 or later") from error


def _scale(drawing: "Drawing", unit: str | None, path: Path) -> tuple[float, str]:
    """Millimetres per drawing unit, and where that comes from."""
    stated = int(drawing.header.get("$INSUNITS", 0))
    code = UNIT_CODES[unit] if unit else stated
    if code not in MM_PER_UNIT:
        raise TrueloopError(
            Code.GEO_DXF_UNIT,
            f"the drawing states no length unit that is known here ($INSUNITS = {stated})",
            hint="say which it is: mm or inch",
            place=Place(str(path)),
        )
    source = f"as given ($INSUNITS = {stated})" if unit else f"by $INSUNITS = {stated}"
    return MM_PER_UNIT[code], f"One drawing unit is {MM_PER_UNIT[code]:g} mm, {source}."


def _segments(entities: Sequence[Any], mm_per_unit: float, x_factor: float, path: Path) -> Iterator[Segment]:
    for entity in entities:
        kind, layer = entity.dxftype(), _layer(entity)
        if kind in ("LWPOLYLINE", "POLYLINE"):
            for part in _segments(list(entity.virtual_entities()), mm_per_unit, x_factor, path):
                yield replace(part, layer=layer)
        elif kind == "LINE":
            ends = (_point(entity.dxf.start, mm_per_unit, x_factor), _point(entity.dxf.end, mm_per_unit, x_factor))
            if math.dist(*ends) > CHAIN_WITHIN_MM:
                yield Segment(Line("", *ends), layer)
        elif kind == "ARC":
            if x_factor != 1:
                raise _refusal(
                    path,
                    f"a drawing whose y are diameters holds an arc of radius {entity.dxf.radius * mm_per_unit:.4f} mm",
                    "an arc is round in one scale only: draw radii, or straight lines",
                )
            yield Segment(_arc(entity, mm_per_unit), layer)


def _arc(entity: Any, mm_per_unit: float) -> Arc:
    """Drawn counter-clockwise, clockwise when the entity is seen from behind; +y up is +x up: the sense stays."""
    counter_clockwise = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360 or 360)
    sweep_rad = math.copysign(counter_clockwise, -entity.dxf.extrusion.z)
    centre = entity.ocs().to_wcs(entity.dxf.center)
    start, end, middle = (_point(p, mm_per_unit) for p in (entity.start_point, entity.end_point, centre))
    return Arc("", start, end, middle, sweep_rad)


def _point(vector: Any, mm_per_unit: float, x_factor: float = 1.0) -> Point:
    point = float(vector.y) * mm_per_unit * x_factor, float(vector.x) * mm_per_unit
    if not all(abs(value) <= MOST_MM for value in point):
        raise ValueError(f"a point at {vector}")
    return point


def _layer(entity: Any) -> str:
    """The layer it is on; 0, as the format has it, where it names none."""
    return str(entity.dxf.get("layer", "0"))


def _on_axis(feature: Feature) -> bool:
    return isinstance(feature, Line) and max(abs(feature.start_mm[0]), abs(feature.end_mm[0])) < CHAIN_WITHIN_MM


def _left_out(entities: Sequence[Any], on_axis: int) -> Iterator[str]:
    read = {"LINE", "ARC", "LWPOLYLINE", "POLYLINE"}
    for kind, count in sorted(Counter(e.dxftype() for e in entities if e.dxftype() not in read).items()):
        yield f"{count} {kind} entities were not read."
    if on_axis:
        yield f"{on_axis} lines on the axis were left out."


def _only_chain(
    chains: Sequence[Sequence[Segment]], layer: str | None, drawing: "Drawing", path: Path
) -> Sequence[Segment]:
    if len(chains) == 1:
        return chains[0]
    if chains:
        found = "; ".join(_described(chain) for chain in chains[:6])
        raise TrueloopError(
            Code.GEO_DXF_CHOICE,
            f"{len(chains)} separate chains of lines and arcs: {found}",
            hint="name the layer that holds the profile alone, or erase the others",
            place=Place(str(path)),
        )
    where = f"layer '{layer}'" if layer else "the model space"
    layers = sorted({_layer(entity) for entity in drawing.modelspace()})
    raise _refusal(
        path,
        f"0 lines, arcs and polylines off the axis in {where}",
        f"layers in use: {', '.join(layers) or 'none'}; splines and blocks must be exploded into lines and arcs",
    )


def _described(chain: Sequence[Segment]) -> str:
    (x, z), layers = chain[0].feature.start_mm, sorted({segment.layer for segment in chain})
    return f"{len(chain)} from x = {x:.3f} mm, z = {z:.3f} mm on {', '.join(layers)}"


def _from_chuck(chain: Sequence[Segment]) -> Sequence[Segment]:
    """The chain in the direction in which z grows; a chain of faces only, inwards."""
    forwards = from_chuck(chain[0].feature.start_mm, chain[-1].feature.end_mm, CHAIN_WITHIN_MM)
    return chain if forwards else [segment.reversed() for segment in reversed(chain)]


def _named(chain: Sequence[Segment], name_by: str) -> tuple[Feature, ...]:
    stems = [s.layer if name_by == "layer" else type(s.feature).__name__.lower() for s in chain]
    total, seen = Counter(stems), Counter[str]()
    features = []
    for stem, segment in zip(stems, chain, strict=True):
        seen[stem] += 1
        alone = name_by == "layer" and total[stem] == 1
        features.append(replace(segment.feature, name=stem if alone else f"{stem}-{seen[stem]}"))
    return tuple(features)


def _refusal(path: Path, message: str, hint: str) -> TrueloopError:
    return TrueloopError(Code.GEO_DXF, message, hint=hint, place=Place(str(path)))
