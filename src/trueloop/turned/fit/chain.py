"""Chains: features joined tangentially that one spline runs over, and which chain prescribes what to which.

Lines and arcs are distinguished because their errors behave differently: along a line the contact angle of the nose
stands still, along an arc it turns. A chain of arcs takes its end values from the lines it is tangent to.
"""

from dataclasses import dataclass
from enum import StrEnum
from itertools import accumulate

from trueloop.geometry.feature import is_curved
from trueloop.geometry.profile import JunctionKind, Profile


class TangentPolicy(StrEnum):
    """The demand of a tangent junction of line and arc, or of two arcs, on the error curves.

    PATH: equal value and slope, so that the compensated path is tangent, as published [6517 §4]. PART: equal value
    only. The nose errs as a function of contact angle, so the error has a kink where curvature jumps, and only a path
    with the opposite kink leaves a tangent part.
    """

    PART = "part"
    PATH = "path"


@dataclass(frozen=True)
class Chain:
    """Consecutive features with tangent junctions between them, all lines or all arcs."""

    features: tuple[int, ...]
    starts_mm: tuple[float, ...]
    length_mm: float
    curved: bool

    @property
    def joints_mm(self) -> tuple[float, ...]:
        """Returns the arc lengths along the chain of the tangent junctions inside it."""
        return self.starts_mm[1:]


@dataclass(frozen=True)
class End:
    """One end of a chain."""

    chain: int
    at_end: bool


def chains_of(profile: Profile) -> tuple[Chain, ...]:
    """Groups the profile's features into chains."""
    groups: list[list[int]] = []
    for i in range(len(profile.features)):
        joined = i > 0 and profile.junctions[i - 1].kind == JunctionKind.TANGENT
        if joined and _curved(profile, i - 1) == _curved(profile, i):
            groups[-1].append(i)
        else:
            groups.append([i])
    return tuple(_chain(profile, group) for group in groups)


def tangent_neighbours(profile: Profile, chains: tuple[Chain, ...], index: int) -> tuple[End | None, End | None]:
    """Returns the ends of the chains before and after that `chains[index]` is tangent to: None at corners and ends."""
    first, last = chains[index].features[0], chains[index].features[-1]
    tangent_before = first > 0 and profile.junctions[first - 1].kind == JunctionKind.TANGENT
    tangent_after = last < len(profile.junctions) and profile.junctions[last].kind == JunctionKind.TANGENT
    return (End(index - 1, True) if tangent_before else None, End(index + 1, False) if tangent_after else None)


def _chain(profile: Profile, group: list[int]) -> Chain:
    lengths = [profile.features[i].length_mm for i in group]
    *starts, total = accumulate(lengths, initial=0.0)
    return Chain(tuple(group), tuple(starts), total, _curved(profile, group[0]))


def _curved(profile: Profile, index: int) -> bool:
    return is_curved(profile.features[index])
