"""A profile in words and numbers, for `trueloop part show`."""

import math
from collections.abc import Sequence

from trueloop.cli.terminal import wide_console
from trueloop.geometry.offset import CentrePath
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.report.turned.profile import kind_in_words


def print_profile(name: str, profile: Profile, centre: CentrePath, setups: Sequence[SetupFrame] = ()) -> None:
    """The features as a table, each with the junction that follows it; then the frames of several set-ups."""
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
        table.add_row(feature.name, kind_in_words(feature), *(f"{value:.4f}" for value in numbers), junction)
    console.print(f"{name}: {len(profile.features)} features, {profile.length_mm:.4f} mm of arc\n", markup=False)
    console.print(table)
    console.print(
        f"\nmm, x is a radius. Reached: by a nose of {centre.nose_radius_mm:.4f} mm, as arc length on the feature. "
        "Turns are positive at convex corners.",
        markup=False,
    )
    for one in setups:
        turned = ", turned round" if one.flipped else ", Z mirrored by the control" if one.mirrored_z else ""
        console.print(f"Set-up {one.name}{turned}: {one.words} of the part.", markup=False)
