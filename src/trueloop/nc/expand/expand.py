"""Contours programmed with less than every point, written out: what a control computes itself, as explicit blocks.

A corner (`,R` `,C`, RND, CHF …) becomes a line or an arc of its own, after a block that ends where it begins; a line by
its angle or about a pole gets its end; an arc by an angle, a point, a pole or the move before its radius or its centre;
a spline becomes the chords that are cut of it; a loop of which every run cuts another move the moves that it makes.
The tool's path stays: the result is run and compared before anybody sees it.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.nc.edit.changes import (
    ANGLES,
    ENDS,
    EVERY_CORNER,
    asks_every_corner,
    composed,
    is_made,
    is_shaped,
    is_wordless,
    otherwise,
    shaping_words,
)
from trueloop.nc.edit.edit import Edit, apply_edits, coordinate_text, line_ending, number, number_said, word_with
from trueloop.nc.expand.block import (
    OUT,
    chords_of_one,
    circle_words,
    feed_word,
    g_code,
    g_digits,
    is_about_pole,
    is_place,
    klartext_name,
    klartext_turn,
    makes_spline,
    motion_word,
    pole_block,
    refusal,
    require_writable,
    rewritten,
    spline_blocks,
    without_spline,
)
from trueloop.nc.expand.loops import loops_written_out
from trueloop.nc.program.along import PLANE_AXES, points_along
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import CoordinateState, Motion, ToolPath
from trueloop.nc.program.understood import NOT_UNDERSTOOD
from trueloop.units import UM_PER_MM

AXES: Final = "XYZ"
CENTRES: Final = "IJK"
_SAME_MM: Final = 1e-7


class Explicit:
    """The edits that write moves out, by block; gathered visit by visit, in the order of cutting.

    Held between visits: the last move written out, where the written program has the tool after it, the motion code
    and the feed in force there.
    """

    def __init__(self, program: Program, path: ToolPath) -> None:
        self.program, self.path = program, path
        self.edits: dict[int, list[Edit]] = {}
        self._digits = g_digits(program)
        self._klartext = program.dialect.klartext
        self._last, self._end, self._code, self._feed = -1, np.zeros(3), "", math.nan

    def write(self, moves: Sequence[int]) -> None:
        """Writes out the moves that one run of a block makes: its own, and the corner after it."""
        block = self.program.block(int(self.path.block[moves[0]]))
        if self._last != moves[0] - 1:
            self._begin(moves[0], block)
        require_writable(self.program, self.path, block, moves)
        if is_place(self.program, self.path, moves[0]):
            self._place(moves[0], block)
            return
        if makes_spline(self.program, self.path, moves[0]):
            self._spline(moves, block)
            return
        changed: dict[int, str] = {}
        new: list[str] = []
        own = [k for k in moves if not is_made(self.path, k)]
        for k in own:
            self._own(k, block, changed, new)
        more = [self._corner(k) for k in moves[len(own) :]]
        if not own:  # a corner with a block to itself
            changed |= {word.index: OUT for word in block.data if word.index in self.path.corner_words}
            new, more = more, []
        self._last = moves[-1]
        self._keep(block, rewritten(self.program, block, self._without_modes(block, changed), new, more))

    def _spline(self, moves: Sequence[int], block: Block) -> None:
        """The chords of a spline in place of what gave it; its feed stays where it is."""
        self._code, self._feed = "", float(self.path.feed[moves[0]])
        texts = [self._corner(k) for k in moves]
        self._last = moves[-1]
        for other in spline_blocks(self.program, block):
            changed, own = without_spline(self.program, other), other.index == block.index
            new, more = (texts[:1], texts[1:]) if own else ((), ())
            self._keep(other, rewritten(self.program, other, changed, new, more))

    def _place(self, move: int, block: Block) -> None:
        """The place of a hole, where the words of the cycle stay; the code that they are polar goes."""
        changed = {word.index: OUT for word in shaping_words(self.program, self.path, move)}
        state, end, new = self.path.coordinate_state(move), np.array(self._end), list[str]()
        for axis in _across(self.path, move):
            target, held = float(self.path.end_mm[move, axis]), float(self._end[axis])
            end[axis], text = _written(self.program.dialect, AXES[axis], target, held, state)
            new.append(text)
        self._end, self._last = end, move
        self._keep(block, rewritten(self.program, block, self._without_modes(block, changed), new, ()))

    def _without_modes(self, block: Block, changed: dict[int, str]) -> dict[int, str]:
        """The changed words, and a code left out by which words of further blocks would be polar (G16)."""
        return changed | {word.index: OUT for word in block.data if self.program.core.meaning(word.index) == _POLAR}

    def end_modes(self, letters: str) -> None:
        """Takes RNDM, or the code of polar words, out of a program whose moves that hang on them are all written out.
        Raises NC-EDIT beside blocks with words of these letters that are not run.
        """
        for block in self.program.blocks:
            values = [word for word in block.data if word.kind in ("number", "expression")]
            if block.index not in self.path.block and any(word.letter in letters for word in values):
                hint = "write RND into the blocks that are to end in a corner, and positions in place of polar ones"
                raise refusal(self.program, block, "RNDM or G16 may be in force here, and it is not run", hint)
            out = {word.index: OUT for word in values if word.letter == EVERY_CORNER}
            out = self._without_modes(block, out)
            if out and block.index not in self.edits:
                self.edits[block.index] = rewritten(self.program, block, out, (), ())

    def _begin(self, move: int, block: Block) -> None:
        """Reads the state in force before a move, if no move before it was written out."""
        path = self.path
        self._end, self._feed = path.start_mm[move] + self._carried(move), float(path.feed[move])
        tangent = path.motion[move] == Motion.ARC and not any(w.letter in "IJKRapq" for w in block.data)
        self._code = "" if tangent else g_code(path, move, self._digits)

    def _carried(self, move: int) -> Array:
        """How far rounding holds the tool off where a move starts: increments since the last one written keep it."""
        carried, between = np.zeros(3), range(self._last + 1, move)
        for axis in range(3) if self._last >= 0 else ():
            words = [(int(self.path.word[k, axis]), bool(self.path.incremental[k])) for k in between]
            if all(_is_increment(self.program.word(word), mode) for word, mode in words if word >= 0):
                carried[axis] = self._end[axis] - self.path.end_mm[self._last, axis]
        return carried

    def _own(self, move: int, block: Block, changed: dict[int, str], new: list[str]) -> None:
        """The move that the block's words give."""
        changed |= {word.index: OUT for word in shaping_words(self.program, self.path, move)}
        end = np.array([self._coordinate(move, axis, changed, new) for axis in range(3)])
        if self.path.motion[move] == Motion.ARC:
            self._circle(move, block, end, changed, new)
        self._motion(move, block, changed, new)
        if self.path.motion[move] != Motion.RAPID:
            if not any(word.letter == "F" for word in block.data) and self._feed_changes(move):
                new.append(feed_word(self.program, self.path, move))
            self._feed = float(self.path.feed[move])
        self._end = end

    def _coordinate(self, move: int, axis: int, changed: dict[int, str], new: list[str]) -> float:
        """One coordinate of the end, where the program then has it."""
        path, letter = self.path, AXES[axis]
        index, target, held = int(path.word[move, axis]), float(path.end_mm[move, axis]), float(self._end[axis])
        state, dialect = path.coordinate_state(move), self.program.dialect
        written = _written(dialect, letter, target, held, state)
        if index < 0 and (target == held or written == _written(dialect, letter, held, held, state)):
            return held
        word = self.program.word(index) if index >= 0 else None
        if word is None or word.letter not in ENDS:
            new.append(written[1])
            return written[0]
        start = float(path.start_mm[move, axis])
        increment = _is_increment(word, state.incremental)
        said = number_said(word) * state.unit_mm(letter, increment) + (start if increment else 0.0)
        if math.isnan(said) or abs(said - target) <= _SAME_MM:
            return held + target - start if increment else target
        plain = word.kind == "number" and word.letter == letter and increment == state.incremental
        value = target - held if increment else target
        changed[index] = word_with(word, value, dialect, state) if plain else written[1]
        return written[0]

    def _circle(self, move: int, block: Block, end: Array, changed: dict[int, str], new: list[str]) -> None:
        """Radius or centre of an arc; `self._end` is where it starts."""
        path, state = self.path, self.path.coordinate_state(move)
        given = {word.letter: word for word in block.data if word.kind in ("number", "expression")}
        if "R" in given:
            if given["R"].value < 0.0 and abs(path.sweep_rad[move]) < math.pi:
                changed[given["R"].index] = word_with(
                    given["R"], float(path.programmed_radius_mm[move]), self.program.dialect, state
                )
            return
        axes = PLANE_AXES[int(path.plane[move])]
        if not any(CENTRES[axis] in given for axis in axes):
            self._new_circle(move, block, end, changed, new)
            return
        for axis in axes:
            letter, centre = CENTRES[axis], float(path.centre_mm[move, axis])
            value, word = centre - float(self._end[axis]), given.get(letter)
            said = number_said(word) * state.unit_mm(letter) if word is not None else 0.0
            if (word is not None and word.increment is False) or abs(said - value) <= _SAME_MM:
                continue
            text = coordinate_text(self.program.dialect, letter, value, state)
            if word is None:
                new.append(text)
            else:
                plain = word.kind == "number"
                changed[word.index] = word_with(word, value, self.program.dialect, state) if plain else text

    def _new_circle(self, move: int, block: Block, end: Array, changed: dict[int, str], new: list[str]) -> None:
        """The circle of an arc that has neither radius nor centre; in Klartext a wide one is about a CC before it."""
        if not self._klartext:
            new.append(circle_words(self.program, self.path, move, self._end, end))
            return
        word = motion_word(self.program, block)
        if word is None or (word.text.upper() == "CP" and is_about_pole(self.path, move)):
            return
        if is_about_pole(self.path, move):
            changed[word.index] = f"{pole_block(self.program, self.path, move)}{line_ending(self.program)}C"
        else:
            new.append(circle_words(self.program, self.path, move, self._end, end))
        if not any(word.text.upper().startswith("DR") for word in block.data):
            new.append(klartext_turn(self.path, move))

    def _motion(self, move: int, block: Block, changed: dict[int, str], new: list[str]) -> None:
        """The word that says how the block moves."""
        word = motion_word(self.program, block)
        if self._klartext:
            if word is not None and word.text.upper() != (name := klartext_name(self.path, move, block, new)):
                changed.setdefault(word.index, name)
            return
        code = g_code(self.path, move, self._digits)
        if word is not None and word.kind == "name":
            changed[word.index] = code
        elif word is None and code and code != self._code:
            first = block.data[0]
            changed[first.index] = " ".join(filter(None, [code, changed.get(first.index, first.text)]))
        self._code = code

    def _corner(self, move: int) -> str:
        """A corner as a move of its own."""
        path, dialect, state = self.path, self.program.dialect, self.path.coordinate_state(move)
        axes = _across(path, move)
        end = np.array(self._end)
        words = []
        for axis in axes:
            target, held = float(path.end_mm[move, axis]), float(self._end[axis])
            end[axis], text = _written(dialect, AXES[axis], target, held, state)
            words.append(text)
        arc = path.motion[move] == Motion.ARC
        code = g_code(path, move, self._digits)
        if self._klartext:
            pole = [pole_block(self.program, path, move), "C"] if arc and is_about_pole(path, move) else []
            code = line_ending(self.program).join(pole) or ("CR" if arc else "L")
        if arc:
            words += [] if code.endswith("C") else [circle_words(self.program, path, move, self._end, end)]
            words += [klartext_turn(path, move)] if self._klartext else []
        if code != self._code or self._klartext:
            words.insert(0, code)
        if self._feed_changes(move) and not self._klartext:
            words.append(feed_word(self.program, path, move))
        self._end, self._code, self._feed = end, code, float(path.feed[move])
        return " ".join(words)

    def _feed_changes(self, move: int) -> bool:
        return bool(self.path.feed[move] != self._feed and not math.isnan(self.path.feed[move]))

    def _keep(self, block: Block, edits: list[Edit]) -> None:
        if self.edits.setdefault(block.index, edits) != edits:
            raise refusal(
                self.program, block, "it runs several times to different places", "write the loop or calls out"
            )


def _across(path: ToolPath, move: int) -> list[int]:
    """Returns the axes of a move's plane."""
    return sorted(PLANE_AXES[int(path.plane[move])])


def _is_increment(word: Word, in_force: bool) -> bool:
    """Returns whether a word says how far its axis goes."""
    return in_force if word.increment is None else word.increment


def _written(dialect: Dialect, letter: str, target: float, held: float, state: CoordinateState) -> tuple[float, str]:
    """Where a coordinate of a move from `held` then is, and its word: an increment where those are in force, mm."""
    origin = held if state.incremental else 0.0
    text, value_mm = number(dialect, letter, target - origin, state)
    return origin + value_mm, letter + text


_POLAR: Final = "Polar(true)"
SLACK_MM = 1e-6
"""Runner and program may differ by this beside rounding."""
ARC_STEPS = 2.0
"""The steps of the control's resolution that the middle of an arc may move: half a step an axis at either end."""


@dataclass(frozen=True)
class WrittenOut:
    """A program with explicit blocks, its path, and the edits of the source that made it."""

    program: Program
    path: ToolPath
    edits: tuple[Edit, ...]

    @contextmanager
    def in_lines_of(self, source: Program) -> Iterator[None]:
        """Refusals from inside that name a line of the written-out program name that of its source."""
        try:
            yield
        except TrueloopError as error:
            if error.place.line is None or not self.edits:
                raise
            place = replace(error.place, line=self.source_line(source, error.place.line), column=None)
            raise error.code.refusal(
                error.message, hint=error.hint, place=place, override=error.override, values=error.values
            ) from error

    def source_line(self, source: Program, line: int) -> int:
        """Returns the line of the source that a line of the written-out program comes from."""
        added = 0
        for edit in sorted(self.edits, key=lambda edit: edit.start):
            new = edit.text.count("\n")
            at = source.place(edit.start).line or 1
            if line <= at + added:
                break
            if line <= at + added + new:
                return at
            added += new
        return line - added


def written_out(
    program: Program, path: ToolPath, moves: Iterable[int], run: Callable[[Program], ToolPath]
) -> WrittenOut:
    """Writes out those of the moves that other words shape, and those that depend on them.

    path: what `run` makes of the program. Raises NC-EDIT where that cannot be done: beside formulas, in a block
    that is optional or runs several times to different places, and where the result would
    not be the same path.
    """
    chosen = set(moves)
    if loops := loops_written_out(program, path, chosen):
        return _then_the_rest(program, path, loops, chosen, run)
    visits = _visits(program, path, chosen)
    if not visits:
        return WrittenOut(program, path, ())
    explicit = Explicit(program, path)
    _require_cut(program, path, visits)
    modes = {"XYZ": asks_every_corner, "pq": _is_polar_by_mode}
    modes = {of: hangs for of, hangs in modes.items() if any(hangs(program, path, k) for v in visits for k in v)}
    if modes:
        chosen |= {k for k in range(len(path)) if any(hangs(program, path, k) for hangs in modes.values())}
        visits = _visits(program, path, chosen)
    for visit in visits:
        explicit.write(visit)
    if modes:
        explicit.end_modes("".join(modes))
    edits = tuple(edit for block in explicit.edits.values() for edit in block)
    written = program.rewritten(apply_edits(program, edits))
    done = WrittenOut(written, run(written), edits)
    require_same_path(program, path, done)
    return done


def _is_polar_by_mode(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether X and Y of a move are radius and angle by the code of another block (G16)."""
    words = (program.word(int(word)) for word in path.word[move] if word >= 0)
    return any(word.letter in "pq" and word.text[0] in "XxYy" for word in words)


def _then_the_rest(
    program: Program, path: ToolPath, loops: Sequence[Edit], moves: set[int], run: Callable[[Program], ToolPath]
) -> WrittenOut:
    """The program with its loops written out, and then with what else is shaped by other words."""
    straight = program.rewritten(apply_edits(program, loops))
    done = WrittenOut(straight, run(straight), tuple(loops))
    require_same_path(program, path, done)
    more = written_out(straight, done.path, moves, run)
    return WrittenOut(more.program, more.path, tuple(composed(program.source, loops, more.edits)))


def _require_cut(program: Program, path: ToolPath, visits: list[list[int]]) -> None:
    """Refuses corners and angles that are said to be left out of the path: a control may make something of them."""
    lines = {int(path.line[k]) for visit in visits for k in visit}
    for found in path.findings:
        if (found.code, found.severity) == (Code.NC_OPAQUE, Severity.WARNING) and found.place.line in lines:
            raise found.as_error()


def _visits(program: Program, path: ToolPath, moves: set[int]) -> list[list[int]]:
    """The moves to be written out, those that one run of a block makes together.

    A corner goes with the moves on both sides of it, a line that ends where it meets the next one with that, and any
    move with the next, which may take over its motion code.
    """
    inside = {k for k in moves if 0 <= k < len(path)}
    wanted = {k for k in inside if _is_drawn(program, path, k) and (is_made(path, k) or not is_wordless(path, k))}
    wanted |= {k - 1 for k in inside if k > 0 and _hangs_on_next(program, path, k - 1)}
    found = set[int]()
    while wanted:
        k = wanted.pop()
        found.add(k)
        before = is_made(path, k) or (k > 0 and _hangs_on_next(program, path, k - 1))
        # In Klartext each block says its motion; a move after a corner may have to state its feed.
        after = is_made(path, k) or not (program.dialect.klartext or is_place(program, path, k))
        beside = {j for j in (k - 1, k + 1) if 0 <= j < len(path) and (after if j > k else before)} - found
        shaped = {j for j in beside if _is_drawn(program, path, j)}
        wanted |= shaped
        found |= beside - shaped
    return _by_visit(program, path, sorted(found))


def _is_drawn(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move is given with less than its points; those of cycles are left alone."""
    if makes_spline(program, path, move):
        return True
    if move > 0 and path.block[move - 1] == path.block[move] and (path.word[move, _across(path, move)] < 0).all():
        return move in path.corners  # of a cycle, or of a corner
    return move in path.corners if is_made(path, move) else is_shaped(program, path, move)


def _by_visit(program: Program, path: ToolPath, moves: Iterable[int]) -> list[list[int]]:
    visits: list[list[int]] = []
    for k in moves:
        goes_on = visits and visits[-1][-1] == k - 1 and path.block[k] == path.block[k - 1]
        whole = goes_on and len(visits[-1]) == chords_of_one(program, int(path.block[k]))  # the next run of a loop
        if goes_on and not whole and (is_made(path, k) or makes_spline(program, path, k)):
            visits[-1].append(k)
        else:
            visits.append([k])
    return visits


def _hangs_on_next(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move ends as the next one has it: a corner, or a line of which only the angle is known."""
    named = [int(word) for word in path.word[move] if word >= 0]
    waits = len(named) == 2 and named[0] == named[1] and program.word(named[0]).letter in ANGLES
    return move in path.corners or waits


def require_same_path(program: Program, path: ToolPath, after: WrittenOut) -> None:
    """Refuses a written-out program that is not the same path within rounding."""
    other = after.path
    unknown = [finding for finding in after.program.findings if finding.code in NOT_UNDERSTOOD]
    if len(unknown) > sum(finding.code in NOT_UNDERSTOOD for finding in program.findings):
        raise _otherwise(program, path, 0, unknown[0].message)
    every = np.arange(min(len(path), len(other)))
    for wrong, what in otherwise(path, other, (every, every)):
        if np.any(wrong):
            raise _otherwise(program, path, int(np.argmax(wrong)), f"one of its moves {what}")
    if len(path) != len(other):
        raise _otherwise(program, path, len(every) - 1, "its moves would be others")
    off, allowed = _off_mm(program, path, other)
    if np.any(off > allowed):
        k = int(np.argmax(off - allowed))
        raise _otherwise(program, path, k, f"its path would be off by {off[k] * UM_PER_MM:.2f} µm")


def _off_mm(program: Program, path: ToolPath, other: ToolPath) -> tuple[Array, Array]:
    """How far each move's end, and an arc's middle, is off along an axis, and how much of it rounding explains."""
    step_mm = np.array([program.dialect.step_mm(inch) for inch in (False, True)])[path.inch.astype(int)]
    off, allowed = np.max(np.abs(path.end_mm - other.end_mm), axis=1, initial=0.0), step_mm / 2 + SLACK_MM
    arcs = np.flatnonzero(path.motion == Motion.ARC)
    middle = np.full(len(arcs), 0.5)
    bulge = np.max(np.abs(points_along(path, arcs, middle) - points_along(other, arcs, middle)), axis=1, initial=0.0)
    excess = bulge - ARC_STEPS * step_mm[arcs]
    off[arcs] = np.where(excess > 0.0, np.maximum(off[arcs], bulge), off[arcs])
    return off, allowed


def _otherwise(program: Program, path: ToolPath, move: int, what: str) -> TrueloopError:
    return Code.NC_EDIT.refusal(
        f"line {path.line[move]} belongs to a contour that cannot be written out as explicit moves: {what}",
        hint="write its corners, angles and arcs as blocks with ends, and arcs with a radius or a centre",
        place=program.place(program.block(int(path.block[move])).start),
    )
