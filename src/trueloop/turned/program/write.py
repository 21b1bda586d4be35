"""The corrected program: the source with the ends of its cuts displaced and its arcs written anew, by span.

Only words of the contour change. A coordinate that a block inherits is written into it where the corrected path needs
one of its own; a rapid to the start of the contour stays where it was, and a feed move goes the rest of the way. Under
G41 or G42 such a move, shorter than the nose, would say where the nose is led in, and a roughing cycle would take it
for a piece of the contour: there the rapid ends where the corrected contour begins, as it did on the contour before.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.feature import Point
from trueloop.nc.edit.changes import require_own_shape
from trueloop.nc.edit.edit import (
    Edit,
    circle_text,
    coordinate_text,
    insert_blocks_after,
    insert_word,
    moved_word,
    replace_block,
    rounded_mm,
)
from trueloop.nc.expand.block import late_codes
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import INVERSE_TIME, NO_COMPENSATION, CoordinateState, Motion, ToolPath
from trueloop.turned.compensation.moves import Move, between, within_quadrants
from trueloop.turned.compensation.targets import EndShift, Replacement
from trueloop.turned.program.contour_cycles import finishing_cycle, require_named, roughed_by

GEOMETRY = frozenset("XZUWIK")
"""The words of an arc block that new moves replace, beside its radius; feed and comments stay in the first block."""


@dataclass(frozen=True)
class ArcStyle:
    """The style of a program's arcs: with R or with I and K, with `G02` or `G2`."""

    program: Program
    state: CoordinateState
    by_radius: bool
    motion_digits: int

    def motion(self, move: Move) -> str:
        """Returns the G word of a move."""
        code = 1 if move.centre_mm is None else 2 if move.sweep_rad > 0 else 3
        return f"G{code:0{self.motion_digits}d}"

    def allowed(self, moves: Sequence[Move]) -> tuple[Move, ...]:
        """Returns the moves as the control takes them."""
        if self.by_radius and self.program.dialect.radius_within_quadrant:
            return tuple(piece for move in moves for piece in within_quadrants(move))
        return tuple(moves)

    def geometry(self, move: Move, start_mm: Point) -> list[str]:
        """Returns the end, and radius or centre from the (rounded) start: `X2.98 Z-1.46 R1.49`."""
        origin = start_mm if self.state.incremental else (0.0, 0.0)
        words = [self._text("X", move.end_mm[0] - origin[0]), self._text("Z", move.end_mm[1] - origin[1])]
        if move.centre_mm is None:
            return words
        start, centre = (np.array([x, 0.0, z]) for x, z in (start_mm, move.centre_mm))
        circle = circle_text(self.program, self.state, (0, 2), centre, start, by_radius=self.by_radius)
        return [*words, circle]

    def rounded(self, point: Point, start_mm: Point) -> Point:
        """Returns where the control takes the end of a move from `start_mm` to be."""
        origin = start_mm if self.state.incremental else (0.0, 0.0)
        x, z = (
            from_mm + rounded_mm(self.program.dialect, letter, value - from_mm, self.state)
            for letter, value, from_mm in zip("XZ", point, origin, strict=True)
        )
        return x, z

    def _text(self, letter: str, value_mm: float) -> str:
        return coordinate_text(self.program.dialect, letter, value_mm, self.state)


def style_of(program: Program, block: Block, state: CoordinateState) -> ArcStyle:
    """Reads the style off the block that is to be replaced."""
    motion = next((word for word in block.words if is_motion(word)), None)
    digits = len(motion.text) - 1 if motion is not None else 2
    letter = program.dialect.radius_letter
    return ArcStyle(program, state, any(word.letter == letter and _is_value(word) for word in block.words), digits)


def blocks_for(moves: Sequence[Move], start_mm: Point, block: Block, style: ArcStyle) -> list[str]:
    """Returns one text a move, without block numbers. The source block's other words go to the first, in their order.

    M codes that act after the move go to the last. Raises NC-EDIT where it is not known which a code is.
    """
    geometry = GEOMETRY | {style.program.dialect.radius_letter}
    kept = [word for word in block.data if not ((word.letter in geometry and _is_value(word)) or is_motion(word))]
    pieces = style.allowed(moves)
    late = late_codes(kept, block) if len(pieces) > 1 else []
    texts: list[str] = []
    for move in pieces:
        texts.append(" ".join([style.motion(move), *style.geometry(move, start_mm)]))
        start_mm = style.rounded(move.end_mm, start_mm)
    texts[0] = " ".join([texts[0], *(word.text for word in kept if word not in late)])
    texts[-1] = " ".join([texts[-1], *(word.text for word in late)])
    return texts


def is_motion(word: Word) -> bool:
    """Returns whether a word is one of G00 to G03."""
    return word.letter == "G" and word.kind == "number" and word.value in (0.0, 1.0, 2.0, 3.0)


def _is_value(word: Word) -> bool:
    """Of a parameter that is given a value the letter is the parameter's."""
    return word.kind != "assignment"


AXES = ((0, "X"), (2, "Z"))

SAME_MM: Final = 1e-9

SLID_MM: Final = 1e-3
"""Ends nearer than this to those of an arc as fitted are rounding: its centre stays."""


@dataclass(frozen=True)
class Displacements:
    """The targets of the program's moves: displaced ends by move, new moves for arcs, and the first move of all."""

    ends: Mapping[int, Array]
    arcs: Mapping[int, Replacement]

    @property
    def first(self) -> int:
        """Returns the move whose end is displaced first: the one that leads to the contour."""
        return min(self.ends)

    @property
    def last(self) -> int:
        """Returns the last displaced move."""
        return max(self.ends)

    def off(self, by_mm: Array) -> "Displacements":
        """Returns the targets from ends that lie off by (n, 3): the intended ends stay."""
        ends = {move: end + by_mm[move, [0, 2]] for move, end in self.ends.items()}
        return Displacements(ends, self.arcs)


def displacements(
    path: ToolPath,
    start: Array,
    shifts: Sequence[EndShift],
    replacements: Sequence[Replacement],
    run_out: Sequence[int],
) -> Displacements:
    """Ends of the cuts, of the move that leads to them, and of moves that only lengthen the contour (`run_out`).

    Arcs that lead to the contour and off it are displaced as a whole, and lines that break an edge at its ends.
    """
    cuts = {shift.move: shift.delta_mm for shift in shifts}
    first, last = min(cuts), max(cuts)
    leads = min([*(move for move in run_out if move < first), first]) - 1
    while leads > 0 and path.motion[leads] == Motion.ARC:
        leads -= 1
    leads -= leads > 0 and _breaks_edge(path, leads, leads + 1, leads - 1)
    ends = dict.fromkeys(range(leads, first), start)
    held = start
    for move in range(first, last + 1):
        held = cuts.get(move, held)
        ends[move] = held
    ends |= {move: cuts[last] for move in run_out if move > last}
    while (after := max(ends) + 1) < len(path) and path.motion[after] == Motion.ARC:
        ends[after] = held
    if after + 1 < len(path) and _breaks_edge(path, after, after - 1, after + 1):
        ends[after] = held
    return Displacements(ends, {r.move: r for r in replacements})


EDGE: Final = math.cos(math.radians(10.0)), math.cos(math.radians(80.0))
"""Cosines of the least and the largest turn from a contour into a line that breaks its edge."""


def _breaks_edge(path: ToolPath, move: int, cut: int, beyond: int) -> bool:
    """Returns whether a move between `cut` at an end and a feed `beyond` breaks an edge that is not drawn."""
    if not np.all(path.motion[[move, beyond]] == Motion.LINE):
        return False
    along, own = ((path.end_mm[k] - path.start_mm[k])[[0, 2]] for k in (cut, move))
    cosine = float(along @ own) / max(float(np.linalg.norm(along) * np.linalg.norm(own)), 1e-12)
    return EDGE[1] < cosine < EDGE[0]


def corrected_source(program: Program, path: ToolPath, targets: Displacements) -> list[Edit]:
    """Returns the edits that displace the contour and keep later increments' ends. Raises NC-EDIT."""
    require_own_shape(program, path, range(targets.first, min(targets.last + 2, len(path))))
    edits: list[Edit] = []
    held = np.array(path.start_mm[targets.first])
    for move in range(targets.first, targets.last + 1):
        delta = targets.ends.get(move, np.zeros(2))
        wanted = path.end_mm[move] + np.array([delta[0], 0.0, delta[1]])
        if move in targets.arcs:
            found, held = _arc(program, path, move, _from_to(targets.arcs[move], held, wanted), held)
            edits += found
        elif (
            path.motion[move] == Motion.RAPID
            and not _carries(program, path, move, wanted, held)
            and not _is_led_in(program, path, move)
        ):
            # The rapid stays; a feed move goes on from its end to the displaced start of the contour
            block, state = int(path.block[move]), path.coordinate_state(move)
            _require_both_named(program, path, move)
            from_mm = np.where(path.word[move] < 0, held, path.end_mm[move]) if state.incremental else np.zeros(3)
            words = [
                coordinate_text(program.dialect, letter, float(wanted[axis] - from_mm[axis]), state)
                for axis, letter in AXES
            ]
            feed = [word.text for word in program.block(int(path.block[move + 1])).words if word.letter == "F"]
            edits.append(insert_blocks_after(program, block, [" ".join(["G01", *words, *feed])]))
            held = wanted
        else:
            found, held = _line(program, path, move, wanted, held)
            edits += found
    return [*edits, *_back(program, path, targets.last + 1, held)]


def _back(program: Program, path: ToolPath, first: int, held: Array) -> list[Edit]:
    """Edits of increments behind the contour, which end where they did; one of nothing (G28 U0) stays."""
    edits: list[Edit] = []
    for move in range(first, len(path)):
        if np.allclose(held, path.start_mm[move], rtol=0.0, atol=SAME_MM):
            break
        stands = path.start_mm[move] == path.end_mm[move]
        if path.motion[move] == Motion.ARC:
            # NC-EDIT for an arc that begins where something displaced ends: its circle would go elsewhere, or not fit.
            raise Code.NC_EDIT.refusal(
                "this arc begins where the displaced contour ends: its circle would not stay",
                hint="leave the contour by a straight move",
                place=program.place(program.block(int(path.block[move])).start),
            )
        increments = np.array([k >= 0 and _is_increment(program, path, move, int(k)) for k in path.word[move]])
        stays = (path.word[move] < 0) | (increments & stands)
        wanted = path.end_mm[move] + np.where(stays, held - path.start_mm[move], 0.0)
        if np.any(increments & ~stands):
            found, held = _line(program, path, move, wanted, held)
            edits += found
        else:
            held = wanted
    return edits


def _is_increment(program: Program, path: ToolPath, move: int, word: int) -> bool:
    """Returns whether a word gives a distance of its axis, not a position."""
    own = program.word(word).increment
    return bool(path.incremental[move]) if own is None else own


def _carries(program: Program, path: ToolPath, move: int, wanted: Array, held: Array) -> bool:
    """Returns whether a block goes where it shall by itself: named axes as ever, others as it is held."""
    own = np.where(path.word[move] < 0, held, path.end_mm[move])
    step_mm = program.dialect.step_mm(bool(path.inch[move]))
    return bool(np.all(np.abs(own - wanted) <= step_mm) or np.all(path.end_mm[move] == wanted))


def led_in(program: Program, path: ToolPath, targets: Displacements) -> Displacements:
    """Returns the targets with the rapid onto a contour under G41 or G42, or one that is roughed too, ending a little
    earlier.

    By as much as it is displaced across the contour's first line, so that it comes no nearer to what lies ahead. Not
    where its block names one axis alone, as the first block of a contour of G71 does, which must not name the other.
    """
    move = targets.first
    if path.motion[move] != Motion.RAPID or not _is_led_in(program, path, move) or path.motion[move + 1] == Motion.ARC:
        return targets
    if np.any(path.word[move][[0, 2]] < 0):
        return targets
    delta, ahead = targets.ends[move], (path.end_mm - path.start_mm)[move + 1, [0, 2]]
    ahead = ahead / np.linalg.norm(ahead)
    across = abs(float(ahead[1] * delta[0] - ahead[0] * delta[1]))
    return Displacements({**targets.ends, move: delta - across * ahead}, targets.arcs)


def _is_led_in(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether the cut after a rapid is a contour that the control keeps the nose off, or one that roughing
    reads too.

    To that a feed move would be a piece more, which goes down before it comes out: G71 refuses it.
    """
    if path.compensation[move + 1] != NO_COMPENSATION:
        return True
    cycle = finishing_cycle(program, path, move)
    return cycle is not None and cycle.by == "numbers" and bool(roughed_by(program, cycle))


def _line(program: Program, path: ToolPath, move: int, wanted: Array, held: Array) -> tuple[list[Edit], Array]:
    """Edits of one move that keeps its shape, and where the control stands after it, as it is written."""
    edits: list[Edit] = []
    state = path.coordinate_state(move)
    holds = np.array(wanted)
    for axis, letter in AXES:
        word = int(path.word[move, axis])
        if word >= 0:
            increment = _is_increment(program, path, move, word)
            from_mm = float(held[axis]) if increment else 0.0
            given = float(path.end_mm[move, axis] - (path.start_mm[move, axis] if increment else 0.0))
            edit, by_mm = moved_word(program, program.word(word), letter, float(wanted[axis] - from_mm - given), state)
            edits += [edit] if edit is not None else []
            holds[axis] = from_mm + given + by_mm
        elif _differ(program, letter, float(wanted[axis]), float(held[axis]), state):
            require_named(program, path, move, axis, letter)
            from_mm = float(held[axis]) if state.incremental else 0.0
            value_mm = float(wanted[axis]) - from_mm
            edits.append(insert_word(program, int(path.block[move]), letter, value_mm, state))
            holds[axis] = from_mm + rounded_mm(program.dialect, letter, value_mm, state)
        else:
            holds[axis] = held[axis]
    return edits, holds


def _differ(program: Program, letter: str, wanted_mm: float, held_mm: float, state: CoordinateState) -> bool:
    """Returns whether two positions are written as different numbers, and not for their rounding alone."""
    texts = {coordinate_text(program.dialect, letter, value_mm, state) for value_mm in (wanted_mm, held_mm)}
    return len(texts) > 1 and abs(wanted_mm - held_mm) > program.dialect.step(state.inch) * state.unit_mm(letter) / 2


def _require_both_named(program: Program, path: ToolPath, move: int) -> None:
    for axis, letter in AXES:
        require_named(program, path, move, axis, letter)


def _from_to(replacement: Replacement, held: Array, wanted: Array) -> Replacement:
    """Returns these moves from where the control stands to the point that the following blocks inherit, to the last
    digit.

    Where tangent features join, paths that are rounded cross up to some hundredths before or behind it: the first and
    the last arc then keep their radius, not their centre.
    """
    start, end = ((float(at[0]), float(at[2])) for at in (held, wanted))
    first, *others = replacement.moves
    if math.dist(start, first.start_mm) > SLID_MM:
        first = between(first, start, first.end_mm)
    *others, last = (first, *others)
    last = between(last, last.start_mm, end) if math.dist(end, last.end_mm) > SLID_MM else replace(last, end_mm=end)
    return Replacement(replacement.move, (*others, last))


def _arc(
    program: Program, path: ToolPath, move: int, replacement: Replacement, held: Array
) -> tuple[list[Edit], Array]:
    """Returns the arc's block replaced by new moves, and where the control stands after them."""
    _require_both_named(program, path, move)
    block = program.block(int(path.block[move]))
    style = style_of(program, block, path.coordinate_state(move))
    at = (float(held[0]), float(held[2])) if style.state.incremental else replacement.moves[0].start_mm
    texts = blocks_for(replacement.moves, at, block, style)
    if len(texts) > 1 and path.feed_mode[move] == INVERSE_TIME:
        raise Code.NC_EDIT.refusal(
            "an arc whose time is given (G93) would have to become several",
            hint="program the feed in mm/min (G94) or mm/rev (G95) where the contour is cut",
            place=program.place(block.data[0].start),
        )
    edits = [replace_block(program, block.index, texts)]
    follower = _inherits_motion(program, path, move)
    if follower is not None:
        source = next((word.text for word in block.words if is_motion(word)), style.motion(replacement.moves[-1]))
        edits.append(Edit(follower, follower, source + " "))
    for piece in style.allowed(replacement.moves):
        at = style.rounded(piece.end_mm, at)
    return edits, np.array([at[0], path.end_mm[move, 1], at[1]])


def _inherits_motion(program: Program, path: ToolPath, move: int) -> int | None:
    """Returns where to write a G word into the block of the next arc, which has none and would inherit one."""
    if move + 1 >= len(path) or path.motion[move + 1] != Motion.ARC:
        return None
    block = program.block(int(path.block[move + 1]))
    return None if any(is_motion(word) for word in block.data) else block.data[0].start
