"""Names of features that nobody has named: by what they are, so that a drawing and a program give the same ones."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, contact_angle_rad

SQUARE: Final = math.cos(math.radians(0.5))
"""A line within half a degree of the axis is a cylinder, one within half a degree of square to it a face."""


def kind_of(feature: Feature) -> str:
    """Returns the kind of a feature: cylinder, face, cone, arc or curve."""
    if isinstance(feature, Curve):
        return "curve"
    if isinstance(feature, Arc):
        return "arc"
    angle = float(contact_angle_rad(feature.outward_normal(0.0)))
    if abs(math.sin(angle)) > SQUARE:
        return "cylinder"
    return "face" if abs(math.cos(angle)) > SQUARE else "cone"


def named_by_kind(features: Iterable[Feature]) -> tuple[Feature, ...]:
    """Names the features cylinder-1, face-1, cone-1, arc-1, cylinder-2…, in their order from the chuck."""
    seen, named = Counter[str](), list[Feature]()
    for feature in features:
        kind = kind_of(feature)
        seen[kind] += 1
        named.append(replace(feature, name=f"{kind}-{seen[kind]}"))
    return tuple(named)
