"""A nominal profile as JSON, and its features in words."""

import math

from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.offset import CentrePath
from trueloop.geometry.profile import Profile


def profile_as_dict(name: str, profile: Profile, centre: CentrePath) -> dict[str, object]:
    """A profile and what of it a nose reaches; x is a radius, turns are positive at convex corners."""
    return {
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
    """Line, or arc with its radius and sense."""
    if not isinstance(feature, Arc):
        return "line"
    sense = "convex" if feature.sweep_rad > 0 else "concave"
    return f"{sense} arc R {feature.radius_mm:.4f}, {math.degrees(abs(feature.sweep_rad)):.2f}°"
