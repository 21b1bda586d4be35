"""The additions along every move of a finish pass: on the cuts, between them, on the way in and on the way out.

The corrected program is the model: what its words do to the ends of moves, the table does along them. A rapid onto the
contour, which the corrected program leaves alone, is displaced only where that brings it no nearer to the part.

The additions of a correction along one move of the control, by share of the move, 0 to 1.

In (x as a radius, z), mm. Where the move cuts, it is the corrected path of the nose's centre less the commanded one at
the same place of the part; before and after, it fades as the ends of those moves do in the corrected program.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.loops.realtime.lines import SAME_MM, Driven
from trueloop.nc.program.tool_path import Motion
from trueloop.turned.compensation.contour import CentrePiece, ShiftedFeature, centre_pieces
from trueloop.turned.compensation.moves import Move, between
from trueloop.turned.compensation.targets import CutEnds, ends_of, neighbours
from trueloop.turned.program.read_back import move_of


class Added(Protocol):
    """The addition at shares (n,) of a move, (n, 2)."""

    def at(self, share: Array) -> Array:
        """Returns the addition by share of the move's length, or of an arc's angle."""


@dataclass(frozen=True)
class Fading:
    """From one vector evenly to another: a straight move whose ends are displaced."""

    start_mm: Array
    end_mm: Array

    def at(self, share: Array) -> Array:
        """Returns the addition between both ends."""
        return np.asarray(self.start_mm + share[:, None] * (self.end_mm - self.start_mm))


@dataclass(frozen=True)
class AboutCorner:
    """An arc about an edge, and the same between displaced ends."""

    before: Move
    after: Move

    def at(self, share: Array) -> Array:
        """Returns the difference of both at the same share of either angle."""
        return _along(self.after, share) - _along(self.before, share)


@dataclass(frozen=True)
class Cutting:
    """A move that cuts a feature: from the commanded path of the nose's centre to the corrected one, each between its
    own ends, so that corners go to corners. `offset_mm` comes on top.
    """

    before: ShiftedFeature
    after: ShiftedFeature
    ends_before: CutEnds
    ends_after: CutEnds
    offset_mm: Array

    def at(self, share: Array) -> Array:
        """Returns the correction at these shares."""
        was = self.before.centre_mm(_between(self.ends_before, share))
        return np.asarray(self.after.centre_mm(_between(self.ends_after, share)) - was + self.offset_mm)


def _between(ends: CutEnds, share: Array) -> Array:
    return np.asarray(ends.start_mm + share * (ends.end_mm - ends.start_mm))


def _along(move: Move, share: Array) -> Array:
    """Points of an arc at shares of its angle; a positive sweep is clockwise, z to the right and x up."""
    assert move.centre_mm is not None
    centre = np.asarray(move.centre_mm)
    x, z = np.asarray(move.start_mm) - centre
    angle = np.arctan2(x, z) - share * move.sweep_rad
    return np.asarray(centre + np.hypot(x, z) * np.stack([np.sin(angle), np.cos(angle)], axis=1))


START, END = np.zeros(1), np.ones(1)
NOTHING = np.zeros(2)
SHARES = np.linspace(0.0, 1.0, 65)


@dataclass(frozen=True)
class Corrected:
    """The nose-centre path as commanded and as corrected, by feature, and what a tool offset adds to the latter."""

    profile: Profile
    before: Sequence[CentrePiece]
    after: Sequence[CentrePiece]
    offset_mm: Array


def added_along(driven: Driven, corrected: Corrected) -> dict[int, Added]:
    """Returns the additions by move of the control, in its order: the contour, the moves that lead to it, and those
    that leave it.
    """
    found: dict[int, Added] = {}
    cuts = _cutting(driven, corrected)
    start, held = cuts[min(cuts)].at(START)[0], cuts[min(cuts)].at(START)[0]
    for move in range(driven.first, driven.last + 1):
        after = cuts[move + 1].at(START)[0] if move + 1 in cuts else held
        found[move] = cuts.get(move) or _other(driven, move, held, after)
        held = found[move].at(END)[0]
    ways_in = _way_in(driven, corrected.profile, start)
    return {**ways_in, **found, **dict(_ways_out(driven, held))}


def _cutting(driven: Driven, corrected: Corrected) -> dict[int, Cutting]:
    """Returns the cuts by move, each feature from where the nose begins to touch it to where it leaves it."""
    cuts = driven.contour.cuts
    before, after = (_ends(driven, pieces) for pieces in (corrected.before, corrected.after))
    return {
        move: Cutting(
            corrected.before[cuts[k].feature].shifted,
            corrected.after[cuts[k].feature].shifted,
            before[k],
            after[k],
            corrected.offset_mm,
        )
        for move, k in driven.cut.items()
    }


def _ends(driven: Driven, pieces: Sequence[CentrePiece]) -> list[CutEnds]:
    """Returns the begin and end of each cut on the path of the nose's centre.

    Under G41 and G42 that is where the contour's own features end, at a corner that the nose is turned about, and where
    the paths of the nose's centre cross at a corner that it does not get into.
    """
    cuts = driven.contour.cuts
    if not driven.contour.match.on_contour:
        return [ends_of(cuts, k, pieces) for k in range(len(cuts))]
    bare = [replace(piece.shifted, nose_radius_mm=0.0) for piece in pieces]
    contour = centre_pieces(driven.contour.match.profile, [one.undisplaced for one in bare])
    found = []
    for k, cut in enumerate(cuts):
        ends, piece = ends_of(cuts, k, contour), pieces[cut.feature]
        met = [one not in (None, cut.feature) for one in neighbours(cuts, k)]
        start, end = (
            float(np.clip(s, piece.start_mm, piece.end_mm)) if meets else s
            for s, meets in zip((ends.start_mm, ends.end_mm), met, strict=True)
        )
        found.append(CutEnds(start, end))
    return found


def _other(driven: Driven, move: int, start_mm: Array, end_mm: Array) -> Added:
    """Returns the addition of a move of the contour that cuts no feature: an arc about an edge keeps its radius."""
    if driven.centre.motion[move] != Motion.ARC:
        return Fading(start_mm, end_mm)
    arc = move_of(driven.centre, move)
    (x0, z0), (x1, z1) = arc.start_mm + start_mm, arc.end_mm + end_mm
    return AboutCorner(arc, between(arc, (float(x0), float(z0)), (float(x1), float(z1))))


def _way_in(driven: Driven, profile: Profile, start_mm: Array) -> dict[int, Added]:
    """Returns the addition of the move to the contour, zero where it begins; and of its block's other moves."""
    lead = driven.lead
    if lead is None:
        return {}
    added = Fading(NOTHING, start_mm)
    if driven.is_rapid(lead) and _comes_closer(driven, profile, lead, added):
        return {}
    same_block = [move for move in range(lead) if driven.centre.block[move] == driven.centre.block[lead]]
    return {**dict.fromkeys(same_block, Fading(NOTHING, NOTHING)), lead: added}


def _comes_closer(driven: Driven, profile: Profile, move: int, added: Added) -> bool:
    """Returns whether the additions along a move bring it nearer to the part anywhere."""
    at = driven.centre_mm(move, SHARES)
    was, now = (_clearance_mm(profile, points) for points in (at, at + added.at(SHARES)))
    return bool(np.any(now < was - SAME_MM))


def _clearance_mm(profile: Profile, points: Array) -> Array:
    return np.abs(profile.locate(np.column_stack([np.abs(points[:, 0]), points[:, 1]])).distance_mm)


def _ways_out(driven: Driven, held_mm: Array) -> Iterator[tuple[int, Added]]:
    """Yields the additions of moves after the contour: on an axis they fade along the first move that names it, and
    are held before.

    So does the corrected program, whose words say where a move ends and whose blocks inherit what they do not say.
    """
    path = driven.centre
    for move in range(driven.last + 1, len(path)):
        in_block = path.block[move] == path.block[move - 1]
        if not driven.in_frame(move) or not (np.any(held_mm) or in_block):
            return
        end = np.where(path.word[move][[0, 2]] >= 0, 0.0, held_mm)
        yield move, Fading(held_mm, end)
        held_mm = end
