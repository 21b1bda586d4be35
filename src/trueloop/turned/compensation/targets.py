"""The targets of the moves of a program: the ends of its cuts, and new moves in place of its arcs.

Everything is the difference of two nose-centre paths, the one commanded and the corrected one, at the same place of
the part. What the programmer rounded stays rounded; only the difference is added.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Line
from trueloop.turned.compensation.contour import CentrePiece, reaches_mm
from trueloop.turned.compensation.moves import Move, SampledPath, as_arcs, as_lines, fewest_moves

SAMPLE_MM = 0.02
"""Spacing of the samples a path is fitted on: the sagitta between them is under 0.01 µm from 5 mm radius up."""

SAMPLES_OF_LINE = 65

AT_TOUCH = 0.1
"""At a gauging point the moves keep to this share of the chord tolerance: there the result will be judged."""


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

    `lines`: whether a line may have to become several, because what moves it bends it.
    """

    tolerance_mm: float
    arcs: str = "auto"
    lines: bool = False


@dataclass(frozen=True)
class CutEnds:
    """Arc lengths where a cut begins and ends on one set of centre pieces."""

    start_mm: float
    end_mm: float


def end_shifts(
    cuts: Sequence[Cut], commanded: Sequence[CentrePiece], corrected: Sequence[CentrePiece]
) -> tuple[Array, tuple[EndShift, ...]]:
    """Returns by how much the start of the first cut and the ends of all cuts move.

    Where other moves stand between two cuts (about an edge), the last of them ends where the next cut starts.
    """
    pairs = [(ends_of(cuts, k, commanded), ends_of(cuts, k, corrected)) for k in range(len(cuts))]
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
    """Returns new moves for every cut that is an arc in the program. `touches_mm[i]`: arc lengths of feature i's
    touches.
    """
    return tuple(
        Replacement(
            cut.move, _fitted(corrected[cut.feature], ends_of(cuts, k, corrected), touches_mm[cut.feature], fitting)
        )
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
            ends, shifted = ends_of(cuts, k, corrected), corrected[cut.feature].shifted
            at = shifted.centre_mm(np.linspace(ends.start_mm, ends.end_mm, SAMPLES_OF_LINE))
            along = (at[-1] - at[0]) / np.linalg.norm(at[-1] - at[0])
            off = (at - at[0]) @ np.array([along[1], -along[0]])
            if np.max(np.abs(off)) > tolerance_mm / 2:
                found.append(cut.move)
    return found


def ends_of(cuts: Sequence[Cut], k: int, pieces: Sequence[CentrePiece]) -> CutEnds:
    """Returns the places where cut k begins and ends on some pieces: at a junction where these go over to the
    neighbour.
    """
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
    """Returns the arc length of a cut's end: where it goes over to the neighbour, or inside its feature, or at a free
    end.
    """
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


def _fitted(piece: CentrePiece, ends: CutEnds, touches_mm: Array, fitting: Fitting) -> tuple[Move, ...]:
    path = _sampled(piece, ends, touches_mm, fitting.tolerance_mm)
    if fitting.arcs == "lines" or isinstance(piece.shifted.feature, Line):
        return as_lines(path)
    return as_arcs(path) if fitting.arcs == "arcs" else fewest_moves(path)


def _sampled(piece: CentrePiece, ends: CutEnds, touches_mm: Array, tolerance_mm: float) -> SampledPath:
    low, high = sorted((ends.start_mm, ends.end_mm))
    touched = touches_mm[(touches_mm > low) & (touches_mm < high)]
    even = np.linspace(low, high, max(3, int((high - low) / SAMPLE_MM) + 1))
    s = np.unique(np.concatenate([even, touched]))
    tolerance = np.where(np.isin(s, touched), AT_TOUCH * tolerance_mm, tolerance_mm)
    forward = ends.end_mm >= ends.start_mm
    order = slice(None) if forward else slice(None, None, -1)
    tangent = piece.shifted.tangent(s)[order]
    return SampledPath(piece.shifted.centre_mm(s)[order], tangent if forward else -tangent, tolerance[order])
