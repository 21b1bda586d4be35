"""Refuses a chain of features that is not a profile, and says where and why."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Point
from trueloop.geometry.intersection import crossings
from trueloop.geometry.offset import RUNS_TOGETHER_RAD
from trueloop.geometry.profile import JunctionKind, Profile, Side, junctions_of
from trueloop.wording import wording

GAP_MM: Final = 1e-3
"""Ends that lie closer meet: coordinates rounded to 1e-5 in or 1e-3 mm are not a gap, a drawing's slip is."""


def checked_profile(
    features: Sequence[Feature],
    by_design: Mapping[tuple[str, str], JunctionKind] | None = None,
    *,
    side: Side = Side.OUTSIDE,
    gap_mm: float = GAP_MM,
) -> Profile:
    """The profile of a chain of features, or the first thing that is wrong with it.

    An outside runs from chuck end to free end, a bore (`side`) from free end to chuck end.

    Raises GEO-EMPTY, GEO-VALUE (a coordinate that is no number), GEO-NAME, GEO-LENGTH (a feature without length),
    GEO-ARC (an end off the arc's circle or sweep), GEO-GAP, GEO-AXIS (x < 0), GEO-ORDER (the material would be on the
    other side), GEO-CROSSING, GEO-JUNCTION (a junction named that does not exist, or tangent by design where directions
    differ by more than 0.02 rad).

    >>> drawing = trueloop.read_dxf(trueloop.example("dxf/piecs11.dxf"))
    >>> profile = trueloop.checked_profile(drawing.features)
    >>> [junction.kind.value for junction in profile.junctions]
    ['corner', 'corner', 'corner', 'corner']
    """
    by_design = by_design or {}
    _require_names(features)
    for feature in features:
        _require_feature(feature, gap_mm)
    _require_chain(features, side, gap_mm)
    profile = Profile(tuple(features), junctions_of(features, by_design), side)
    _require_design(profile, by_design)
    return profile


def _require_names(features: Sequence[Feature]) -> None:
    if not features:
        raise Code.GEO_EMPTY.refusal("the profile has 0 features", hint="give at least one line or arc")
    seen: set[str] = set()
    for number, feature in enumerate(features, start=1):
        if not feature.name or feature.name in seen:
            raise Code.GEO_NAME.refusal(
                f"feature {number} of {len(features)} is named '{feature.name}', "
                + ("as is one before it" if feature.name else "which is empty"),
                hint="give every feature its own name: touches are tied to features by it",
                values={"feature": feature.name},
            )
        seen.add(feature.name)


def _require_feature(feature: Feature, gap_mm: float) -> None:
    numbers = [*feature.start_mm, *feature.end_mm]
    if isinstance(feature, Arc):
        numbers += [*feature.centre_mm, feature.sweep_rad]
    if not all(map(math.isfinite, numbers)):
        raise Code.GEO_VALUE.refusal(
            f"'{feature.name}' has the coordinates {numbers}",
            hint="give finite numbers in mm",
            values={"feature": feature.name},
        )
    if feature.length_mm <= gap_mm:
        raise Code.GEO_LENGTH.refusal(
            f"'{feature.name}' at {place_words(feature.start_mm)} is {feature.length_mm:.6f} mm long",
            hint=f"leave it out: ends within {gap_mm} mm count as one point",
            values={"feature": feature.name, "length_mm": feature.length_mm},
        )
    if isinstance(feature, Arc):
        _require_arc(feature, gap_mm)
    if (lowest := _lowest_x_mm(feature)) < -gap_mm:
        raise Code.GEO_AXIS.refusal(
            wording(
                "'{feature}' reaches x = {lowest:.4f} mm, beyond the spindle axis", feature=feature.name, lowest=lowest
            ),
            hint=wording("end the profile at x = 0; x is a radius, positive on the side that is turned"),
            values={"feature": feature.name, "x_mm": lowest},
        )


def _require_arc(arc: Arc, gap_mm: float) -> None:
    off_mm = math.dist(arc.point_mm(arc.length_mm), arc.end_mm)
    if off_mm > gap_mm or abs(arc.sweep_rad) > 2 * math.pi:
        raise Code.GEO_ARC.refusal(
            f"'{arc.name}', radius {arc.radius_mm:.4f} mm, sweep {math.degrees(arc.sweep_rad):.4f}°, "
            f"ends {off_mm:.4f} mm from its end point {place_words(arc.end_mm)}",
            hint="start and end must lie on one circle about the centre, the sweep at most one turn apart",
            values={"feature": arc.name, "radius_mm": arc.radius_mm},
        )


def _lowest_x_mm(feature: Feature) -> float:
    if isinstance(feature, Curve):
        return float(np.min(feature.sampled_mm[1][:, 0]))
    lowest = min(feature.start_mm[0], feature.end_mm[0])
    if isinstance(feature, Arc):
        bottom = (feature.centre_mm[0] - feature.radius_mm, feature.centre_mm[1])
        if 0 <= float(feature.locate(bottom)[0]) <= feature.length_mm:
            return bottom[0]
    return lowest


_SIDE_WORDS: Final = {Side.OUTSIDE: "profile", Side.INSIDE: "bore's profile", Side.AROUND: "profile"}


def runs_as(side: Side, start_mm: Point, end_mm: Point, within_mm: float) -> bool:
    """Returns whether a chain with these ends has its material on the right as one of that side.

    Of a bore z falls; a front face alone runs inwards on either. What goes around the part may end anywhere.
    """
    if side is Side.AROUND:
        return True
    if side is Side.INSIDE and abs(end_mm[1] - start_mm[1]) > within_mm:
        return end_mm[1] < start_mm[1]
    return from_chuck(start_mm, end_mm, within_mm)


def from_chuck(start_mm: Point, end_mm: Point, within_mm: float) -> bool:
    """Returns whether a chain with these ends runs as profiles do: z grows or, of a face, x falls."""
    (x0, z0), (x1, z1) = start_mm, end_mm
    return z1 > z0 if abs(z1 - z0) > within_mm else x1 < x0


def _require_chain(features: Sequence[Feature], side: Side, gap_mm: float) -> None:
    for before, after in pairwise(features):
        if (gap := math.dist(before.end_mm, after.start_mm)) > gap_mm:
            raise Code.GEO_GAP.refusal(
                f"'{before.name}' ends at {place_words(before.end_mm)}, '{after.name}' starts {gap:.4f} mm away at "
                f"{place_words(after.start_mm)}",
                hint="let each feature start where the one before it ends",
                values={"gap_mm": gap},
            )
    _require_side(features[0].start_mm, features[-1].end_mm, side, gap_mm)
    for i, j, place in _all_crossings(features, gap_mm):
        who = (
            f"'{features[i].name}' and '{features[j].name}' cross" if i != j else f"'{features[i].name}' crosses itself"
        )
        raise Code.GEO_CROSSING.refusal(
            f"{who} at {place_words(place)}",
            hint="a profile touches itself nowhere but where one feature hands over to the next",
            values={"features": [features[i].name, features[j].name], "x_mm": place[0], "z_mm": place[1]},
        )


def _require_side(start: Point, end: Point, side: Side, gap_mm: float) -> None:
    """Normals and error signs depend on the order: run the other way, what is left on would be what is missing."""
    if runs_as(side, start, end, gap_mm):
        return
    way = "towards the chuck" if end[1] < start[1] - gap_mm else "away from it" if end[1] > start[1] + gap_mm else ""
    raise Code.GEO_ORDER.refusal(
        f"the {_SIDE_WORDS[side]} runs from {place_words(start)} to {place_words(end)}, "
        f"{way or 'outwards along a face'}",
        hint='order an outside from chuck end to free end, a bore (`part.side = "inside"`) from free end to '
        "chuck end, a "
        "front face alone inwards: normals and error signs depend on it",
        values={"start_x_mm": start[0], "start_z_mm": start[1], "end_x_mm": end[0], "end_z_mm": end[1]},
    )


def _all_crossings(features: Sequence[Feature], gap_mm: float) -> Iterator[tuple[int, int, Point]]:
    yield from crossings(features, gap_mm)
    for i, junction in enumerate(junctions_of(features)):
        if abs(junction.turn_rad) > math.pi - RUNS_TOGETHER_RAD:
            yield i, i + 1, features[i].end_mm


def _require_design(profile: Profile, by_design: Mapping[tuple[str, str], JunctionKind]) -> None:
    neighbours = dict(zip(pairwise(profile.names), profile.junctions, strict=True))
    for (before, after), kind in by_design.items():
        found = neighbours.get((before, after))
        if found is None:
            raise Code.GEO_JUNCTION.refusal(
                f"no junction of '{before}' and '{after}' among {len(neighbours)} junctions",
                hint=f"the profile's features, in order: {', '.join(profile.names)}",
                values={"features": [before, after]},
            )
        if kind is JunctionKind.TANGENT and abs(found.turn_rad) > RUNS_TOGETHER_RAD:
            raise Code.GEO_JUNCTION.refusal(
                f"'{before}' and '{after}' are tangent by design, but their directions differ by "
                f"{math.degrees(abs(found.turn_rad)):.3f}°, more than {math.degrees(RUNS_TOGETHER_RAD):.3f}°",
                hint="mend the coordinates, or call the junction a corner",
                values={"features": [before, after]},
            )


def place_words(point: Point | Array) -> str:
    """Describes a place by x and z in mm."""
    return f"x = {point[0]:.4f} mm, z = {point[1]:.4f} mm"
