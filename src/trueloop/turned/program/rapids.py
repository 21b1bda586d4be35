"""Rapids that leave the corrected contour: they end where those of the source do, or further off the part.

A block that names one axis alone inherits the other from the cut before it, and with that its correction. Where this
takes the rapid away from the part, the block stays: written out, the tool would be drawn along the wall that it has
just cut. Where it would take it nearer, the axis is written into the block, as it was: the tool leaves that wall. Not
where it goes on along a surface past its end: what stands there nobody knows.
"""

import math
from collections.abc import Collection
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Profile
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.program.read_back import SAME_MM, clearance_mm
from trueloop.turned.program.write import Displacements

AWAY_MM: Final = 0.5
"""A rapid that ends this far off what was cut last has left it: some times the largest correction."""

SAMPLES: Final = 33


def with_rapids(path: ToolPath, profile: Profile, targets: Displacements, meant: Collection[int]) -> Displacements:
    """Returns the program with all moves from a rapid up to the one that leads to the next cut as they are to be.

    `meant` are the moves whose ends are displaced for themselves: cuts, what leads to them and what lengthens them.
    """
    ends, behind = dict(targets.ends), dict[int, Array]()
    held, left = np.zeros(2), False
    for move in range(targets.first, len(path)):
        if move in meant:
            held, left = ends[move], False
            continue
        left = left or path.motion[move] == Motion.RAPID
        inherits = path.word[move][[0, 2]] < 0
        carried = np.where(inherits, held, 0.0)
        held = carried if left or move > targets.last else ends.get(move, held)
        of_block = path.motion[move] == Motion.RAPID and not np.all(inherits)  # else it is a cycle's
        as_it_was = of_block and _leaves_nearer(path, profile, move, held)
        held = np.zeros(2) if as_it_was else held
        if move <= targets.last:
            ends[move] = held
            continue
        behind[move] = held
        if as_it_was:
            ends |= behind
        if not np.any(held):
            break
    return Displacements(ends, targets.arcs)


def _leaves_nearer(path: ToolPath, profile: Profile, move: int, delta_mm: Array) -> bool:
    """Returns whether a rapid leaves the part where it begins, and would end nearer to it by that displacement."""
    end = path.end_mm[move]
    was, becomes = (clearance_mm(profile, at) for at in (end, end + np.array([delta_mm[0], 0.0, delta_mm[1]])))
    return becomes < was - SAME_MM and _leaves(_nearest(profile, path.start_mm[move]), path.start_mm[move], end)


def _leaves(feature: Feature, start_mm: Array, end_mm: Array) -> bool:
    """Returns whether a rapid goes off a feature along x, to either side, or beyond it towards the free end."""
    x, z = feature.point_mm(np.linspace(0.0, feature.length_mm, SAMPLES)).T
    reached, came = abs(float(end_mm[0])), abs(float(start_mm[0]))
    outwards, inwards = min(reached - np.max(x), reached - came), min(np.min(x) - reached, came - reached)
    forwards = min(end_mm[2] - np.max(z), end_mm[2] - start_mm[2])
    return bool(max(outwards, inwards, forwards) >= AWAY_MM)


def _nearest(profile: Profile, at_mm: Array) -> Feature:
    """Returns the feature that a point is nearest to, within the feature's ends."""
    point = (abs(float(at_mm[0])), float(at_mm[2]))

    def distance_mm(feature: Feature) -> float:
        along, off = feature.locate(point)
        ends = min(math.dist(point, feature.start_mm), math.dist(point, feature.end_mm))
        return abs(float(off)) if 0.0 <= float(along) <= feature.length_mm else ends

    return min(profile.features, key=distance_mm)
