"""What cutting leaves on a part, at its gauging points: displaced tools, worn noses, forces, chatter, clamping.

A tool displaced by (dx, dz) leaves n · d; everything is positive where material is left on.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from studies.diagnosed.part_types import Gauged, PartType
from studies.diagnosed.truth import Fault, Truth
from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_error import FeaturePlace

SETTINGS: Final = (1.0, -0.6, 0.8, -0.4)
"""An offset after each setting of its tool, in its size."""
USUAL_DEPTH_MM: Final = 0.25
SOUND_PER_MM: Final = 0.0004
"""What a sound tool yields by, a mm of depth; offsets are set with the usual depth."""
JAWS_REACH_MM: Final = 60.0
BREAK_IN_MIN: Final = 6.0
DEEPER: Final = 3.0
"""Depth of the end face beside the others where depths are unequal."""


@dataclass(frozen=True)
class Cut:
    """How one part was cut: settings so far and minutes in cut by tool, depth by feature, where in the series it is.

    `minutes` are those when the part is finished, `part_minutes` of them on this part.
    """

    order: int
    parts: int
    setting: Mapping[str, int]
    minutes: Mapping[str, float]
    depth_mm: Mapping[str, float]
    part_minutes: float = 0.0


@dataclass(frozen=True)
class Left:
    """What is left on at each gauging point, mm: while the part is clamped, and once it is free."""

    clamped_mm: Array
    free_mm: Array


def process_errors(
    truth: Truth,
    part: PartType,
    places: Mapping[str, FeaturePlace],
    points: Gauged,
    cut: Cut,
    noise_mm: float,
    rng: np.random.Generator,
) -> Left:
    """Of one part. `noise_mm` is by how much cuts of a sound process differ, half as a tool, half a feature."""
    found = np.zeros(points.count)
    for tool in sorted({place.tool for place in places.values()}):
        mine = points.is_of([name for name, place in places.items() if place.tool == tool])
        shift = _displaced(truth, tool, cut, rng) + rng.normal(0.0, noise_mm / 2, 2)
        found = found + mine * (points.normal @ shift)
    for number, place in enumerate(places.values(), start=1):
        minutes = cut.minutes[place.tool] - cut.part_minutes * (1 - number / len(places))
        own = rng.normal(0.0, noise_mm / 2) + _worn(truth, place.tool, minutes)
        found = found + points.is_of([place.name]) * (own + _forced(truth, part, place, points, cut))
    chatter = truth.size_mm(Fault.CHATTER) * rng.uniform(0.7, 1.3)
    wave, phase = rng.uniform(2.3, 4.1), rng.uniform(0, 2 * np.pi, 2)
    turned, along = points.angle_rad, points.at_mm[:, 1]
    shafts = points.is_of([place.name for place in places.values() if place.kind == "shaft"])
    found = found + shafts * chatter * np.sqrt(2) * np.sin(2 * np.pi * along / wave + 16.4 * turned + phase[0])
    found = found + points.normal[:, 0] * truth.size_mm(Fault.RUN_OUT) * np.cos(turned - phase[1])
    lobes = shafts * truth.size_mm(Fault.JAWS) * np.cos(3 * turned) * np.exp(-along / JAWS_REACH_MM)
    return Left(found, found + lobes)


def _displaced(truth: Truth, tool: str, cut: Cut, rng: np.random.Generator) -> Array:
    """By how much the tool point is too far out in x and z."""
    share = SETTINGS[min(cut.setting[tool], len(SETTINGS)) - 1]
    slipped = cut.setting[tool] == 1 and 3 * cut.order >= cut.parts
    x = share * truth.size_mm(Fault.TOOL_OFFSET, tool) + slipped * truth.size_mm(Fault.TOOL_SLIP, tool)
    z = share * truth.size_mm(Fault.TWO_TOOLS, tool)
    seat = truth.size_mm(Fault.TOOL_SEAT, tool) * rng.standard_normal(2)
    return np.array([x, z]) + seat


def _worn(truth: Truth, tool: str, minutes: float) -> float:
    """Wear along the normal: a share while the edge breaks in, then evenly; its size after an hour."""
    broken_in = 1.0 - float(np.exp(-minutes / BREAK_IN_MIN))
    return truth.size_mm(Fault.WEAR, tool) * (0.15 * broken_in + 0.85 * minutes / 60.0)


def _forced(truth: Truth, part: PartType, place: FeaturePlace, points: Gauged, cut: Cut) -> Array:
    """By forces: tools and the part yield in proportion to the depth of cut."""
    radius, along = points.at_mm.T
    depth = cut.depth_mm[place.name] / USUAL_DEPTH_MM
    yields = SOUND_PER_MM * USUAL_DEPTH_MM
    if place.kind == "face":
        yields = yields + truth.size_mm(Fault.UNEQUAL_DEPTH) / (DEEPER - 1.0)
    cantilever = truth.size_mm(Fault.PART_DEFLECTION) * (along / part.length_mm) ** 3 * points.normal[:, 0]
    towards_axis = 1.0 - radius / part.largest_mm
    face = float(place.kind == "face")
    bent = face * truth.size_mm(Fault.FACE_DEFLECTION) * towards_axis
    slow = face * truth.size_mm(Fault.CONSTANT_SPEED) * towards_axis**1.5
    found: Array = yields * (depth - 1.0) + depth * (cantilever + bent) + slow
    return found
