"""The section of a turned solid as contours with the material on the right: outside ones and bores.

A line or an arc that turns to faces of the solid bounds what was turned, if at no angle about the axis it runs within
the material: what is milled and drilled afterwards only takes away. A solid with lugs is taken as it is at
most angles, if that is closed where the first is not.
Its bodies are the closed solids of a STEP or IGES file, under the names that the file gives them.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place
from trueloop.formats.cad.contour import Contour, Piece, alike, chained, cut_at
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import STEP, CadFace, read_document, read_shape
from trueloop.formats.cad.step_tolerances import FACES, Records
from trueloop.formats.cad.turned_faces import WITHIN_MM, Axis, Meridian, has_place, meridians, rings
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Side

SEWN_WITHIN_MM: Final = 1e-3
"""Edges of loose faces that lie closer are one edge."""


@dataclass(frozen=True, eq=False)
class Body:
    """A solid of a file, its name there ("" where it has none), and its faces, numbered from 1 within it."""

    name: str
    solid: Any
    faces: tuple[CadFace, ...]


@dataclass(frozen=True, eq=False)
class Solids:
    """All bodies of a file, and the kernel's reader of a STEP file, which knows the record of every face."""

    bodies: tuple[Body, ...]
    reader: Any = None

    def numbered(self, faces: Sequence[CadFace], records: Records) -> Iterator[tuple[int, CadFace]]:
        """Faces with the numbers of the records that they come from; nothing for a file without such."""
        if self.reader is None:
            return
        session = self.reader.ChangeReader().WS()
        model, made = session.Model(), session.TransferReader()
        if model.NbEntities() != len(records.numbers):
            return
        known = [(n, model.Value(k)) for k, n in enumerate(records.numbers, 1) if set(records.of[n].types) & FACES]
        number = {id(record): n for n, record in known}  # the kernel gives one object for one record, while it is kept
        for face in faces:
            record = made.EntityFromShapeResult(face.handle.Located(kernel().Location()), -1)
            if id(record) in number:
                yield number[id(record)], face


def read_solids(path: Path) -> Solids:
    """Reads the bodies in the file's order; loose faces, as IGES has them, are sewn together.

    Raises SRF-CAD for a file that cannot be read, SRF-CAD-KERNEL without the kernel, GEO-STEP where its faces close no
    solid.
    """
    if path.suffix.lower() in STEP:
        document, reader = read_document(path)
        named = list(_of_document(document))
    else:
        reader, named = None, [("", solid) for solid in _all(read_shape(path), kernel().SOLID)]
    if not named:
        named = [("", solid) for solid in _sewn(read_shape(path), path)]
    bodies = (Body(name, kernel().as_solid(solid), tuple(_faces(path, solid))) for name, solid in named)
    return Solids(tuple(bodies), reader)


def _of_document(document: Any) -> Iterator[tuple[str, Any]]:
    occ = kernel()
    roots = occ.Labels()
    occ.shapes_of(document.Main()).GetFreeShapes(roots)
    for root in roots:
        yield from _of_label(root, occ.Location(), "")


def _of_label(label: Any, place: Any, above: str) -> Iterator[tuple[str, Any]]:
    """The solids of one product, and those of the products that it is put together from, where they stand."""
    occ, name = kernel(), _name(label) or above
    parts = occ.Labels()
    if occ.ShapeTool.IsAssembly_s(label) and occ.ShapeTool.GetComponents_s(label, parts):
        for part in parts:
            product = occ.Label()
            if occ.ShapeTool.GetReferredShape_s(part, product):
                yield from _of_label(product, place * occ.ShapeTool.GetLocation_s(part), _name(part) or name)
        return
    solids = list(_all(occ.ShapeTool.GetShape_s(label), occ.SOLID))
    for k, solid in enumerate(solids, 1):
        yield (name if len(solids) == 1 else f"{name}/{k}"), solid.Moved(place)


def _name(label: Any) -> str:
    occ, found = kernel(), kernel().Name()
    return str(found.Get().ToExtString()) if label.FindAttribute(occ.Name.GetID_s(), found) else ""


def _sewn(shape: Any, path: Path) -> Iterator[Any]:
    occ = kernel()
    sewing = occ.Sewing(SEWN_WITHIN_MM)
    sewing.Add(shape)
    sewing.Perform()
    closed = [shell for shell in _all(sewing.SewedShape(), occ.SHELL) if shell.Closed()]
    if not closed:
        raise Code.GEO_STEP.refusal(
            f"the {sum(1 for _ in _all(shape, occ.FACE))} faces of {path.name!r} close 0 solids",
            hint="export the part as a solid",
            place=Place(str(path)),
        )
    for shell in closed:
        solid = occ.MakeSolid(occ.as_shell(shell)).Solid()
        occ.orient_closed(solid)
        yield solid


def _faces(path: Path, solid: Any) -> Iterator[CadFace]:
    occ = kernel()
    for number, face in enumerate(_all(solid, occ.FACE), 1):
        yield CadFace(path, number, occ.as_face(face))


def _all(shape: Any, kind: Any) -> Iterator[Any]:
    explorer = kernel().Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


LOOKED_AT_MM: Final = 1e-6
ANGLES_RAD: Final = tuple(np.arange(36) * math.pi * (3 - math.sqrt(5)))
"""About the axis, at the golden angle: no pattern of holes or teeth is met by all of them alike."""

ANY: Final = 1.5 / len(ANGLES_RAD)
"""More than at one of the angles: at a single place the kernel errs now and then."""
MOST: Final = 0.5


def contours_of(body: Body, axis: Axis) -> list[Contour]:
    """Returns all contours of a body, those of the outside first, each side from the chuck."""
    bounding = list(_bounding(body, axis))
    found = chained(_pieces(bounding, ANY), body.name)
    if _is_open(found):
        most = chained(_pieces(bounding, MOST), body.name)
        if most and not _is_open(most):
            found = [replace(contour, by_most=True) for contour in most]
    return sorted(found, key=lambda contour: (contour.side is Side.INSIDE, min(end[1] for end in contour.ends)))


def _is_open(contours: Sequence[Contour]) -> bool:
    return any(contour.open_at for contour in contours if contour.side is Side.OUTSIDE)


@dataclass(frozen=True)
class _Bounding:
    """A part of the section, material right; `here`: angles' share with a face; `buried`: in material all around."""

    piece: Meridian
    here: float
    buried: float


def _bounding(body: Body, axis: Axis) -> Iterator[_Bounding]:
    inside = _inside(body.solid)
    for piece, faces in _cut(body, axis):
        at = piece.middle_mm
        places = [axis.at(at, turn) for turn in ANGLES_RAD]
        out_of = [place for place in places if not any(has_place(face, place) for face in faces)]
        if len(out_of) < len(places):
            buried = sum(inside(place) for place in out_of)
            yield _Bounding(piece, 1 - len(out_of) / len(places), buried / len(places))


def _cut(body: Body, axis: Axis) -> list[tuple[Meridian, list[CadFace]]]:
    """The meridians of all faces, cut where others end and edges go round; each place and side once, with its faces."""
    whole = [meridian for face in body.faces for meridian in meridians(face, axis)]
    nodes = [ring for face in body.faces for ring in rings(face, axis)]
    nodes += [end for meridian in whole for end in (meridian.feature.start_mm, meridian.feature.end_mm)]
    points = np.array(nodes).reshape(-1, 2)
    found: list[tuple[Meridian, list[CadFace]]] = []
    for meridian in whole:
        for feature in _at_nodes(meridian.feature, points):
            piece = replace(meridian, feature=feature)
            known = next((faces for other, faces in found if _same(piece, other)), None)
            if known is not None:
                known.append(meridian.face)
            elif feature.length_mm > WITHIN_MM:
                found.append((piece, [meridian.face]))
    return found


def _same(a: Meridian, b: Meridian) -> bool:
    """Returns whether two pieces run through the same places, in the same direction."""
    there = math.dist(a.feature.start_mm, b.feature.start_mm) + math.dist(a.middle_mm, b.middle_mm)
    return there < WITHIN_MM and alike(a.feature, b.feature, WITHIN_MM)


def _at_nodes(feature: Feature, points: Array) -> list[Feature]:
    along, aside = feature.locate(points)
    on = (np.abs(aside) < WITHIN_MM) & (along > 0) & (along < feature.length_mm)
    return cut_at(feature, [(float(x), float(z)) for x, z in points[on]], WITHIN_MM)


def _inside(solid: Any) -> Callable[[Array], bool]:
    """Returns whether a place is in the material, or on its surface."""
    occ = kernel()
    classifier = occ.SolidClassifier(solid)

    def inside(place: Array) -> bool:
        classifier.Perform(occ.Pnt(*place.tolist()), LOOKED_AT_MM)
        return bool(classifier.State() != occ.OUT)

    return inside


def _pieces(bounding: Sequence[_Bounding], enough: float) -> list[Piece]:
    """Returns the pieces with material on one side, and not on the other, at more than this share of the angles."""
    return [
        Piece(one.piece.feature, one.here + one.buried)
        for one in bounding
        if one.buried <= enough < one.here + one.buried
    ]
