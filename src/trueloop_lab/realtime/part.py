"""The part of the demo, and its program for LinuxCNC: two cuts from opposite sides, the lathe warmer at the second.

The dome and the cylinder behind it are cut from the free end towards the chuck, collar and cone from the chuck
outwards: where the cuts meet, the part shows what the drives lose when they turn round, and what the machine has grown
in between.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile

NOSE_RADIUS_MM: Final = 0.8
WORK_ZERO_Z_MM: Final = -90.0
"""Z of the part's free end in the machine's coordinates: G54."""

TOOL_OFFSET_MM: Final = (12.0, 30.0)
"""The offset of the nose's centre, X a radius: the axes stand that much farther than the nose."""

SET_AT_MM: Final = (25.0, -30.0)
"""The point where the tool was set, part coordinates: the machine cold, coming towards the axis and the chuck."""

FEED_MM_PER_MIN, RAPID_BETWEEN_MM = 300.0, 8.0
CHUCK_SIDE: Final = 3
"""Features cut from the chuck outwards; the others towards it."""


@dataclass(frozen=True)
class DemoProgram:
    """The text, and on which lines each of the cuts is, first to last, counted from 1."""

    text: str
    cuts: tuple[tuple[int, int], ...]


def demo_profile() -> Profile:
    """Returns collar, step, cone, cylinder and dome; mm, radii, the free end at z = 0."""
    return checked_profile(
        [
            Line("collar", (36.0, -66.0), (36.0, -56.0)),
            Line("step", (36.0, -56.0), (30.0, -56.0)),
            Line("cone", (30.0, -56.0), (24.0, -40.0)),
            Line("cylinder", (24.0, -40.0), (24.0, -24.0)),
            Arc("dome", (24.0, -24.0), (0.0, 0.0), (0.0, -24.0), math.pi / 2),
        ]
    )


def demo_program(profile: Profile, dwell_s: float = 10.0) -> DemoProgram:
    """Returns the program of both cuts at one feed; between them the tool rounds the part and waits while it grows."""
    centre = nose_centre_path(profile, NOSE_RADIUS_MM).features
    inwards = [feature.reversed() for feature in reversed(centre[CHUCK_SIDE:])]
    outwards = list(centre[:CHUCK_SIDE])
    far_mm = outwards[0].start_mm[0] + RAPID_BETWEEN_MM
    lines = [
        "G18 G21 G8 G90 G94 G40 G64 P0.0001 Q0",
        f"G10 L2 P1 X0 Z{WORK_ZERO_Z_MM:.3f}",
        "G54",
        f"G43.1 X{TOOL_OFFSET_MM[0]:.3f} Z{TOOL_OFFSET_MM[1]:.3f}",
        "G97 S2400 M3",
        *_approach(inwards[0], far_mm, 0.0, 1.5),
    ]
    first = len(lines) + 1
    lines += [f"F{FEED_MM_PER_MIN:.0f}", *_moves(inwards)]
    cuts = [(first, len(lines))]
    lines += [f"G0 X{far_mm:.3f}", f"G4 P{dwell_s:g}", *_approach(outwards[0], far_mm, 1.5, -2.0)]
    first = len(lines) + 1
    lines += [f"F{FEED_MM_PER_MIN:.0f}", *_moves(outwards)]
    cuts.append((first, len(lines)))
    lines += [f"G0 X{far_mm:.3f}", "G49", "M5", "M2", ""]
    return DemoProgram("\n".join(lines), tuple(cuts))


def _approach(first: Feature, far_mm: float, off_x_mm: float, off_z_mm: float) -> list[str]:
    """Returns the blocks to beside the first feature, and on to its start in the direction in which it is cut."""
    x, z = first.start_mm
    return [
        f"G0 X{far_mm:.3f}",
        f"G0 Z{z + off_z_mm:.6f}",
        f"G0 X{x + off_x_mm:.6f}",
        f"G1 X{x:.6f} Z{z:.6f} F{FEED_MM_PER_MIN:.0f}",
    ]


def _moves(features: Sequence[Feature]) -> list[str]:
    """Returns feed moves along lines and arcs, X a radius, centres from the starts."""
    found = []
    for feature in features:
        end = f"X{feature.end_mm[0]:.6f} Z{feature.end_mm[1]:.6f}"
        if isinstance(feature, Line):
            found.append(f"G1 {end}")
            continue
        assert isinstance(feature, Arc)
        (x, z), (centre_x, centre_z) = feature.start_mm, feature.centre_mm
        found.append(f"{'G2' if feature.sweep_rad > 0 else 'G3'} {end} I{centre_x - x:.6f} K{centre_z - z:.6f}")
    return found
