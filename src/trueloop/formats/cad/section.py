"""The section of a turned solid as contours with the material on the right: outside ones and bores.

A line or an arc that turns to faces of the solid bounds what was turned, if at no angle about the axis it runs within
the material: what is milled and drilled afterwards only takes away. A solid with lugs is taken as it is at
most angles, if that is closed where the first is not.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.axis import WITHIN_MM, Axis
from trueloop.formats.cad.bodies import Body
from trueloop.formats.cad.contour import Contour, Piece, alike, chained, cut_at
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import CadFace
from trueloop.formats.cad.turned_faces import Meridian, has_place, meridians, rings
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Side

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
    """A part of the section, the material of its faces on the right.

    `here`: at which share of the angles one of the faces is; `buried`: at which there is none, but material all around.
    """

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
    """The meridians of all faces, cut where others end and where edges go round; each place and side once, with the
    faces that it turns to.
    """
    whole = [one for face in body.faces for one in meridians(face, axis)]
    nodes = [ring for face in body.faces for ring in rings(face, axis)]
    nodes += [end for one in whole for end in (one.feature.start_mm, one.feature.end_mm)]
    points = np.array(nodes).reshape(-1, 2)
    found: list[tuple[Meridian, list[CadFace]]] = []
    for one in whole:
        for feature in _at_nodes(one.feature, points):
            piece = replace(one, feature=feature)
            known = next((faces for other, faces in found if _same(piece, other)), None)
            if known is not None:
                known.append(one.face)
            elif feature.length_mm > WITHIN_MM:
                found.append((piece, [one.face]))
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
