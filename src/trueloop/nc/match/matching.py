"""The search for the moves of a program that cut each feature."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.offset import CentrePath, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.nc.match.contour_match import ContourMatch, FeatureMatch, Passes
from trueloop.nc.program.along import FeedMove, moves_of_one_kind

TOLERANCE_MM: Final = 0.125
"""The most that a commanded contour may be from the nominal one: half the usual 0.25 mm between passes, so that a mock
error or a slip of 0.1 mm is still that contour and the pass before the last is another."""


def match_contour(
    moves: Sequence[FeedMove],
    profile: Profile,
    nose_radius_mm: float,
    *,
    allowance_mm: float = 0.0,
    tolerance_mm: float = TOLERANCE_MM,
    lines: tuple[int, int] | None = None,
) -> ContourMatch:
    """Finds the one pass over each feature among the feed moves of a program.

    The moves of the nose's centre must lie within `tolerance_mm` of the profile's offset by nose radius +
    `allowance_mm`; moves under G41 or G42 must lie so near to the profile's offset by `allowance_mm` alone, and are the
    pass where the program has any. A feature that both kinds cut is ambiguous. In the profile's order or reversed;
    `lines` narrows the search to the program's lines from–to. Raises NC-NO-MATCH where no pass cuts a feature whole,
    naming the nearest line, NC-AMBIGUOUS where several do, NC-COMPENSATED where G41 or G42 keeps the nose on the
    material's side.
    """
    search, found = _searched(_in_lines(moves, lines), profile, nose_radius_mm, allowance_mm, tolerance_mm)
    matches = []
    for match in found:
        if isinstance(match, TrueloopError):
            raise match
        matches.append(match)
    return _with_the_rest(search, tuple(matches))


def match_each(
    moves: Sequence[FeedMove],
    profile: Profile,
    nose_radius_mm: float,
    *,
    allowance_mm: float = 0.0,
    tolerance_mm: float = TOLERANCE_MM,
    lines: tuple[int, int] | None = None,
) -> tuple[FeatureMatch | TrueloopError, ...]:
    """Returns for each feature the pass that cuts it, or the refusal that `match_contour` would raise for it."""
    return _searched(_in_lines(moves, lines), profile, nose_radius_mm, allowance_mm, tolerance_mm)[1]


def _searched(
    moves: Sequence[FeedMove], profile: Profile, nose_radius_mm: float, allowance_mm: float, tolerance_mm: float
) -> tuple[Passes, tuple[FeatureMatch | TrueloopError, ...]]:
    """The search among moves of one kind, and what it found for each feature."""
    kept, offset_mm = moves_of_one_kind(moves, nose_radius_mm)
    search = _search(profile, kept, offset_mm + allowance_mm, tolerance_mm)
    other = _beside_contour(profile, moves, nose_radius_mm + allowance_mm, tolerance_mm)
    return search, tuple(_tried(search, other, index) for index in range(len(profile.features)))


def _in_lines(moves: Sequence[FeedMove], lines: tuple[int, int] | None) -> list[FeedMove]:
    return [m for m in moves if lines is None or lines[0] <= m.line <= lines[1]]


def _search(profile: Profile, moves: Sequence[FeedMove], offset_mm: float, tolerance_mm: float) -> Passes:
    return Passes(profile, nose_centre_path(profile, offset_mm), moves, tolerance_mm)


def _beside_contour(
    profile: Profile, moves: Sequence[FeedMove], offset_mm: float, tolerance_mm: float
) -> Passes | None:
    """The search among moves of the nose's centre of a program that has moves of the contour too."""
    of_centre = [move for move in moves if not move.on_contour]
    if len(of_centre) in (0, len(moves)):
        return None
    try:
        return _search(profile, of_centre, offset_mm, tolerance_mm)
    except TrueloopError:  # the nose does not fit: then none of them is its path
        return None


def _tried(search: Passes, other: Passes | None, index: int) -> FeatureMatch | TrueloopError:
    """The match, or why there is none; `other` are the moves of the nose's centre beside those of the contour."""
    try:
        match = search.match(index)
        _require_off_material(match)
        if other is not None and (also := other.whole_passes(index)):
            raise search.ambiguous(index, [match.moves, *(p.moves for p in also)])
    except TrueloopError as refusal:
        return refusal
    return match


def _require_off_material(match: FeatureMatch) -> None:
    """Along the profile the material is at the right: G41 keeps the nose off it, on an outside and in a bore."""
    off = 42 if match.backwards else 41
    for matched in match.moves:
        if matched.move.on_contour and matched.move.compensation != off:
            line, mode = matched.move.line, matched.move.compensation
            raise Code.NC_COMPENSATED.refusal(
                f"line {line} cuts '{match.feature.name}' with G{mode}, which keeps the nose on the material's side",
                hint=f"in this direction the free side wants G{off}; check `part.side` and the order of features",
                place=Place(line=line),
                values={"compensation": f"G{mode}"},
            )


def _with_the_rest(search: Passes, matches: tuple[FeatureMatch, ...]) -> ContourMatch:
    cutting = {matched.move.index for match in matches for matched in match.moves}
    lead, run_out, between = [], [], []
    for chain in sorted({matched.move.chain for match in matches for matched in match.moves}):
        members = [m for m in search.moves if m.chain == chain]
        cuts = [k for k, m in enumerate(members) if m.index in cutting]
        for k, move in enumerate(members):
            if move.index in cutting:
                continue
            if cuts[0] < k < cuts[-1]:
                between.append(move)
            elif _lengthens(search.path, move.path, search.tolerance_mm):
                run_out.append(move)
            else:
                lead.append(move)
    return ContourMatch(search.profile, matches, tuple(lead), tuple(run_out), tuple(between))


def _lengthens(path: CentrePath, move: Feature, tolerance_mm: float) -> bool:
    """Returns whether a straight move only goes on from the path's free end along its tangent, or arrives so at its
    start.
    """
    if isinstance(move, Arc):
        return False
    first, last = path.features[0], path.features[-1]
    free_ends = [(last.end_mm, last.tangent(last.length_mm)), (first.start_mm, -first.tangent(0.0))]
    for place, outwards in free_ends:
        for start, end in ((move.start_mm, move.end_mm), (move.end_mm, move.start_mm)):
            along = (np.asarray(end) - np.asarray(start)) / move.length_mm
            if math.dist(start, place) <= 2 * tolerance_mm and float(along @ outwards) > math.cos(0.02):
                return True
    return False
