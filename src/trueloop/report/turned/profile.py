"""A nominal profile as JSON, and its features in words."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.offset import CentrePath
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame

STRAIGHT_MM: Final = 1e6
"""A least radius of curvature from a kilometre on is none."""


def profile_as_dict(
    name: str, profile: Profile, centre: CentrePath, setups: Sequence[SetupFrame] = ()
) -> dict[str, object]:
    """Converts a profile and what of it a nose reaches; x is a radius, turns are positive at convex corners. The
    frames of its set-ups where it has several.
    """
    frames = [asdict(one) | {"z_of_program": one.words} for one in setups]
    return ({"setups": frames} if frames else {}) | {
        "part": name,
        "length_mm": profile.length_mm,
        "nose_radius_mm": centre.nose_radius_mm,
        "features": [
            {
                "name": feature.name,
                "kind": kind_in_words(feature),
                "start_mm": feature.start_mm,
                "end_mm": feature.end_mm,
                "length_mm": feature.length_mm,
                "reachable_mm": reachable.tolist(),
            }
            for feature, reachable in zip(profile.features, centre.reachable_mm, strict=True)
        ],
        "junctions": [
            {"kind": junction.kind, "turn_deg": math.degrees(junction.turn_rad), "by_design": junction.by_design}
            for junction in profile.junctions
        ],
    }


def kind_in_words(feature: Feature) -> str:
    """Describes a line, an arc with its radius and sense, or a curve with its least radii of curvature."""
    if isinstance(feature, Curve):
        concave, convex = feature.radius_range_mm()
        radii = [f"{sense} R ≥ {r:.4f}" for sense, r in (("convex", convex), ("concave", concave)) if r < STRAIGHT_MM]
        return f"curve {', '.join(radii)}" if radii else "curve"
    if not isinstance(feature, Arc):
        return "line"
    sense = "convex" if feature.sweep_rad > 0 else "concave"
    return f"{sense} arc R {feature.radius_mm:.4f}, {math.degrees(abs(feature.sweep_rad)):.2f}°"
