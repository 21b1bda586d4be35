"""The process-intermittent correction as a table that the servo thread applies by program line, in place of a program.

(Δx, Δz) from a lookup table, added to what the given program commands [4773 §2.3, §3.2]; the error specification file
of [6811 abstract, §2]. Of a composed correction the table is COMP_PROC: the model does COMP_MTG in real time, at the
temperatures of the moment.

The additions along every move of a finish pass: on the cuts, between them, on the way in and on the way out.

The corrected program is the model: what its words do to the ends of moves, the table does along them. A rapid onto the
contour, which the corrected program leaves alone, is displaced only where that brings it no nearer to the part.

The additions of a correction along one move of the control, by share of the move, 0 to 1.

In (x as a radius, z), mm. Where the move cuts, it is the corrected path of the nose's centre less the commanded one at
the same place of the part; before and after, it fades as the ends of those moves do in the corrected program.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.record import check_uncorrected
from trueloop.errors import Code, in_file
from trueloop.geometry.profile import Profile
from trueloop.loops.realtime.lines import SAME_MM, Driven, driven, require_kept_path, require_known_lines
from trueloop.loops.turned.commanded import Run, commanded
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.part_on_machine import CompMtg, PartOnMachine
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion
from trueloop.realtime.image import Block
from trueloop.turned.compensation.displaced import (
    CentrePiece,
    DisplacedFeature,
    Displacement,
    ShiftedFeature,
    Then,
    centre_pieces,
    shifted_contour,
)
from trueloop.turned.compensation.moves import Move, between
from trueloop.turned.compensation.shift import Shift
from trueloop.turned.compensation.targets import CutEnds, ends_of, neighbours
from trueloop.turned.program.read_back import move_of
from trueloop.units import UM_PER_MM


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
    """A move that cuts: from the commanded path of the nose's centre to the corrected one; `offset_mm` on top."""

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
    """Returns the additions by move of the control, in order: contour, moves that lead to it, moves that leave it."""
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
    contour = centre_pieces(driven.contour.match.profile, [feature.undisplaced for feature in bare])
    found = []
    for k, cut in enumerate(cuts):
        ends, piece = ends_of(cuts, k, contour), pieces[cut.feature]
        met = [neighbour not in (None, cut.feature) for neighbour in neighbours(cuts, k)]
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


WITHIN_MM: Final = 2e-6
"""Between two rows the correction is linear to this."""
SAGITTA_MM: Final = 1e-3
"""How far the chord between two rows of an arc may stand off the arc: a hundredth of the gate."""
SHORTEST_MM: Final = 1e-3
"""Rows are not put closer than this for the correction's sake."""
DIALECT: Final = "linuxcnc"


@dataclass(frozen=True)
class PlacedCorrection:
    """How the program stands in the machine.

    `origin_mm`: machine coordinates (x as a radius, z) of the program's zero during the finish pass, with all that is
    in force: work offset, G52, G92 and the tool's offset. `tip`: which point of the nose the control drives under G41
    and G42, LinuxCNC's tool orientation, 0 or 9 being its centre. `gate_mm`: how far off its path a row still holds.
    """

    origin_mm: tuple[float, float]
    tip: int = 0
    gate_mm: float = 0.1


@dataclass(frozen=True)
class ProcessTable:
    """The blocks of a table, lines ascending, and what to know of it."""

    blocks: tuple[Block, ...]
    notes: tuple[str, ...]


def process_table(program: Program, run: Run, correction: Correction, placed: PlacedCorrection) -> ProcessTable:
    """The table of a correction, for the program that it was made for, run as it was then.

    Raises CTL-DIALECT for another control than LinuxCNC, CMP-TWICE for a corrected program, RTC-TABLE where the
    correction was made for another one, RTC-LINE for lines that run more than once, RTC-PATH-MODE where the control
    would join blocks or leave their path by more than the gate.
    """
    name = program.dialect.name
    if name != DIALECT:
        raise Code.CTL_DIALECT.refusal(
            f"the finish program is written for {name!r}; the real-time corrector runs in LinuxCNC, by lines of "
            f"{DIALECT!r} programs",
            hint="run the corrected program, or write the finish program for LinuxCNC",
            values={"dialect": name},
        )
    with in_file(program.file):
        check_uncorrected(program.source)
        contour = commanded(program, None, correction.profile, correction.nose_radius_mm, 0.0, run)
        _require_same(_pieces(correction, contour.finish), correction.commanded)
        moves = driven(program, contour, run, correction.nose_radius_mm, placed.tip)
        cut = correction.cut_with
        offset_mm = np.array(cut.still_to_do(correction.decision.whole_offset_mm)) * correction.decision.by_offset
        after = [_of_process(piece) for piece in correction.corrected]
        added = added_along(moves, Corrected(correction.profile, correction.commanded, after, offset_mm))
        # Run once more, with the order in which its blocks are executed
        skipped = run.execute_deleted_blocks
        traced = program.run(run.parameters, skipped_blocks=skipped, strict=False, roughing=False, trace=True)
        require_known_lines(traced, moves, added)
        require_kept_path(program, traced, moves, added, placed.gate_mm)
    return ProcessTable(_blocks(moves, added, np.asarray(placed.origin_mm)), tuple(_notes(correction, moves, added)))


def _pieces(correction: Correction, finish: Sequence[Shift]) -> tuple[CentrePiece, ...]:
    profile = correction.profile
    return centre_pieces(profile, shifted_contour(profile, finish, correction.nose_radius_mm))


def _require_same(pieces: Sequence[CentrePiece], of_correction: Sequence[CentrePiece]) -> None:
    """Raises RTC-TABLE where the program, run again, commands another contour than the one that was corrected."""
    off_mm = max(float(np.max(np.abs(_sampled(a) - _sampled(b)))) for a, b in zip(pieces, of_correction, strict=True))
    if off_mm > 1e-6:
        raise Code.RTC_TABLE.refusal(
            f"the program commands a contour that is up to {off_mm * UM_PER_MM:.3f} µm off the one that was corrected",
            hint="take the job that the correction was made by: it says how the program is run",
        )


def _sampled(piece: CentrePiece) -> Array:
    return piece.shifted.centre_mm(np.linspace(piece.start_mm, piece.end_mm, 9))


def machine_of(correction: Correction) -> PartOnMachine | None:
    """The part on its machine, of a correction that holds COMP_MTG."""
    for piece in correction.corrected:
        moved = getattr(piece.shifted, "displacement", None)
        if isinstance(moved, Then) and isinstance(moved.second, CompMtg):
            return moved.second.standing.part
    return None


def _of_process(piece: CentrePiece) -> CentrePiece:
    """A corrected piece without COMP_MTG."""
    shifted = piece.shifted
    if not isinstance(shifted, DisplacedFeature):
        return piece
    return replace(piece, shifted=replace(shifted, displacement=_first(shifted.displacement)))


def _first(moved: Displacement) -> Displacement:
    return moved.first if isinstance(moved, Then) and isinstance(moved.second, CompMtg) else moved


def _blocks(moves: Driven, added: Mapping[int, Added], origin_mm: Array) -> tuple[Block, ...]:
    """Rows by line: those of the line's moves, one after the other."""
    rows: dict[int, list[Array]] = {}
    for move, one in added.items():
        if moves.length_mm[move] > SAME_MM:
            share = _shares(moves, move, one)
            at = moves.controlled_mm(move, share) + origin_mm
            rows.setdefault(int(moves.centre.line[move]), []).append(np.hstack([at, one.at(share)]))
    return tuple(Block(line, _joined(rows[line])) for line in sorted(rows))


def _joined(parts: Sequence[Array]) -> Array:
    rows = np.concatenate(parts)
    moved = np.any(np.abs(np.diff(rows[:, :2], axis=0)) > SAME_MM, axis=1)
    return np.asarray(rows[np.concatenate([[True], moved])])


def _shares(moves: Driven, move: int, added: Added) -> Array:
    """Where along a move rows stand: near enough to each other on arcs, and wherever what is added bends."""
    length_mm, share = float(moves.length_mm[move]), np.array([0.0, 1.0])
    if moves.centre.motion[move] == Motion.ARC:
        sweep = abs(float(moves.centre.sweep_rad[move]))
        most = 2.0 * np.arccos(max(1.0 - SAGITTA_MM * sweep / length_mm, 0.0))
        share = np.linspace(0.0, 1.0, int(np.ceil(sweep / most)) + 1)
    while True:
        # The addition between two shares leaves the straight way by more than `WITHIN_MM`, (n,)
        start, end = added.at(share[:-1]), added.at(share[1:])
        bends = np.zeros(len(start), dtype=np.bool_)
        for part in (0.25, 0.5, 0.75):
            off = added.at(share[:-1] + part * np.diff(share)) - (start + part * (end - start))
            bends |= np.linalg.norm(off, axis=1) > WITHIN_MM
        split = bends & (np.diff(share) * length_mm > SHORTEST_MM)
        if not np.any(split):
            return share
        share = np.sort(np.concatenate([share, (share[:-1] + share[1:])[split] / 2]))


def _notes(correction: Correction, moves: Driven, added: Mapping[int, Added]) -> Iterator[str]:
    yield "Table or corrected program, one of the two: with the table in force the given program is run."
    if correction.decision.by_offset:
        yield "The correction is a tool offset, and the table holds it: the tool's offset is left as it is."
    if correction.composed is not None:
        yield "The table is COMP_PROC alone: the machine model of the job does COMP_MTG in real time."
    lead = moves.lead
    if lead is not None and lead not in added:
        yield (
            f"The rapid of line {moves.centre.line[lead]} would come closer to the part and stays: the correction "
            f"comes in where line {moves.centre.line[moves.first]} begins, as fast as the corrector's slew lets it."
        )
