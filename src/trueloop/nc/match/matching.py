"""The search for the moves of a program that cut each feature.

The match of a program with a profile: the passes over a feature (runs of feed moves that follow it), the one that
cuts it whole, and the deviation of the commanded contour.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Arc, Feature, Line, LineOrArc, distance_mm
from trueloop.geometry.offset import CentrePath, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.nc.program.along import FeedMove, moves_of_one_kind
from trueloop.wording import wording


@dataclass(frozen=True)
class MatchedMove:
    """One move that cuts a feature.

    `start_mm` and `end_mm` are the arc lengths, on the nominal feature, of the feet of the move's ends: less than 0 or
    more than the feature's length where it runs beyond, falling in a reversed program.
    """

    move: FeedMove
    start_mm: float
    end_mm: float


@dataclass(frozen=True)
class FeatureMatch:
    """The moves that cut one feature, in order of arc length. `offset_mm` is nose radius plus allowance."""

    feature: Feature
    moves: tuple[MatchedMove, ...]
    backwards: bool
    offset_mm: float

    def deviation_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the commanded contour's deviation from nominal (plus allowance) along the normal, (...) → (...).

        Measured from the nominal centre path to the commanded one along the nominal normal, which equals the distance
        of the contours up to R·slope²/2. Exact and linear for a line on a line. Beyond the first and last move these
        go on along their line or circle.
        """
        s = np.asarray(arc_length_mm, dtype=np.float64)
        normal = self.feature.outward_normal(s)
        origin = self.feature.point_mm(s) + self.offset_mm * normal
        turns = np.array([max(min(m.start_mm, m.end_mm), 0.0) for m in self.moves[1:]])
        piece = np.searchsorted(turns, s, side="right")
        deviation = np.empty_like(s)
        for k, matched in enumerate(self.moves):
            here = piece == k
            deviation[here] = _along_normal(matched.move.path, origin[here], normal[here])
        return deviation


@dataclass(frozen=True)
class ContourMatch:
    """All features of a profile with the moves that cut them.

    Of the other moves in the same uninterrupted chains of feed moves, `lead` come before or after (approach, pull-out),
    `run_out` only lengthen the profile's first or last feature beyond its end, and `between` lie between two features
    (an arc about an edge, say). Sorted by their place in the program.
    """

    profile: Profile
    features: tuple[FeatureMatch, ...]
    lead: tuple[FeedMove, ...]
    run_out: tuple[FeedMove, ...]
    between: tuple[FeedMove, ...]

    @property
    def on_contour(self) -> bool:
        """Returns whether the moves are those of the contour, under G41 or G42, and not of the nose's centre."""
        return self.features[0].moves[0].move.on_contour


def _along_normal(commanded: LineOrArc, origin: Array, normal: Array) -> Array:
    """Signed distance from `origin` (n, 2) along `normal` to the line or circle of a move: the nearer crossing."""
    if isinstance(commanded, Line):
        across = commanded.outward_normal(0.0)
        to_line: Array = (np.asarray(commanded.start_mm) - origin) @ across / (normal @ across)
        return to_line
    from_centre = origin - np.asarray(commanded.centre_mm)
    along = np.einsum("ij,ij->i", normal, from_centre)
    power = np.einsum("ij,ij->i", from_centre, from_centre) - commanded.radius_mm**2
    to_circle: Array = -power / (along + np.copysign(np.sqrt(np.maximum(along**2 - power, 0.0)), along))
    return to_circle


_SAMPLES: Final = 17
_SAME_DIRECTION: Final = 0.8
"""A move goes along a feature when it advances on it by at least this share of its length."""


@dataclass(frozen=True)
class _Cut:
    """A move along a feature: its place among the feed moves, its ends' arc lengths on the centre path's feature."""

    ordinal: int
    matched: MatchedMove
    from_mm: float
    to_mm: float

    def goes_on_as(self, after: "_Cut") -> bool:
        """Returns whether `after` is the very next move, in the same direction."""
        adjacent = after.ordinal == self.ordinal + 1 and after.matched.move.chain == self.matched.move.chain
        return adjacent and (after.to_mm - after.from_mm) * (self.to_mm - self.from_mm) > 0


@dataclass(frozen=True)
class Pass:
    """Consecutive moves along one feature in one direction, and how much of its length they leave."""

    moves: tuple[MatchedMove, ...]
    missing_mm: float
    length_mm: float


@dataclass(frozen=True)
class Passes:
    """The search for passes among feed moves, along the path that they would take over the profile, and how near."""

    profile: Profile
    path: CentrePath
    moves: Sequence[FeedMove]
    tolerance_mm: float

    def match(self, index: int) -> FeatureMatch:
        """Returns the one whole pass over feature `index`; a pass over less than a tenth of it does not count."""
        passes = [p for p in self._passes(index) if p.missing_mm < 0.9 * p.length_mm]
        if not any(self._whole(p) for p in passes):
            raise self._no_match(index, passes)
        if len(passes) > 1:
            raise self.ambiguous(index, [p.moves for p in passes])
        moves = passes[0].moves
        backwards = moves[0].start_mm > moves[0].end_mm
        feature, offset_mm = self.profile.features[index], self.path.nose_radius_mm
        return FeatureMatch(feature, moves[::-1] if backwards else moves, backwards, offset_mm)

    def whole_passes(self, index: int) -> list[Pass]:
        """Returns the passes that cut all of feature `index`."""
        return [over for over in self._passes(index) if self._whole(over)]

    def _whole(self, over: Pass) -> bool:
        """Neighbours that deviate by up to the tolerance shift the place where one move hands over to the next."""
        return over.missing_mm <= 0.1 * over.length_mm + 2 * self.tolerance_mm

    def _passes(self, index: int) -> list[Pass]:
        runs: list[list[_Cut]] = []
        for cut in self._cuts(index):
            if runs and runs[-1][-1].goes_on_as(cut):
                runs[-1].append(cut)
            else:
                runs.append([cut])
        return [self._pass(index, run) for run in runs]

    def _pass(self, index: int, run: Sequence[_Cut]) -> Pass:
        length_mm = self.path.features[index].length_mm
        low = min(min(cut.from_mm, cut.to_mm) for cut in run)
        high = max(max(cut.from_mm, cut.to_mm) for cut in run)
        missing_mm = max(low, 0.0) + max(length_mm - high, 0.0)
        return Pass(tuple(cut.matched for cut in run), missing_mm, length_mm)

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
        """Returns whether the move, in the middle of what it shares with the feature, is nearer to it than to any
        other.
        """
        order = np.argsort(s)
        middle = [float(np.interp(middle_mm, s[order], points[order, axis])) for axis in (0, 1)]
        return bool(Profile(self.path.features, ()).locate(middle).feature_index[0] == index)

    def _no_match(self, index: int, passes: Sequence[Pass]) -> TrueloopError:
        name = self.profile.features[index].name
        hint = (
            "check nose radius, allowance, parameters, part zero; without G41 or G42 the path is that of the nose's "
            "centre, or of the tip that `tool.tip` states"
        )
        if passes:
            best = min(passes, key=lambda p: p.missing_mm)
            cut_mm, by_line = best.length_mm - best.missing_mm, best.moves[0].move.line
            message = f"'{name}' is cut on {cut_mm:.3f} mm of {best.length_mm:.3f} mm only, from line {by_line} on"
            return Code.NC_NO_MATCH.refusal(message, hint=hint, place=Place(line=by_line), values={"feature": name})
        nearest_mm, line = self._nearest(index)
        message = f"no feed move cuts '{name}' within {self.tolerance_mm:.3f} mm" + (
            f": the nearest, line {line}, passes its middle at {nearest_mm:.3f} mm" if line else ": there are 0 moves"
        )
        return Code.NC_NO_MATCH.refusal(message, hint=hint, place=Place(line=line), values={"feature": name})

    def _nearest(self, index: int) -> tuple[float, int | None]:
        """Distance from the middle of the centre path's feature to the nearest feed move, and that move's line."""
        feature = self.path.features[index]
        x, z = feature.point_mm(feature.length_mm / 2)
        found = [(distance_mm(move.path, (float(x), float(z))), move.line) for move in self.moves]
        return min(found, default=(math.inf, None))

    def ambiguous(self, index: int, passes: Sequence[Sequence[MatchedMove]]) -> TrueloopError:
        """Returns the error NC-AMBIGUOUS: several passes cut feature `index`."""
        ordered = sorted(passes, key=lambda moves: moves[0].move.index)
        spans = [_span(moves) for moves in ordered]
        return Code.NC_AMBIGUOUS.refusal(
            wording(
                "'{feature}' is cut {n} times within {tolerance_mm:.3f} mm, by lines {lines}",
                feature=self.profile.features[index].name,
                n=len(passes),
                tolerance_mm=self.tolerance_mm,
                lines=", ".join(spans),
            ),
            hint=_how_to_choose(spans),
            place=Place(line=ordered[1][0].move.line),
            values={"feature": self.profile.features[index].name, "lines": spans},
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
