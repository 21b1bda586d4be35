"""Reads a profile from a DXF drawing: lines and arcs, single or in polylines with bulges, chained by their ends.

The drawing's x runs along the spindle (z of the part), its y is the part's x; a centre line says where the axis is.
What is drawn in another line type than continuous, on hidden layers, and on the axis, is no edge of the part. An open
chain, a half section closed at the axis, and a view of both halves with its shoulders' edges all give the one outline.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cad.dxf_chain import Segment, chains_of
from trueloop.formats.cad.dxf_lines import axis_of, is_edge
from trueloop.formats.cad.dxf_outline import Half, moved, outlines, upper_half
from trueloop.formats.input_file import FilePath
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.names import named_by_kind
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
    path: FilePath,
    *,
    layer: str | None = None,
    unit: Literal["mm", "inch"] | None = None,
    x_is: Literal["radius", "diameter"] = "radius",
    outline: int | None = None,
) -> DxfProfile:
    """The one outline in the drawing's model space (on `layer`, if given, capital or not).

    `outline` is its number, from 1 from the left, where there are several. `unit` is needed only where the drawing does
    not state one, and overrides it. Features are named cylinder-1, face-1, arc-1… as in a profile from a program.
    Raises GEO-DXF (unreadable, nothing to read, arcs in a drawing of diameters), GEO-DXF-UNIT, GEO-DXF-CHOICE (several
    outlines or axes, or a branch), GEO-GAP.

    >>> drawing = trueloop.read_dxf(trueloop.example("dxf/piecs11.dxf"), x_is="radius")
    >>> [feature.name for feature in drawing.features]
    ['face-1', 'cylinder-1', 'face-2', 'cone-1', 'arc-1']
    """
    path = Path(path)
    with _refusing_damage(path):
        drawing = _open(path)
        mm_per_unit, unit_note = _scale(drawing, unit, path)
        wanted = None if layer is None else layer.casefold()
        entities = [entity for entity in drawing.modelspace() if wanted in (None, _layer(entity).casefold())]
        edges = [entity for entity in entities if is_edge(drawing, entity)]
        axis, axis_notes = axis_of(drawing, mm_per_unit, path)
        x_factor = 0.5 if x_is == "diameter" else 1.0
        drawn = [_lowered(segment, axis * x_factor) for segment in _segments(edges, mm_per_unit, x_factor, path)]
    off_axis = [segment for segment in drawn if not _on_axis(segment.feature)]
    notes = [unit_note, *axis_notes, *_left_out(entities, edges, len(drawn) - len(off_axis))]
    half = upper_half(off_axis, CHAIN_WITHIN_MM)
    if not half.segments:
        raise _nothing(layer, drawing, path)
    chain, more = _chosen(half, outline, path)
    return DxfProfile(named_by_kind(segment.feature for segment in _from_chuck(chain)), (*notes, *more))


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
            values={"insunits": stated},
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
            if (arc := _arc(entity, mm_per_unit)).length_mm > CHAIN_WITHIN_MM:
                yield Segment(arc, layer)


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


def _lowered(segment: Segment, axis_mm: float) -> Segment:
    """The segment with its x counted from the axis."""
    return replace(segment, feature=moved(segment.feature, -axis_mm)) if axis_mm else segment


def _left_out(entities: Sequence[Any], edges: Sequence[Any], on_axis: int) -> Iterator[str]:
    read = {"LINE", "ARC", "LWPOLYLINE", "POLYLINE"}
    for kind, count in sorted(Counter(e.dxftype() for e in entities if e.dxftype() not in read).items()):
        yield f"{count} {kind} entities were not read."
    if (hidden := len(entities) - len(edges)) > 0:
        yield f"{hidden} entities on hidden layers or not drawn in a continuous line were left out."
    if on_axis:
        yield f"{on_axis} lines on the axis were left out."


def _chosen(half: Half, number: int | None, path: Path) -> tuple[Sequence[Segment], list[str]]:
    """The one outline, or that of the number, and what was left out around it."""
    notes = [f"{half.mirrored} lines and arcs below the axis mirror those above."] if half.mirrored else []
    if half.unlike:
        notes.append(f"{half.unlike} lines and arcs below the axis are unlike those above: the upper half counts.")
    closed = outlines(half.segments, CHAIN_WITHIN_MM)
    try:
        chains = chains_of(half.segments, CHAIN_WITHIN_MM, path)
    except TrueloopError:
        if not closed:
            raise
        chains = []
    if len(chains) != 1 and closed:
        chains = [list(one.chain) for one in closed]
    if number is None and len(chains) == 1:
        number = 1
    if number is None or not 1 <= number <= len(chains):
        found = "; ".join(f"{k}: {_described(chain)}" for k, chain in enumerate(chains[:6], 1))
        asked = "" if number is None else f", and number {number} was asked for"
        raise TrueloopError(
            Code.GEO_DXF_CHOICE,
            f"{len(chains)} separate chains of lines and arcs{asked}: {found}",
            hint="choose one with its number (--outline, part.dxf_outline), name the layer that holds the profile "
            "alone, or erase the others",
            place=Place(str(path)),
        )
    if closed and len(half.segments) > len(chains[number - 1]):
        notes.append(f"{len(half.segments) - len(chains[number - 1])} lines and arcs beside the outline were left out.")
    return chains[number - 1], notes


def _nothing(layer: str | None, drawing: "Drawing", path: Path) -> TrueloopError:
    where = f"layer '{layer}'" if layer else "the model space"
    layers = sorted({_layer(entity) for entity in drawing.modelspace()})
    return _refusal(
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


def _refusal(path: Path, message: str, hint: str) -> TrueloopError:
    return TrueloopError(Code.GEO_DXF, message, hint=hint, place=Place(str(path)))
