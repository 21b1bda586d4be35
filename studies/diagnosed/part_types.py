"""Types of turned parts: two or three diameters, faces at two heights or more, a cone; and where they are gauged.

Part frame: z from the jaws' face towards the free end, x a radius. Everything is an outside surface that looks outwards
or to +z, as the formulas of the errors have it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.diagnosis.features.feature_error import FeaturePlace

CLEAR_MM: Final = 1.0
ALONG, AROUND, ACROSS = 8, 9, 6
"""Touches along a shaft, in the ring at its end near the chuck, and across a face or along a cone."""


@dataclass(frozen=True)
class PartType:
    """Diameters from the chuck to the free end, with where each ends; the last one ends in a cone and the end face."""

    name: str
    radius_mm: tuple[float, ...]
    ends_mm: tuple[float, ...]
    cone_mm: float = 6.0
    bore_mm: float = 2.0

    @property
    def length_mm(self) -> float:
        """From the jaws to the end face."""
        return self.ends_mm[-1] + self.cone_mm

    @property
    def largest_mm(self) -> float:
        """Its largest radius."""
        return max(self.radius_mm)


@dataclass(frozen=True)
class Gauged:
    """n points of a type: names of features, x and z, outward normals (n, 2), angles about the axis."""

    feature: tuple[str, ...]
    at_mm: Array
    normal: Array
    angle_rad: Array

    @property
    def count(self) -> int:
        """How many points."""
        return len(self.feature)

    def is_of(self, names: Sequence[str]) -> Integers:
        """Which points are of these features, as 0 and 1."""
        return np.array([name in names for name in self.feature], dtype=np.int64)


SLIM: Final = PartType("slim shaft", (20.0, 16.0, 12.0), (50.0, 95.0, 140.0))
DISC: Final = PartType("disc", (75.0, 45.0, 22.0), (20.0, 40.0, 62.0), 4.0, 4.0)
STUB: Final = PartType("stub", (32.0, 24.0), (30.0, 64.0), 8.0)
TYPES: Final = (SLIM, DISC, STUB)


def places(part: PartType, tools: Sequence[str]) -> Mapping[str, FeaturePlace]:
    """Its features by name: shafts by the first tool, shoulders and cone by the second, the end face by the last."""
    radii, starts = part.radius_mm, (0.0, *part.ends_mm[:-1])
    shaft, shoulder, end = tools[0], tools[min(1, len(tools) - 1)] if len(tools) > 2 else tools[0], tools[-1]
    found = []
    for k, (radius, low, high) in enumerate(zip(radii, starts, part.ends_mm, strict=True)):
        found.append(FeaturePlace(f"shaft {k + 1}", "shaft", (radius, radius), (low, high), shaft))
        if k + 1 < len(radii):
            found.append(FeaturePlace(f"shoulder {k + 1}", "face", (radii[k + 1], radius), (high, high), shoulder))
    rim = radii[-1] - 0.5 * part.cone_mm
    found.append(FeaturePlace("cone", "cone", (rim, radii[-1]), (part.ends_mm[-1], part.length_mm), shoulder))
    found.append(FeaturePlace("end face", "face", (part.bore_mm, rim), (part.length_mm, part.length_mm), end))
    return {place.name: place for place in found}


def gauged(features: Mapping[str, FeaturePlace]) -> Gauged:
    """Where they are touched: shafts along a line and in a ring near the chuck, faces and cone along a line."""
    names: list[str] = []
    rows: list[tuple[float, ...]] = []
    for place in features.values():
        found = _shaft(place) if place.kind == "shaft" else _slope(place)
        names += [place.name] * len(found)
        rows += found
    table = np.array(rows)
    return Gauged(tuple(names), table[:, :2], table[:, 2:4], table[:, 4])


def _shaft(place: FeaturePlace) -> list[tuple[float, ...]]:
    low, high = place.z_mm[0] + CLEAR_MM, place.z_mm[1] - CLEAR_MM
    radius = place.radius_mm[0]
    ring = [(radius, low, 1.0, 0.0, 2 * np.pi * k / AROUND) for k in range(AROUND)]
    return [*ring, *[(radius, float(z), 1.0, 0.0, 0.0) for z in np.linspace(low, high, ALONG)[1:]]]


def _slope(place: FeaturePlace) -> list[tuple[float, ...]]:
    """From the rim inwards: a face or a cone that falls off towards the free end."""
    (inner, outer), (low, high) = place.radius_mm, place.z_mm
    run = np.hypot(outer - inner, high - low)
    normal = ((high - low) / run, (outer - inner) / run)
    share = np.linspace(0.0, 1.0, ACROSS + 2)[1:-1]
    return [(outer + s * (inner - outer), low + s * (high - low), *normal, 0.0) for s in share.tolist()]
