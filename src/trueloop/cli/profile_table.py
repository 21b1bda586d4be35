"""A profile in words and numbers, for `trueloop part show`."""

import math

from trueloop.cli.terminal import wide_console
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.offset import CentrePath
from trueloop.geometry.profile import Profile


def as_dict(name: str, profile: Profile, centre: CentrePath) -> dict[str, object]:
    """The profile as `--json` prints it; x is a radius, turns are positive at convex corners."""
    return {
        "part": name,
        "length_mm": profile.length_mm,
        "nose_radius_mm": centre.nose_radius_mm,
        "features": [
            {
                "name": feature.name,
                "kind": kind_of(feature),
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


def kind_of(feature: Feature) -> str:
    """Line, or arc with its radius and sense."""
    if not isinstance(feature, Arc):
        return "line"
    sense = "convex" if feature.sweep_rad > 0 else "concave"
    return f"{sense} arc R {feature.radius_mm:.4f}, {math.degrees(abs(feature.sweep_rad)):.2f}°"


def print_profile(name: str, profile: Profile, centre: CentrePath) -> None:
    """The features as a table, each with the junction that follows it."""
    from rich.table import Table

    console = wide_console()
    table = Table(box=None, pad_edge=False)
    for heading in ("feature", "kind"):
        table.add_column(heading, no_wrap=True)
    for heading in ("start x", "start z", "end x", "end z", "length", "reached from", "to"):
        table.add_column(heading, justify="right")
    table.add_column("next junction")
    followed_by = [*(f"{j.kind}, {math.degrees(j.turn_rad):+.3f}°" for j in profile.junctions), ""]
    for feature, reachable, junction in zip(profile.features, centre.reachable_mm, followed_by, strict=True):
        numbers = (*feature.start_mm, *feature.end_mm, feature.length_mm, *reachable)
        table.add_row(feature.name, kind_of(feature), *(f"{value:.4f}" for value in numbers), junction)
    console.print(f"{name}: {len(profile.features)} features, {profile.length_mm:.4f} mm of arc\n", markup=False)
    console.print(table)
    console.print(
        f"\nmm, x is a radius. Reached: by a nose of {centre.nose_radius_mm:.4f} mm, as arc length on the feature. "
        "Turns are positive at convex corners.",
        markup=False,
    )
