"""Reads a profile from a DXF drawing: the outside or the bore of a part, in whatever view it is drawn.

A horizontal centre line is the axis, its direction that of z (of a vertical one upwards); without one the axis is
y = 0, or what both halves mirror at. What is drawn in another line type than continuous, on hidden layers, and on the
axis, is not an edge of the part. An open chain, a half section, a section of a hollow part and a view of both halves
all give contours.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np
from scipy.spatial import KDTree

from trueloop.arrays import Array
from trueloop.collector import put_off
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cad.box_index import TooDenseError
from trueloop.formats.cad.dxf_document import Document, open_document
from trueloop.formats.cad.dxf_edges import Edges, Numbers
from trueloop.formats.cad.dxf_entities import CHAIN_WITHIN_MM
from trueloop.formats.cad.dxf_sheet import Candidate, Sheet, View, read_sheet
from trueloop.formats.input_file import FilePath
from trueloop.geometry.feature import Feature, Line
from trueloop.geometry.profile import Side, named_by_kind
from trueloop.geometry.validate import from_chuck, place_words
from trueloop.units import MM_PER_INCH
from trueloop.wording import wording

if TYPE_CHECKING:
    from ezdxf.document import Drawing

MM_PER_UNIT: Final = {1: MM_PER_INCH, 2: 12 * MM_PER_INCH, 4: 1.0, 5: 10.0, 6: 1000.0, 9: MM_PER_INCH / 1000, 13: 1e-3}
"""DXF header $INSUNITS: inch, foot, mm, cm, m, mil, µm."""

Zero: TypeAlias = Literal["drawing", "free-end", "chuck-end"]
"""From where z is counted: from the drawing's x = 0, or from an end of the part in its view."""

UNIT_CODES: Final = {"mm": 4, "inch": 1}
LISTED: Final = 6
"""So many contours a refusal lists."""


@dataclass(frozen=True)
class DxfProfile:
    """Features with the material on the right, not yet checked as a profile, and in words how the drawing was read."""

    features: tuple[Feature, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class DxfSheet:
    """A drawing before a contour of it is chosen: the sheet, and the contours of the side that was asked for."""

    sheet: Sheet
    contours: tuple[Candidate, ...]
    notes: tuple[str, ...]
    file: Path

    @put_off()
    def chosen(
        self, outline: int | None = None, *, x_is: Literal["radius", "diameter"] = "radius", zero: Zero = "drawing"
    ) -> DxfProfile:
        """Returns the only contour, or that of the number from 1; z counted as in `read_dxf`. Raises GEO-DXF-CHOICE."""
        if outline is None and len(self.contours) == 1:
            outline = 1
        if outline is None or not 1 <= outline <= len(self.contours):
            raise self._choice(outline)
        one = self.contours[outline - 1]
        features = list(_halved(one, self.file)) if x_is == "diameter" else one.features
        with _refusing_damage(self.file):
            up = np.array([0.0, -self._zero_mm(one, zero)])
        moved = Edges.of(features, one.layers[:1] * len(features)).mapped(np.eye(2), up).features if up[1] else features
        return DxfProfile(named_by_kind(moved), (*self.notes, *_about(one, self, zero)))

    def _zero_mm(self, candidate: Candidate, zero: Zero) -> float:
        """Where z of the view is to be 0: at an end of all that is drawn of the part."""
        if zero == "drawing":
            return 0.0
        whole = [each for each in (*self.sheet.candidates, candidate) if each.view is candidate.view]
        z = [z for each in whole for z in each.box_mm[1:]]
        return max(z) if zero == "free-end" else min(z)

    def _choice(self, number: int | None) -> TrueloopError:
        several = enumerate(self.contours[:LISTED], 1)
        found = "; ".join(f"{k}: {candidate.described}" for k, candidate in several)
        asked = "" if number is None else f", and number {number} was asked for"
        return Code.GEO_DXF_CHOICE.refusal(
            wording(
                "{n} separate chains of lines and arcs{asked}: {found}",
                n=len(self.contours),
                asked=asked,
                found=found or "none of that side",
            ),
            hint="choose one with its number (--outline, part.dxf_outline), name the layer that holds the profile "
            "alone, or erase the others; --picture draws them",
            place=Place(str(self.file)),
        )


def read_dxf(
    path: FilePath,
    *,
    layer: str | None = None,
    unit: Literal["mm", "inch"] | None = None,
    x_is: Literal["radius", "diameter"] = "radius",
    side: Literal["outside", "inside"] | Side = "outside",
    outline: int | None = None,
    zero: Zero = "drawing",
) -> DxfProfile:
    """Reads the outside or the bore in the drawing's model space (on `layer`, if given, capital or not).

    z is counted from the drawing's x = 0 (y = 0 of a vertical axis), or from an end of the part in its view (`zero`).
    `outline` is its number, from 1 from the left, where that side has several. `unit` is needed only where the drawing
    does not state one, and overrides it. An outside runs from chuck end to free end, a bore from free end to chuck end.
    Features are named cylinder-1, face-1, arc-1… as in a profile from a program.
    Raises GEO-DXF (unreadable, nothing to read, arcs in a drawing of diameters), GEO-DXF-UNIT, GEO-DXF-CHOICE (several
    contours, or a branch), GEO-GAP, GEO-CURVE (a spline with a corner).

    >>> drawing = trueloop.read_dxf(trueloop.example("dxf/piecs11.dxf"), x_is="radius")
    >>> [feature.name for feature in drawing.features]
    ['face-1', 'cylinder-1', 'face-2', 'cone-1', 'arc-1']
    """
    return read_dxf_sheet(path, layer=layer, unit=unit, side=side).chosen(outline, x_is=x_is, zero=zero)


@put_off()
def read_dxf_sheet(
    path: FilePath,
    *,
    layer: str | None = None,
    unit: Literal["mm", "inch"] | None = None,
    side: Literal["outside", "inside"] | Side = "outside",
) -> DxfSheet:
    """Reads all contours of one side of a drawing, as `read_dxf` does. Raises as that, but for the choice."""
    path, side = Path(path), Side(side)
    with _refusing_damage(path):
        document = open_document(path)
        mm_per_unit, unit_note = _scale(document.drawing, unit, path)
        sheet = read_sheet(document, mm_per_unit, layer)
        if side is Side.INSIDE and not _of_side(sheet, side):
            hidden = read_sheet(document, mm_per_unit, layer, hidden=True)
            sheet = hidden if _of_side(hidden, side) else sheet
        if not any(len(half.edges) for view in sheet.views for half in view.halves):
            raise _nothing(layer, document, path)
        contours = _single_chain(sheet, side, path) or _of_side(sheet, side)
        return DxfSheet(sheet, contours, (unit_note, *sheet.notes), path)


def _of_side(sheet: Sheet, side: Side) -> tuple[Candidate, ...]:
    return tuple(candidate for candidate in sheet.candidates if candidate.side is side)


def _single_chain(sheet: Sheet, side: Side, path: Path) -> tuple[Candidate, ...]:
    """The chains as drawn, where there is only one, or nothing that is closed. Raises GEO-GAP, GEO-DXF-CHOICE."""
    view = sheet.views[0]
    edges = view.halves[0].edges
    try:
        chains = chains_of(edges, CHAIN_WITHIN_MM, path)
    except TrueloopError:
        if not sheet.candidates:
            raise
        return ()
    if (len(chains) != 1 or len(sheet.views) != 1) and sheet.candidates:
        return ()
    features = edges.features
    ways = [[features[k].reversed() if back else features[k] for k, back in chain] for chain in chains]
    closed = [way for way in ways if max(way[0].start_mm[0], way[-1].end_mm[0]) <= CHAIN_WITHIN_MM]
    if side is Side.INSIDE and closed:
        return ()
    layers = [tuple(sorted({edges.layer[k] for k, _ in chain})) for chain in chains]
    return tuple(_drawn(way, side, of, view) for way, of in zip(ways, layers, strict=True))


def _drawn(chain: Sequence[Feature], side: Side, layers: tuple[str, ...], view: View) -> Candidate:
    """A chain in the direction that its side runs in; a chain of faces only, inwards."""
    forwards = from_chuck(chain[0].start_mm, chain[-1].end_mm, CHAIN_WITHIN_MM)
    way = chain if forwards is (side is Side.OUTSIDE) else [feature.reversed() for feature in reversed(chain)]
    return Candidate(side, tuple(way), layers, view)


def _halved(candidate: Candidate, path: Path) -> Iterator[Feature]:
    """The features of a drawing whose y are diameters."""
    for feature in candidate.features:
        if not isinstance(feature, Line):
            x, z = feature.start_mm
            raise _refusal(
                path,
                f"a drawing whose y are diameters holds a curve at x = {x:.4f} mm, z = {z:.4f} mm",
                "an arc is round in one scale only: draw radii, or straight lines",
            )
        ends = ((point[0] / 2, point[1]) for point in (feature.start_mm, feature.end_mm))
        yield Line(feature.name, *ends)


def _about(candidate: Candidate, read: DxfSheet, zero: Zero) -> Iterator[str]:
    """The decisions for this contour, in words."""
    axis, half = candidate.view.axis, candidate.view.halves[0]
    at = f"{'y' if axis.vertical else 'x'} = 0 of the drawing" if zero == "drawing" else f"the {zero.replace('-', ' ')}"
    if axis.vertical or axis.at_mm or zero != "drawing":
        up = "upwards " if axis.vertical else ""
        yield f"The axis is the {axis.source} at {axis.where}; z is counted {up}from {at}."
    if candidate.view.on_axis:
        yield f"{candidate.view.on_axis} lines on the axis were left out."
    if half.mirrored:
        yield f"{half.mirrored} lines and arcs below the axis mirror those above."
    if half.unlike:
        yield f"{half.unlike} lines and arcs below the axis are unlike those above: the upper half counts."
    if candidate.by_lines:
        yield "Nothing is hatched: what is closed off around the axis and open at an end face is taken for the bore."
    if (beside := len(half.edges) - len(candidate.features)) > 0 and read.sheet.candidates:
        yield f"{beside} lines and arcs beside the contour were left out."
    for k, other in enumerate(read.contours, 1):
        if other is not candidate:
            yield f"Another contour is there, number {k}: {other.described}."


@contextmanager
def _refusing_damage(path: Path) -> Iterator[None]:
    """Describes an exception of ezdxf over a damaged file, when it is opened or its entities are read."""
    from ezdxf.lldxf.const import DXFError

    damage = (
        *(OSError, ValueError, ArithmeticError, LookupError, TypeError, AttributeError, RecursionError, DXFError),
        StopIteration,  # a header that does not end
    )
    try:
        yield
    except TooDenseError as error:
        hint = "erase what is not the profile and save the drawing again"
        raise _refusal(path, f"the drawing is too dense: {error}", hint) from error
    except damage as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise _refusal(path, f"the drawing cannot be read: {reason}", "save it again as DXF R12 or later") from error


def _scale(drawing: "Drawing", unit: str | None, path: Path) -> tuple[float, str]:
    """Millimetres per drawing unit, and where that comes from."""
    stated = int(drawing.header.get("$INSUNITS", 0))
    code = UNIT_CODES[unit] if unit else stated
    if code not in MM_PER_UNIT:
        raise Code.GEO_DXF_UNIT.refusal(
            wording("the drawing states no length unit that is known here ($INSUNITS = {stated})", stated=stated),
            hint=wording("say which it is: mm or inch"),
            place=Place(str(path)),
            values={"insunits": stated},
        )
    source = f"as given ($INSUNITS = {stated})" if unit else f"by $INSUNITS = {stated}"
    return MM_PER_UNIT[code], f"One drawing unit is {MM_PER_UNIT[code]:g} mm, {source}."


def _nothing(layer: str | None, document: Document, path: Path) -> TrueloopError:
    where = f"layer '{layer}'" if layer else "the model space"
    layers = sorted({entity.layer for entity in document.entities})
    return _refusal(
        path, f"0 lines, arcs and polylines off the axis in {where}", f"layers in use: {', '.join(layers) or 'none'}"
    )


def _refusal(path: Path, message: str, hint: str) -> TrueloopError:
    return Code.GEO_DXF.refusal(message, hint=hint, place=Place(str(path)))


SLIP: Final = 100.0
"""Free ends that lie apart by more than the tolerance but less than this many times it were meant to meet."""

Chain: TypeAlias = list[tuple[int, bool]]
"""Numbers of edges, and whether each is run from its end to its start."""


def chains_of(edges: Edges, within_mm: float, path: Path) -> list[Chain]:
    """Returns edges put head to tail where ends lie within the tolerance; each chain in either direction.

    Raises GEO-DXF-CHOICE where three ends meet or a chain is closed, GEO-GAP where two free ends nearly meet.
    """
    if not len(edges):
        return []
    ends = np.stack([edges.start_mm, edges.end_mm], axis=1).reshape(-1, 2)
    tree = KDTree(ends)
    first, meeting = np.unique(ends, axis=0, return_index=True, return_counts=True)[1:]
    crowded = np.sort(first[meeting > 2])  # a search for the nearest takes n × n at n ends in one place
    if not len(crowded):
        near = _nearest(tree, ends, within_mm)
        others = (near < tree.n) & (near != np.arange(tree.n)[:, None])
        crowded = np.flatnonzero(others.sum(axis=1) > 1)
    for end in crowded:
        count = tree.query_ball_point(ends[end], within_mm, return_length=True)
        raise _choice(path, f"{count} ends meet at {place_words(ends[end])}", "leave one way on at every point")
    free = np.flatnonzero(~others.any(axis=1))
    _refuse_slip(ends, free, within_mm, path)
    chains = _walk(np.where(others, near, -1).max(axis=1).tolist(), free.tolist())
    if (left := len(edges) - sum(map(len, chains))) > 0:
        raise _choice(
            path, f"{left} segments form closed outlines off the axis", "draw the turned side as an open chain"
        )
    return chains


def _walk(meets: Sequence[int], free: Sequence[int]) -> list[Chain]:
    """From each free end on to the other; end 2i is the start of edge i, end 2i + 1 its end; −1 meets none."""
    chains, done = list[Chain](), set[int]()
    for end in free:
        if end in done:
            continue
        chain, at = Chain(), end
        while at >= 0:
            chain.append((at // 2, bool(at % 2)))
            far = at ^ 1
            at = meets[far]
        done |= {end, far}
        chains.append(chain)
    return chains


def _nearest(tree: KDTree, points: Array, within_mm: float) -> Numbers:
    """By point, the three nearest of the tree's within a distance, itself among them; the tree's number of none."""
    return np.asarray(tree.query(points, k=3, distance_upper_bound=within_mm * (1 + 1e-12))[1])


def _refuse_slip(ends: Array, free: Numbers, within_mm: float, path: Path) -> None:
    """Refuses free ends, not of one edge, that nearly meet."""
    if not len(free):
        return
    near = np.append(free, -1)[_nearest(KDTree(ends[free]), ends[free], SLIP * within_mm)]
    slips = (near >= 0) & (near != free[:, None]) & (near != free[:, None] ^ 1)
    for i, j in np.argwhere(slips):
        first, second = ends[free[i]], ends[near[i, j]]
        gap_mm = math.dist(first, second)
        raise Code.GEO_GAP.refusal(
            f"two ends lie {gap_mm:.4f} mm apart, at {place_words(first)} and {place_words(second)}",
            hint=f"join them in the drawing: ends within {within_mm:g} mm count as one point",
            place=Place(str(path)),
            values={"gap_mm": gap_mm},
        )


def _choice(path: Path, message: str, hint: str) -> TrueloopError:
    return Code.GEO_DXF_CHOICE.refusal(message, hint=hint, place=Place(str(path)))
