"""The targets of the moves of a program: the ends of its cuts, and new moves in place of its arcs.

The expected error of the finish cut at the gauging points. A prediction, not a measurement.

Everything is the difference of two nose-centre paths, the one commanded and the corrected one, at the same place of
the part. What the programmer rounded stays rounded; only the difference is added.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.geometry.feature import Line
from trueloop.turned.compensation.displaced import CentrePiece, reaches_mm
from trueloop.turned.compensation.moves import Move, SampledPath, as_arcs, as_lines, fewest_moves
from trueloop.turned.error_curve.curve import Budget


@by_content
@dataclass(frozen=True)
class Prediction:
    """Part errors at the touches, all (n,), mm, positive = material left on.

    `before_mm` was measured. `after_mm` = process error − w · fitted process error. `leave_one_out_mm` is the same with
    each touch's own reading kept out of the fit: what an untouched point may expect. `budget` is the
    uncertainty of the next cut's error about `after_mm`.
    """

    before_mm: Array
    after_mm: Array
    leave_one_out_mm: Array
    budget: Budget

    @property
    def standard_u_mm(self) -> Array:
        """Returns the standard uncertainty of the next cut's error, all causes together, (n,)."""
        return self.budget.standard_u_mm

    @property
    def expanded_u_mm(self) -> Array:
        """Returns the half width of the band that holds the next cut's error with 95 %, (n,)."""
        return self.budget.expanded_u_mm


def predict(
    measured_mm: Array, process_mm: Array, fitted_mm: Array, left_out_fitted_mm: Array, budget: Budget, weight: float
) -> Prediction:
    """Predicts the process error less w times its fit. The semi-finish program's own deviation does not count."""
    return Prediction(
        before_mm=measured_mm,
        after_mm=process_mm - weight * fitted_mm,
        leave_one_out_mm=process_mm - weight * left_out_fitted_mm,
        budget=budget,
    )


STEP_MM = 0.25


@by_content
@dataclass(frozen=True)
class CorrectionTable:
    """Rows in cutting order, chuck end to free end: where the program sends the nose centre, and what to add there.

    `commanded_mm` and `correction_mm` are (n, 2) in (x as a radius, z). Between rows the correction is linear.
    """

    feature: tuple[str, ...]
    commanded_mm: Array
    correction_mm: Array


def correction_table(
    commanded: Sequence[CentrePiece], corrected: Sequence[CentrePiece], offset_mm: tuple[float, float] = (0.0, 0.0)
) -> CorrectionTable:
    """Tabulates both paths feature by feature at equal shares of each, so that corners go to corners.

    `offset_mm` (x as a radius, z) is what a tool offset moves the corrected path by, everywhere: who corrects in real
    time by the table does not change the offset too.

    Valid for small corrections: a row's share differs from the foot of the normal by the tangential shift of the
    corners, micrometres on features of millimetres.
    """
    names: list[str] = []
    positions: list[Array] = []
    corrections: list[Array] = []
    for before, after in zip(commanded, corrected, strict=True):
        count = max(2, int(np.ceil((before.end_mm - before.start_mm) / STEP_MM)) + 1)
        position = before.shifted.centre_mm(np.linspace(before.start_mm, before.end_mm, count))
        names += [before.shifted.feature.name] * count
        positions.append(position)
        corrections.append(after.shifted.centre_mm(np.linspace(after.start_mm, after.end_mm, count)) - position)
    return CorrectionTable(tuple(names), np.concatenate(positions), np.concatenate(corrections) + offset_mm)


SAMPLE_MM = 0.02
"""Spacing of the samples a path is fitted on: the sagitta between them is under 0.01 µm from 5 mm radius up."""

SAMPLES_OF_LINE = 65

AT_TOUCH = 0.1
"""At a gauging point the moves keep to this share of the chord tolerance: there the result will be judged."""


ROOM = 1.5
"""So many times the nose's own share of a move before a corner are left to the move: the correction turns corners by
milliradians and moves their ends by some hundredths."""

OPEN_RAD = 2.2
"""The turn of a contour at its ends, where what comes next is not the part's, and the sharpest corner looked at."""


@dataclass(frozen=True)
class Cut:
    """A move of the program that cuts one feature, from one arc length of it to another; backwards when they fall."""

    move: int
    feature: int
    start_mm: float
    end_mm: float


@dataclass(frozen=True)
class EndShift:
    """The end of a move is displaced by (dx, dz) mm, dx a radius."""

    move: int
    delta_mm: Array


@dataclass(frozen=True)
class Replacement:
    """An arc of the program gives way to these moves, in cutting order."""

    move: int
    moves: tuple[Move, ...]


@dataclass(frozen=True)
class Fitting:
    """The style of arcs: chord tolerance in mm, and "lines", "arcs" or "auto" (whichever needs fewer blocks).

    `lines`: whether a line may have to become several, because what moves it bends it. `nose_mm`: radius of the nose
    that the control keeps off the moves, 0 where the program moves its centre.
    """

    tolerance_mm: float
    arcs: str = "auto"
    lines: bool = False
    nose_mm: float = 0.0


@dataclass(frozen=True)
class CutEnds:
    """Arc lengths where a cut begins and ends on one set of centre pieces."""

    start_mm: float
    end_mm: float


def with_edges(
    cuts: Sequence[Cut], commanded: Sequence[CentrePiece], corrected: Sequence[CentrePiece], about: Collection[int] = ()
) -> tuple[Cut, ...]:
    """Returns the cuts with their ends on the corrected pieces: where moves that are not drawn break the edge of two
    features, both of its ends go with the corner. Where one of the moves `about` turns the nose about the edge, the
    cuts end and begin where the features do.
    """

    def moved_mm(k: int, other: int) -> float:
        if not 0 <= other < len(cuts) or _follows(cuts, max(k, other)):
            return 0.0
        first, last = sorted((cuts[k].move, cuts[other].move))
        if any(first < move < last for move in about):
            return 0.0
        feature, beside = cuts[k].feature, cuts[other].feature
        if abs(beside - feature) != 1:
            return 0.0
        before, after = commanded[feature], corrected[feature]
        return after.end_mm - before.end_mm if beside > feature else after.start_mm - before.start_mm

    return tuple(
        replace(cut, start_mm=cut.start_mm + moved_mm(k, k - 1), end_mm=cut.end_mm + moved_mm(k, k + 1))
        for k, cut in enumerate(cuts)
    )


def end_shifts(
    cuts: Sequence[Cut], moved: Sequence[Cut], commanded: Sequence[CentrePiece], corrected: Sequence[CentrePiece]
) -> tuple[Array, tuple[EndShift, ...]]:
    """Returns by how much the start of the first cut and the ends of all cuts move, from those on the commanded pieces
    to those of the cuts `moved` (`with_edges`) on the corrected ones.

    Where other moves stand between two cuts (about an edge), the last of them ends where the next cut starts.
    """
    pairs = [(ends_of(cuts, k, commanded), ends_of(moved, k, corrected)) for k in range(len(cuts))]
    first = cuts[0].feature
    start = _difference(commanded[first], pairs[0][0].start_mm, corrected[first], pairs[0][1].start_mm)
    shifts: list[EndShift] = []
    for k, (cut, (old, new)) in enumerate(zip(cuts, pairs, strict=True)):
        before, after = commanded[cut.feature], corrected[cut.feature]
        if k > 0 and not _follows(cuts, k):
            shifts.append(EndShift(cut.move - 1, _difference(before, old.start_mm, after, new.start_mm)))
        shifts.append(EndShift(cut.move, _difference(before, old.end_mm, after, new.end_mm)))
    return start, tuple(shifts)


def replaced_arcs(
    cuts: Sequence[Cut],
    arc_moves: Sequence[int],
    corrected: Sequence[CentrePiece],
    touches_mm: Sequence[Array],
    fitting: Fitting,
) -> tuple[Replacement, ...]:
    """Returns new moves for the cuts that are arcs in the program. `touches_mm[i]`: of feature i's touches."""
    return tuple(
        Replacement(cut.move, _fitted(cuts, k, corrected, touches_mm[cut.feature], fitting))
        for k, cut in enumerate(cuts)
        if cut.move in arc_moves
    )


def bent_lines(
    cuts: Sequence[Cut], arc_moves: Sequence[int], corrected: Sequence[CentrePiece], tolerance_mm: float
) -> list[int]:
    """Moves of cuts that are lines in the program and whose corrected path is not, by half the tolerance or more."""
    found = []
    for k, cut in enumerate(cuts):
        if cut.move not in arc_moves and isinstance(corrected[cut.feature].shifted.feature, Line):
            ends = ends_of(cuts, k, corrected)
            if _off_chord_mm(corrected[cut.feature], ends.start_mm, ends.end_mm) > tolerance_mm / 2:
                found.append(cut.move)
    return found


def cramped_lines(
    cuts: Sequence[Cut], arc_moves: Sequence[int], corrected: Sequence[CentrePiece], fitting: Fitting
) -> list[int]:
    """Returns the lines that bend by more than the tolerance over the nose's room at a corner: no moves follow them."""
    found = []
    for k, cut in enumerate(cuts):
        if cut.move in arc_moves or not isinstance(corrected[cut.feature].shifted.feature, Line):
            continue
        ends, (first_mm, last_mm) = ends_of(cuts, k, corrected), _rooms_mm(cuts, k, corrected, fitting.nose_mm)
        length_mm = ends.end_mm - ends.start_mm
        first_mm, last_mm = (math.copysign(min(room, abs(length_mm)), length_mm) for room in (first_mm, last_mm))
        stretches = (ends.start_mm, ends.start_mm + first_mm), (ends.end_mm - last_mm, ends.end_mm)
        if max(_off_chord_mm(corrected[cut.feature], *stretch) for stretch in stretches) > fitting.tolerance_mm:
            found.append(cut.feature)
    return sorted(set(found))


def _off_chord_mm(piece: CentrePiece, start_mm: float, end_mm: float) -> float:
    """Returns the largest distance of a stretch of a path from its chord."""
    at = piece.shifted.centre_mm(np.linspace(start_mm, end_mm, SAMPLES_OF_LINE))
    along = (at[-1] - at[0]) / max(float(np.linalg.norm(at[-1] - at[0])), 1e-12)
    return float(np.max(np.abs((at - at[0]) @ np.array([along[1], -along[0]]))))


def ends_of(cuts: Sequence[Cut], k: int, pieces: Sequence[CentrePiece]) -> CutEnds:
    """Returns where cut k begins and ends on some pieces: at a junction where they pass to the neighbour."""
    cut, (before, after) = cuts[k], neighbours(cuts, k)
    return CutEnds(_place(cut.feature, cut.start_mm, before, pieces), _place(cut.feature, cut.end_mm, after, pieces))


def neighbours(cuts: Sequence[Cut], k: int) -> tuple[int | None, int | None]:
    """Features cut before and after cut k: None at the contour's ends, its own where other moves stand between."""
    feature = cuts[k].feature
    before = None if k == 0 else cuts[k - 1].feature if _follows(cuts, k) else feature
    after = None if k + 1 == len(cuts) else cuts[k + 1].feature if _follows(cuts, k + 1) else feature
    return before, after


def _follows(cuts: Sequence[Cut], k: int) -> bool:
    """Returns whether cut k follows the one before it without a move between them."""
    return cuts[k].move == cuts[k - 1].move + 1


def _place(feature: int, at_mm: float, neighbour: int | None, pieces: Sequence[CentrePiece]) -> float:
    """Returns the arc length of a cut's end: where the neighbour begins, or inside its feature, or at a free end."""
    piece = pieces[feature]
    if neighbour == feature:
        return at_mm
    if neighbour is not None:
        return piece.end_mm if neighbour > feature else piece.start_mm
    length = piece.shifted.feature.length_mm
    at_end = at_mm > length / 2
    return reaches_mm(piece.shifted, at_mm - length if at_end else -at_mm, at_end)


def _difference(old: CentrePiece, old_mm: float, new: CentrePiece, new_mm: float) -> Array:
    return np.asarray(new.shifted.centre_mm(new_mm) - old.shifted.centre_mm(old_mm))


def _fitted(
    cuts: Sequence[Cut], k: int, corrected: Sequence[CentrePiece], touches_mm: Array, fitting: Fitting
) -> tuple[Move, ...]:
    piece, ends = corrected[cuts[k].feature], ends_of(cuts, k, corrected)
    straight = isinstance(piece.shifted.feature, Line)
    rooms_mm = _rooms_mm(cuts, k, corrected, fitting.nose_mm) if straight else (0.0, 0.0)
    path = _sampled(piece, ends, touches_mm, fitting.tolerance_mm, rooms_mm)
    if fitting.arcs == "lines" or straight:
        return as_lines(path)
    return as_arcs(path) if fitting.arcs == "arcs" else fewest_moves(path)


def _rooms_mm(cuts: Sequence[Cut], k: int, corrected: Sequence[CentrePiece], nose_mm: float) -> tuple[float, float]:
    """Returns the lengths that the first and the last move of a bent line have at least: a nose of radius R that the
    control keeps off a corner of the turn θ stands R tan(θ/2) before its end.
    """
    turns = [_turn_rad(cuts[k].feature, other, corrected) for other in neighbours(cuts, k)]
    start_mm, end_mm = (ROOM * nose_mm * math.tan(min(turn, OPEN_RAD) / 2.0) for turn in turns)
    return start_mm, end_mm


def _turn_rad(feature: int, other: int | None, corrected: Sequence[CentrePiece]) -> float:
    if other is None or other == feature:
        return OPEN_RAD
    before, after = (corrected[i].shifted.feature for i in sorted((feature, other)))
    cosine = float(before.tangent(before.length_mm) @ after.tangent(0.0))
    return math.acos(max(-1.0, min(cosine, 1.0)))


def _sampled(
    piece: CentrePiece, ends: CutEnds, touches_mm: Array, tolerance_mm: float, rooms_mm: tuple[float, float]
) -> SampledPath:
    low, high = sorted((ends.start_mm, ends.end_mm))
    forward = ends.end_mm >= ends.start_mm
    touched = touches_mm[(touches_mm > low) & (touches_mm < high)]
    even = np.linspace(low, high, max(3, int((high - low) / SAMPLE_MM) + 1))
    s = np.unique(np.concatenate([even, touched]))
    s = s[_not_close(s, low, high, rooms_mm if forward else rooms_mm[::-1])]
    tolerance = np.where(np.isin(s, touched), AT_TOUCH * tolerance_mm, tolerance_mm)
    order = slice(None) if forward else slice(None, None, -1)
    tangent = piece.shifted.tangent(s)[order]
    return SampledPath(piece.shifted.centre_mm(s)[order], tangent if forward else -tangent, tolerance[order])


def _not_close(s: Array, low: float, high: float, rooms_mm: tuple[float, float]) -> Flags:
    """Returns which of places are the ends, or have room to either end."""
    ends = (s == low) | (s == high)
    return np.asarray(ends | ((s >= low + rooms_mm[0]) & (s <= high - rooms_mm[1])))
