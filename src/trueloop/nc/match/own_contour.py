"""The part of a contour that one of several edges cuts, as a contour of its own.

Its features stay in the part's order. Where the edge passes over what another one cuts afterwards, its own contour goes
on: one line over a groove is one feature, and two cuts that follow each other meet where their lines or circles cross.
Elsewhere two features that other edges lie between are apart.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from trueloop.geometry.feature import Feature, Line, Point
from trueloop.geometry.intersection import intersections
from trueloop.geometry.offset import from_to
from trueloop.geometry.profile import APART_MM, Junction, JunctionKind, Profile, junctions_of
from trueloop.nc.match.cutters import Cutters, CuttingEdge

IN_LINE_MM = 1e-3
"""Two features lie on one line when their ends do, as nearly as coordinates are written."""


@dataclass(frozen=True)
class OwnContour:
    """An edge's contour, and of each of its features which of the part's, by index, it is made of."""

    edge: CuttingEdge
    profile: Profile
    parts: tuple[tuple[int, ...], ...]

    def index_of(self, feature: int) -> int:
        """Returns the index here of one of the part's features."""
        return next(own for own, parts in enumerate(self.parts) if feature in parts)


def own_contour(profile: Profile, cutters: Cutters, edge: CuttingEdge) -> OwnContour:
    """Returns the contour of an edge that cuts some of the profile.

    At a concave corner with another edge's feature its own ends where the nose stops.
    """
    own = [index for index, one in enumerate(cutters.found) if one == edge]
    groups = _in_line(profile, cutters, edge, own)
    features = [_whole([_reached(profile, i, own, edge.nose_radius_mm) for i in group]) for group in groups]
    moves = [[move for i in group for move in cutters.moves(edge, i)] for group in groups]
    for k in range(len(features) - 1):
        if _apart(features[k], features[k + 1]) and _follow(moves[k], moves[k + 1]):
            features[k : k + 2] = _meeting(features[k], features[k + 1])
    return OwnContour(edge, Profile(tuple(features), _junctions(profile, features, groups), profile.side), groups)


def _reached(profile: Profile, index: int, own: Sequence[int], nose_radius_mm: float) -> Feature:
    """A feature without what the nose cannot touch of it: where it meets another edge's in a concave corner."""
    feature, last = profile.features[index], len(profile.features) - 1
    before = profile.junctions[index - 1].turn_rad if index > 0 and index - 1 not in own else 0.0
    after = profile.junctions[index].turn_rad if index < last and index + 1 not in own else 0.0
    short_mm = [nose_radius_mm * math.tan(max(-turn_rad, 0.0) / 2) for turn_rad in (before, after)]
    if sum(short_mm) >= feature.length_mm:
        return feature
    start, end = feature.point_mm([short_mm[0], feature.length_mm - short_mm[1]])
    first = (float(start[0]), float(start[1])) if short_mm[0] else feature.start_mm
    stop = (float(end[0]), float(end[1])) if short_mm[1] else feature.end_mm
    return from_to(feature, first, stop) if any(short_mm) else feature


def _in_line(profile: Profile, cutters: Cutters, edge: CuttingEdge, own: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """The features in groups that one move cuts together, with something else between them."""
    groups: list[tuple[int, ...]] = []
    for i in own:
        last = groups[-1][-1] if groups else i
        together = set(cutters.moves(edge, last)) & set(cutters.moves(edge, i))
        if groups and together and _on_one_line(profile.features[last], profile.features[i]):
            groups[-1] = (*groups[-1], i)
        else:
            groups.append((i,))
    return tuple(groups)


def _on_one_line(before: Feature, after: Feature) -> bool:
    if not (isinstance(before, Line) and isinstance(after, Line) and _apart(before, after)):
        return False
    off = before.locate([after.start_mm, after.end_mm])[1]
    return bool(np.all(np.abs(off) < IN_LINE_MM))


def _whole(features: Sequence[Feature]) -> Feature:
    if len(features) == 1:
        return features[0]
    name = " + ".join(feature.name for feature in features)
    return Line(name, features[0].start_mm, features[-1].end_mm)


def _apart(before: Feature, after: Feature) -> bool:
    return math.dist(before.end_mm, after.start_mm) > APART_MM


def _follow(before: Sequence[int], after: Sequence[int]) -> bool:
    """Returns whether a move along one feature is next to one along the other."""
    return any(abs(a - b) == 1 for a in before for b in after)


def _meeting(before: Feature, after: Feature) -> tuple[Feature, Feature]:
    """Both gone on to where they cross, the one behind its end and the other before its beginning."""
    middle = ((before.end_mm[0] + after.start_mm[0]) / 2, (before.end_mm[1] + after.start_mm[1]) / 2)
    ahead = [p for p in intersections(before, after) if _goes_on(before, after, p)]
    if not ahead:
        return before, after
    place = min(ahead, key=lambda point: math.dist(point, middle))
    return from_to(before, before.start_mm, place), from_to(after, place, after.end_mm)


def _goes_on(before: Feature, after: Feature, place: Point) -> bool:
    return float(before.locate(place)[0]) >= before.length_mm and float(after.locate(place)[0]) <= 0.0


def _junctions(
    profile: Profile, features: Sequence[Feature], groups: Sequence[tuple[int, ...]]
) -> tuple[Junction, ...]:
    """Those of the part where two features are neighbours there; else as the geometry says.

    Between features that are apart the direction turns by all that lies between: contact angles go on from there.
    """
    computed = junctions_of(features)
    ends = [(before[-1], after[0]) for before, after in pairwise(groups)]
    return tuple(
        profile.junctions[before]
        if after == before + 1
        else replace(found, turn_rad=_turn_rad(profile, before, after))
        if found.kind is JunctionKind.APART
        else found
        for (before, after), found in zip(ends, computed, strict=True)
    )


def _turn_rad(profile: Profile, before: int, after: int) -> float:
    """By how much the direction of travel turns from the end of one feature to the beginning of a later one."""
    corners = (junction.turn_rad for junction in profile.junctions[before:after])
    return math.fsum([*corners, *(feature.turn_rad for feature in profile.features[before + 1 : after])])
