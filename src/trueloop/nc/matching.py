"""Finds which moves of a program cut which feature."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Arc, Array, Feature, distance_mm
from trueloop.geometry.offset import CentrePath, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.nc.contour_match import ContourMatch, FeatureMatch, MatchedMove
from trueloop.nc.feed_moves import FeedMove, moves_of_one_kind

TOLERANCE_MM: Final = 0.125
"""How far a commanded contour may stand off the nominal one: half the usual step of 0.25 mm between passes, so that a
mock error or a slip of 0.1 mm is still the same contour and the pass before the last is another."""

_SAMPLES: Final = 17
_SAME_DIRECTION: Final = 0.8
"""A move goes along a feature when it advances on it by at least this share of its length."""


def match_contour(
    moves: Sequence[FeedMove],
    profile: Profile,
    nose_radius_mm: float,
    *,
    allowance_mm: float = 0.0,
    tolerance_mm: float = TOLERANCE_MM,
    lines: tuple[int, int] | None = None,
) -> ContourMatch:
    """Find the one pass over each feature among the feed moves of a program.

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
    """For each feature the pass that cuts it, or the refusal that `match_contour` would raise for it."""
    return _searched(_in_lines(moves, lines), profile, nose_radius_mm, allowance_mm, tolerance_mm)[1]


def _searched(
    moves: Sequence[FeedMove], profile: Profile, nose_radius_mm: float, allowance_mm: float, tolerance_mm: float
) -> "tuple[_Search, tuple[FeatureMatch | TrueloopError, ...]]":
    """The search among moves of one kind, and what it found for each feature."""
    kept, offset_mm = moves_of_one_kind(moves, nose_radius_mm)
    search = _search(profile, kept, offset_mm + allowance_mm, tolerance_mm)
    other = _beside_contour(profile, moves, nose_radius_mm + allowance_mm, tolerance_mm)
    return search, tuple(_tried(search, other, index) for index in range(len(profile.features)))


def _in_lines(moves: Sequence[FeedMove], lines: tuple[int, int] | None) -> list[FeedMove]:
    return [m for m in moves if lines is None or lines[0] <= m.line <= lines[1]]


def _search(profile: Profile, moves: Sequence[FeedMove], offset_mm: float, tolerance_mm: float) -> "_Search":
    return _Search(profile, nose_centre_path(profile, offset_mm), moves, tolerance_mm)


def _beside_contour(
    profile: Profile, moves: Sequence[FeedMove], offset_mm: float, tolerance_mm: float
) -> "_Search | None":
    """The search among moves of the nose's centre of a program that has moves of the contour too."""
    of_centre = [move for move in moves if not move.on_contour]
    if len(of_centre) in (0, len(moves)):
        return None
    try:
        return _search(profile, of_centre, offset_mm, tolerance_mm)
    except TrueloopError:  # the nose does not fit: then none of them is its path
        return None


def _tried(search: "_Search", other: "_Search | None", index: int) -> FeatureMatch | TrueloopError:
    """The match, or why there is none; `other` are the moves of the nose's centre beside those of the contour."""
    try:
        match = search.match(index)
        _require_outside(match)
        if other is not None and (also := other.whole_passes(index)):
            raise search.ambiguous(index, [match.moves, *(p.moves for p in also)])
    except TrueloopError as refusal:
        return refusal
    return match


@dataclass(frozen=True)
class _Cut:
    """A move along a feature: its place among the feed moves, its ends' arc lengths on the centre path's feature."""

    ordinal: int
    matched: MatchedMove
    from_mm: float
    to_mm: float

    def goes_on_as(self, after: "_Cut") -> bool:
        """Whether `after` is the very next move, in the same direction."""
        adjacent = after.ordinal == self.ordinal + 1 and after.matched.move.chain == self.matched.move.chain
        return adjacent and (after.to_mm - after.from_mm) * (self.to_mm - self.from_mm) > 0


@dataclass(frozen=True)
class _Pass:
    """Consecutive moves along one feature in one direction, and how much of its length they leave."""

    moves: tuple[MatchedMove, ...]
    missing_mm: float
    length_mm: float


@dataclass(frozen=True)
class _Search:
    profile: Profile
    path: CentrePath
    moves: Sequence[FeedMove]
    tolerance_mm: float

    def match(self, index: int) -> FeatureMatch:
        """The one whole pass over feature `index`; a pass over less than a tenth of it does not count."""
        passes = [p for p in self._passes(index) if p.missing_mm < 0.9 * p.length_mm]
        if not any(self._whole(p) for p in passes):
            raise self._no_match(index, passes)
        if len(passes) > 1:
            raise self.ambiguous(index, [p.moves for p in passes])
        moves = passes[0].moves
        backwards = moves[0].start_mm > moves[0].end_mm
        feature, offset_mm = self.profile.features[index], self.path.nose_radius_mm
        return FeatureMatch(feature, moves[::-1] if backwards else moves, backwards, offset_mm)

    def whole_passes(self, index: int) -> list[_Pass]:
        """Those that cut all of feature `index`."""
        return [over for over in self._passes(index) if self._whole(over)]

    def _whole(self, over: _Pass) -> bool:
        """Neighbours that stand off by up to the tolerance shift the place where one move hands over to the next."""
        return over.missing_mm <= 0.1 * over.length_mm + 2 * self.tolerance_mm

    def _passes(self, index: int) -> list[_Pass]:
        runs: list[list[_Cut]] = []
        for cut in self._cuts(index):
            if runs and runs[-1][-1].goes_on_as(cut):
                runs[-1].append(cut)
            else:
                runs.append([cut])
        return [self._pass(index, run) for run in runs]

    def _pass(self, index: int, run: Sequence[_Cut]) -> _Pass:
        length_mm = self.path.features[index].length_mm
        low = min(min(cut.from_mm, cut.to_mm) for cut in run)
        high = max(max(cut.from_mm, cut.to_mm) for cut in run)
        missing_mm = max(low, 0.0) + max(length_mm - high, 0.0)
        return _Pass(tuple(cut.matched for cut in run), missing_mm, length_mm)

    def _cuts(self, index: int) -> Iterator[_Cut]:
        """Moves along the feature, in program order: both ends near its line or circle, then all of the move."""
        if not self.moves:
            return
        feature = self.path.features[index]
        starts = feature.locate([m.path.start_mm for m in self.moves])[1]
        ends = feature.locate([m.path.end_mm for m in self.moves])[1]
        near = (np.abs(starts) <= self.tolerance_mm) & (np.abs(ends) <= self.tolerance_mm)
        for k in np.flatnonzero(near):
            if (cut := self._cut(index, int(k))) is not None:
                yield cut

    def _cut(self, index: int, k: int) -> _Cut | None:
        move, feature = self.moves[k], self.path.features[index]
        points = move.path.point_mm(np.linspace(0.0, move.path.length_mm, _SAMPLES))
        s, off = feature.locate(points)
        advance = abs(float(s[-1] - s[0]))
        if np.abs(off).max() > self.tolerance_mm or advance < _SAME_DIRECTION * move.path.length_mm:
            return None
        low, high = max(min(s[0], s[-1]), 0.0), min(max(s[0], s[-1]), feature.length_mm)
        enough = min(0.5 * advance, 0.5 * feature.length_mm, 2 * self.tolerance_mm)
        if high - low < enough or not self._nearest_is(index, (low + high) / 2, s, points):
            return None
        ends = self.profile.features[index].locate(points[[0, -1]])[0]
        return _Cut(k, MatchedMove(move, float(ends[0]), float(ends[1])), float(s[0]), float(s[-1]))

    def _nearest_is(self, index: int, middle_mm: float, s: Array, points: Array) -> bool:
        """Whether the move, in the middle of what it shares with the feature, is nearer to it than to any other."""
        order = np.argsort(s)
        middle = [float(np.interp(middle_mm, s[order], points[order, axis])) for axis in (0, 1)]
        return bool(Profile(self.path.features, ()).locate(middle).feature_index[0] == index)

    def _no_match(self, index: int, passes: Sequence[_Pass]) -> TrueloopError:
        name = self.profile.features[index].name
        hint = "check nose radius, allowance, parameters, part zero; without G41 or G42 the path is the nose centre's"
        if passes:
            best = min(passes, key=lambda p: p.missing_mm)
            cut_mm, by_line = best.length_mm - best.missing_mm, best.moves[0].move.line
            message = f"'{name}' is cut on {cut_mm:.3f} mm of {best.length_mm:.3f} mm only, from line {by_line} on"
            return TrueloopError(Code.NC_NO_MATCH, message, hint=hint, place=Place(line=by_line))
        nearest_mm, line = self._nearest(index)
        message = f"no feed move cuts '{name}' within {self.tolerance_mm:.3f} mm" + (
            f": the nearest, line {line}, passes its middle at {nearest_mm:.3f} mm" if line else ": there are 0 moves"
        )
        return TrueloopError(Code.NC_NO_MATCH, message, hint=hint, place=Place(line=line))

    def _nearest(self, index: int) -> tuple[float, int | None]:
        """Distance from the middle of the centre path's feature to the nearest feed move, and that move's line."""
        feature = self.path.features[index]
        x, z = feature.point_mm(feature.length_mm / 2)
        found = [(distance_mm(move.path, (float(x), float(z))), move.line) for move in self.moves]
        return min(found, default=(math.inf, None))

    def ambiguous(self, index: int, passes: Sequence[Sequence[MatchedMove]]) -> TrueloopError:
        """NC-AMBIGUOUS: several passes cut feature `index`."""
        ordered = sorted(passes, key=lambda moves: moves[0].move.index)
        spans = [_span(moves) for moves in ordered]
        return TrueloopError(
            Code.NC_AMBIGUOUS,
            f"'{self.profile.features[index].name}' is cut {len(passes)} times within {self.tolerance_mm:.3f} mm, by "
            f"lines {', '.join(spans)}",
            hint=_how_to_choose(spans),
            place=Place(line=ordered[1][0].move.line),
        )


def _require_outside(match: FeatureMatch) -> None:
    """Along the profile, from chuck end to free end, the material is at the right: G41 keeps the nose off it."""
    outside = 42 if match.backwards else 41
    for matched in match.moves:
        if matched.move.on_contour and matched.move.compensation != outside:
            line, mode = matched.move.line, matched.move.compensation
            raise TrueloopError(
                Code.NC_COMPENSATED,
                f"line {line} cuts '{match.feature.name}' with G{mode}, which keeps the nose on the material's side",
                hint=f"a pass outside in this direction wants G{outside}; bores are not corrected",
                place=Place(line=line),
            )


def _how_to_choose(spans: Sequence[str]) -> str:
    if len(set(spans)) == 1:
        return (
            "the same lines run several times, so no range of lines tells the passes apart: write the finish pass out"
        )
    return "name the lines of the pass that is meant, first and last: in a job, [programs] finish_lines = [from, to]"


def _span(moves: Sequence[MatchedMove]) -> str:
    """The lines of a pass, with the code that keeps the nose off it where one does."""
    first, last = sorted((moves[0].move.line, moves[-1].move.line))
    lines = str(first) if first == last else f"{first}–{last}"
    return f"{lines} (G{moves[0].move.compensation})" if moves[0].move.on_contour else lines


def _with_the_rest(search: _Search, matches: tuple[FeatureMatch, ...]) -> ContourMatch:
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
    """Whether a straight move only goes on from the path's free end along its tangent, or arrives so at its start."""
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
