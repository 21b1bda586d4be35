"""A program that turns rotary axes in its cuts, corrected pose by pose: tip and axis of the tool as programmed.

The wanted pose is that which the machine without errors has at the programmed place; each block ends where the machine
with its errors has it. A cut that leaves it on its way by more than the tolerance becomes several.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal, InvalidOperation
from functools import cached_property
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.domain.option import MapOptions
from trueloop.domain.record import check_uncorrected, mark_of_field, record_id, sha256_of
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.loops.machine.mapped_program import Mapped
from trueloop.machine.correct import ANY_TOOL, HINT, UNKNOWN_WAY_MM, Setup, references_mm, require_way
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.validity import check_state
from trueloop.machine.pose import PoseModel
from trueloop.nc.edit.changes import insert_heading, not_as_intended
from trueloop.nc.edit.edit import (
    Edit,
    apply_edits,
    coordinate_text,
    insert_blocks_after,
    insert_word,
    moved_word,
    number,
)
from trueloop.nc.field import looked_up, require_offsets
from trueloop.nc.five_axis import LETTERS, LINEAR, ROTARY, FiveAxisPath, PoseMove
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import INVERSE_TIME, CoordinateState
from trueloop.units import UM_PER_MM, URAD_PER_RAD

AXIS_TOLERANCE_RAD: Final = 0.5e-6
"""How far the tool may lean from the wanted direction between the ends of a block."""

PIECES: Final = 1000
"""The most blocks that one becomes."""

_SHARES: Final = np.array([0.25, 0.5, 0.75])
_AS_WRITTEN: Final = 1e-9
_UNROUNDED_RAD: Final = 1e-12
_DEGREES: Final = CoordinateState(inch=False, diameter=False)
_TURN: Final = 360.0
_AT_ONCE: Final = 4096
"""Points that are solved at once: the influences of all errors at each are held."""


@dataclass(frozen=True)
class Places:
    """Programmed places: words X, Y, Z, mm, A, B, C, degrees (n, 6), under tool point control or not (n,); the zero of
    the program in the machine for a tool of no length, and the tool point, (n, 3) mm; ways of travel (n, axes).
    """

    words: Array
    tool_point: Flags
    zero_mm: Array
    tool_mm: Array
    ways: Array

    def at(self, rows: Integers | Flags | slice, words: Array | None = None) -> "Places":
        """Returns some of the places, or others with the frames of those."""
        own = self.words[rows] if words is None else words
        return Places(own, self.tool_point[rows], self.zero_mm[rows], self.tool_mm[rows], self.ways[rows])


@dataclass(frozen=True)
class Corrected:
    """Words (n, 6) that give the wanted poses, whether a rotary axis stays since the tool is parallel to it (n,), how
    far the tool then leans from the wanted direction, rad, and how far it misses the tip without correction, mm.
    """

    words: Array
    parallel: Flags
    lean_rad: Array
    error_mm: Array


@dataclass(frozen=True)
class PoseCorrection:
    """The correction of places by a model in a set-up; `turning`: rotary axes of the machine that the program names."""

    model: MachineModel
    setup: Setup
    turning: Collection[str]
    extrapolate: Collection[str] = ()

    @cached_property
    def poses(self) -> PoseModel:
        """Returns the model of poses."""
        return PoseModel(self.model, self.turning)

    def joints(self, places: Places) -> State:
        """Returns where the control takes the axes to: by words of the tip under tool point control."""
        state = self._state(places, places.words[:, :3], places.words)
        upright = self.poses.nominal(self._state(places, np.zeros_like(places.zero_mm), np.zeros_like(places.words)))
        reached = self.poses.reach(state, upright.tip_mm + places.words[:, :3])
        return replace(state, positions=np.where(places.tool_point[:, None], reached, state.positions))

    def words(self, places: Places, state: State) -> Array:
        """Returns the words (n, 6) that take the axes to a state; those of `places` for axes that the machine lacks."""
        order, found = self.model.machine.chain.order, places.words.copy()
        for name in order:
            found[:, LETTERS.index(name)] = state.positions[:, order.index(name)]
        found[:, 3:] = np.where([name in order for name in ROTARY], np.degrees(found[:, 3:]), places.words[:, 3:])
        upright = self.poses.nominal(self._state(places, np.zeros_like(places.zero_mm), np.zeros_like(places.words)))
        tip = self.poses.nominal(state).tip_mm - upright.tip_mm
        axes = found[:, :3] - places.zero_mm + places.tool_mm
        found[:, :3] = np.where(places.tool_point[:, None], tip, axes)
        return found

    def correct(self, places: Places, step_rad: float = _UNROUNDED_RAD) -> Corrected:
        """Returns the words that give the poses of the places."""
        found = [self._correct(places.at(rows), step_rad) for rows in _runs(len(places.words))]
        words, parallel, lean, error = (
            np.concatenate([getattr(part, name) for part in found])
            for name in ("words", "parallel", "lean_rad", "error_mm")
        )
        return Corrected(words, parallel, lean, error)

    def off(self, places: Places, words: Array) -> tuple[Array, Array]:
        """Returns how far from the poses of the places those of other words are: tip, mm, and axis, rad, (n,)."""
        tips, axes = [], []
        for rows in _runs(len(words)):
            wanted = self.poses.nominal(self.joints(places.at(rows)))
            actual = self.poses.actual(self.joints(places.at(rows, words[rows])))
            tips.append(np.linalg.norm(actual.tip_mm - wanted.tip_mm, axis=1))
            axes.append(np.linalg.norm(actual.axis - wanted.axis, axis=1))
        return np.concatenate(tips), np.concatenate(axes)

    def require_reached(self, places: Places, words: Array) -> None:
        """Raises MCH-TRAVEL and MCH-RANGE for words that take an axis further than it goes or the model is known."""
        check_state(self.model, self.joints(replace(places, words=words)), self.extrapolate)

    def require_ways(self, places: Places) -> None:
        """Refuses a place to which an axis may have come from either side, with its backlash there (MCH-FRAME)."""
        chain = self.model.machine.chain
        for name in sorted({term.name.axis for term in self.model.terms if term.both_ways}):
            column = chain.order.index(name)
            unknown = np.flatnonzero(places.ways[:, column] == 0.0)
            if len(unknown):
                state, tips = self.joints(places.at(unknown)), []
                for way in (1.0, -1.0):
                    ways = np.array(state.travel)
                    ways[:, column] = way
                    tips.append(self.poses.actual(replace(state, travel=ways)).tip_mm)
                backlash_mm = float(np.abs(tips[0] - tips[1]).max())
                if backlash_mm > UNKNOWN_WAY_MM:
                    require_way(name, backlash_mm)

    def _correct(self, places: Places, step_rad: float) -> Corrected:
        state = self.joints(places)
        solved = self.poses.solve(self.poses.nominal(state), state, step_rad)
        words = self.words(places, replace(state, positions=solved.positions))
        return Corrected(words, solved.parallel, solved.lean_rad, solved.error_mm)

    def _state(self, places: Places, linear: Array, words: Array) -> State:
        chain = self.model.machine.chain
        given: dict[str, Array | float] = dict(zip(LINEAR, (linear + places.zero_mm - places.tool_mm).T, strict=True))
        given |= dict(zip(ROTARY, np.radians(words[:, 3:]).T, strict=True))
        known = {name: values for name, values in given.items() if name in chain.order}
        return State(chain.positions(known), places.ways, self.setup.signals, places.tool_mm)


def _runs(count: int) -> Iterator[slice]:
    return (slice(first, first + _AT_ONCE) for first in range(0, count, _AT_ONCE))


def places_of(correction: PoseCorrection, moves: Sequence[PoseMove]) -> Places:
    """Returns the ends of moves, with ways of travel not known yet. Raises MCH-FRAME for unknown tools and offsets."""
    work = np.array([move.work_offset for move in moves])
    zero = looked_up(work, correction.setup.work_zero_mm, "work offset", HINT)
    zero += [move.register_mm for move in moves]
    order = correction.model.machine.chain.order
    words = np.array([move.end for move in moves])
    words[:, [3 + ROTARY.index(name) for name in ROTARY if name not in order]] = 0.0
    return Places(
        words=words,
        tool_point=np.array([move.tool_point for move in moves]),
        zero_mm=zero,
        tool_mm=_tools_mm(correction.setup, moves),
        ways=np.zeros((len(moves), len(order))),
    )


def _tools_mm(setup: Setup, moves: Sequence[PoseMove]) -> Array:
    """Returns the tool points (n, 3) from the last axis' frame, by T or by the offset in force in the control's table.

    Raises MCH-FRAME for an unknown one.
    """
    rows = [(row.number, row.length_mm) for row in setup.table or ()]
    lengths = {number: (0.0, 0.0, -mm) for number, mm in rows if number is not None and mm is not None}
    of_table = [move.offset if move.offset in lengths else ANY_TOOL for move in moves]
    numbers = [move.tool if move.tool in setup.tool_mm else at for move, at in zip(moves, of_table, strict=True)]
    if ANY_TOOL in numbers and ANY_TOOL not in setup.tool_mm:
        tool = moves[numbers.index(ANY_TOOL)].tool
        require_offsets(np.array([tool]), np.full((1, 3), np.nan), HINT)
    return looked_up(np.array(numbers), {**lengths, **setup.tool_mm}, "tool", HINT)


def _with_ways(correction: PoseCorrection, places: Places, came: Sequence[Mapping[str, bool]]) -> Places:
    """Returns the places with the way of each axis: by which it goes there, else by which it went last; 0 from a place
    of the machine, `came` of each move, that is not known.
    """
    references = references_mm(correction.model, correction.setup)
    at, order = correction.joints(places).positions, correction.model.machine.chain.order
    ways = np.zeros_like(at)
    for k, place in enumerate(at):
        stayed = np.array([name not in came[k] for name in order])
        known = [references.get(name, np.nan) if came[k].get(name) else np.nan for name in order]
        gone = np.nan_to_num(np.sign(np.round(place - np.where(stayed, at[k - 1], known), 6)))
        ways[k] = np.where(stayed & (gone == 0.0), ways[k - 1], gone)
    return replace(places, ways=ways)


@dataclass(frozen=True)
class _Nodes:
    """The ends of the blocks to write: of which move each is, and its programmed place."""

    move: Integers
    places: Places


def _divided(correction: PoseCorrection, places: Places, splits: Flags, tolerance_mm: float) -> Integers:
    """Returns how many blocks each move becomes, (n,), so that none of those that `splits` leaves the pose."""
    counts = np.ones(len(splits), dtype=np.int64)
    left = np.flatnonzero(splits)
    while len(left):
        nodes = _nodes(places, counts, left, starts=True)
        found = correction.correct(nodes.places)
        begin = np.flatnonzero(nodes.move[:-1] == nodes.move[1:])
        worst = np.zeros(len(splits))
        for share in _SHARES:
            on_way = [(1 - share) * rows[begin] + share * rows[begin + 1] for rows in (nodes.places.words, found.words)]
            tip, lean = correction.off(nodes.places.at(begin + 1, on_way[0]), on_way[1])
            lean = np.where(found.parallel[begin] | found.parallel[begin + 1], 0.0, lean)
            np.maximum.at(worst, nodes.move[begin], np.maximum(tip / tolerance_mm, lean / AXIS_TOLERANCE_RAD))
        left = left[worst[left] > 1.0]
        more = np.ceil(counts[left] * np.clip(1.05 * np.sqrt(worst[left]), 1.1, 32.0)).astype(np.int64)
        counts[left] = np.minimum(np.maximum(more, counts[left] + 1), PIECES)
        left = left[counts[left] < PIECES]
    return counts


def _nodes(places: Places, counts: Integers, moves: Integers, *, starts: bool = False) -> _Nodes:
    """Returns the ends of the pieces of moves, with `starts` the start of each move before them."""
    rows, words = [], []
    for k in moves:
        share = np.arange(0 if starts else 1, counts[k] + 1)[:, None] / counts[k]
        before = places.words[k - 1] if starts or counts[k] > 1 else places.words[k]
        rows.append(np.full(len(share), k))
        words.append(before + share * (places.words[k] - before))
    move = np.concatenate(rows) if rows else np.zeros(0, dtype=np.int64)
    return _Nodes(move, places.at(move, np.concatenate(words) if words else np.zeros((0, 6))))


@dataclass
class _Writing:
    """The edits of a program; `stands` is what the words written so far state, by letter."""

    program: Program
    letters: str
    edits: list[Edit] = field(default_factory=list)
    stands: dict[str, float] = field(default_factory=dict)
    feed_said: str = ""
    written_feed: str = ""
    added: int = 0
    ends: list[list[float]] = field(default_factory=list)

    def leave(self, move: PoseMove) -> None:
        """Notes a move whose words stay as they are."""
        self.stands |= {letter: move.end[LETTERS.index(letter)] for letter in move.words}
        self._end()

    def write(self, move: PoseMove, ends: Array) -> None:
        """Writes the words of a move and the blocks that it becomes besides; `ends` (pieces, 6)."""
        index = move.block.index
        if not move.follows:
            self.stands.clear()  # what stood there is called otherwise now
        for letter in self.letters:
            value, state = float(ends[0][LETTERS.index(letter)]), _state_of(move, letter)
            if (word := move.words.get(letter)) is not None:
                self.stands[letter] = move.end[LETTERS.index(letter)]
                if not self._differs(letter, value, move):
                    continue
                if abs(word.value * state.unit_mm(letter) - self.stands[letter]) > _AS_WRITTEN:  # it counts steps
                    text, self.stands[letter] = number(self.program.dialect, letter, value, state)
                    self.edits.append(Edit(word.value_start, word.end, text))
                else:
                    edit, by = moved_word(self.program, word, letter, value - self.stands[letter], state)
                    self.edits += [edit] if edit else []
                    self.stands[letter] += by
            elif self._differs(letter, value, move):
                self.edits.append(insert_word(self.program, index, letter, value, state))
                self.stands[letter] = value
        feed = self._feed(move, len(ends))
        self._end()
        texts = []
        for place in ends[1:]:
            values = {letter: float(place[LETTERS.index(letter)]) for letter in self.letters}
            words = [
                coordinate_text(self.program.dialect, letter, value, _state_of(move, letter))
                for letter, value in values.items()
                if self._differs(letter, value, move)
            ]
            self.stands |= values
            texts.append(" ".join(["L"] * self.program.dialect.klartext + words + feed))
            self._end()
        if texts:
            self.edits.append(insert_blocks_after(self.program, index, texts))
            self.added += len(texts)

    def _end(self) -> None:
        self.ends.append([self.stands.get(letter, np.nan) for letter in LETTERS])

    def _differs(self, letter: str, value: float, move: PoseMove) -> bool:
        state = _state_of(move, letter)
        half = 0.5 * self.program.dialect.step(state.inch) * state.unit_mm(letter)
        return not abs(value - self.stands.get(letter, np.nan)) <= half

    def _feed(self, move: PoseMove, pieces: int) -> list[str]:
        """Writes the inverse time of a block that becomes several, each of which takes its share; its word for them."""
        if move.feed_mode != INVERSE_TIME or move.rapid:
            return []
        word = move.feed_word
        if word is not None:
            self.feed_said = word.text[word.value_start - word.start :].strip()
        text = self.written_feed
        if pieces > 1 or (word is None and text != f"F{self.feed_said}"):
            try:
                share = f"{Decimal(self.feed_said) * pieces:f}"
            except InvalidOperation:
                raise Code.NC_EDIT.refusal(
                    f"the block is divided into {pieces}, and its inverse-time feed is an expression",
                    hint="write F as a number",
                    place=self.program.place(move.block.start),
                ) from None
            text = f"F{share}{'.' * ('.' in self.feed_said and '.' not in share)}"
            at, inserted = self.program.core.inserted(move.block.index, text)
            self.edits.append(Edit(word.start, word.end, text) if word is not None else Edit(at, at, inserted))
        self.written_feed = text if pieces > 1 else f"F{self.feed_said}"
        return [text]


def _state_of(move: PoseMove, letter: str) -> CoordinateState:
    return _DEGREES if letter in ROTARY else move.state


def correct_five_axis(
    path: FiveAxisPath,
    correction: PoseCorrection,
    identity: Mapping[str, object],
    options: MapOptions,
    parameters: Mapping[str, float],
) -> tuple[bytes, Mapped]:
    """Returns the program with every known pose corrected, and what was done; `identity` names model and set-up.

    Rapid moves stay as they are until all axes stand at known places. Raises CMP-TWICE, CMP-SIZE, CMP-READ-BACK,
    MCH-FRAME (a cut from or to a place that is not known), MCH-TRAVEL, MCH-RANGE, NC-EDIT.
    """
    program, moves = path.program, path.moves
    check_uncorrected(program.source)
    axes = [name for name in correction.model.machine.chain.order if name in ROTARY]
    known = np.array([_is_known(program, move, axes) for move in moves])
    own = np.flatnonzero(known)
    rows = [moves[k] for k in own]
    follows = np.array([moves[k].follows and k > 0 and known[k - 1] for k in own], dtype=np.bool_)
    cuts = np.array([not move.rapid for move in rows], dtype=np.bool_)
    came = [_since(moves, known, index) for index in own.tolist()]
    places = _with_ways(correction, places_of(correction, rows), came)
    correction.require_ways(places.at(cuts))
    turned = np.abs(np.diff(places.words[:, 3:], axis=0, prepend=places.words[:1, 3:])).max(axis=1, initial=0.0)
    around = turned > 0.5 * _TURN
    counts = _divided(correction, places, cuts & follows & ~around, options.tolerance_mm)
    for move, pieces in zip(rows, counts.tolist(), strict=True):
        _require_divisible(program, move, pieces)
    nodes = _nodes(places, counts, np.arange(len(rows)))
    step_rad = math.radians(program.dialect.step(False))
    done = correction.correct(nodes.places, step_rad)
    lines = np.array([move.block.line for move in rows], dtype=np.int64)[nodes.move]
    _require_small(program, done, lines, options.limit_mm)
    _require_reached(program, correction, nodes.places, done, lines)
    writing = _Writing(program, LINEAR + "".join(sorted(correction.turning)))
    ends = dict(zip(own.tolist(), np.split(done.words, np.cumsum(counts)[:-1]), strict=True)) if len(own) else {}
    for index, move in enumerate(moves):
        if index in ends:
            writing.write(move, ends[index])
        else:
            writing.leave(move)
    digest = sha256_of(program.source)
    record = record_id({"program": digest}, {"field": dict(identity), "parameters": dict(parameters), **vars(options)})
    mark = program.dialect.comment(mark_of_field(record, digest))
    written = apply_edits(program, [insert_heading(program, [mark]), *writing.edits])
    _require_as_intended(path.read_again(written), writing)
    x, y, z = np.abs(done.words - nodes.places.words)[:, :3].max(axis=0, initial=0.0).tolist()
    return written, Mapped(
        record=record,
        dialect=program.dialect.name,
        source_sha256=digest,
        blocks=program.block_count,
        moves=len(moves),
        edits=len(writing.edits),
        added_blocks=writing.added,
        largest_mm=(x, y, z),
        not_run=len(path.not_run),
        first_not_run_line=min(path.not_run, default=0),
        unit=path.unit,
        notes=(
            *_notes(correction, nodes.places, done, lines, cuts[nodes.move], step_rad),
            *_around(rows, cuts & around),
        ),
    )


def _since(moves: Sequence[PoseMove], known: Flags, index: int) -> Mapping[str, bool]:
    """Returns which axes were at places of the machine since the last move before that one that is known."""
    came = dict(moves[index].came)
    while index > 0 and not known[index - 1]:
        index -= 1
        came = {**moves[index].came, **came}
    return came


def _is_known(program: Program, move: PoseMove, axes: Sequence[str]) -> bool:
    """Returns whether all axes are at known places after a move. Raises MCH-FRAME for a cut where one is not."""
    at = dict(zip(LETTERS, move.end, strict=True))
    unknown = [name for name in (*LINEAR, *axes) if not np.isfinite(at[name])]
    if not unknown or move.rapid:
        return not unknown
    name = unknown[0]
    never = name in ROTARY and np.isnan(at[name])
    raise Code.MCH_FRAME.refusal(
        f"{name} is at a place that is not known in a cut: no position names it before, or none since a reference "
        "point, a change of tool or a switch of tool point control",
        hint=f"state where it stands until the program positions it, in degrees: --at {name}=0"
        if never
        else f"position {name} by a number, absolute (G90), before the cut",
        place=program.place(move.block.start),
    )


def _require_divisible(program: Program, move: PoseMove, pieces: int) -> None:
    if pieces > 1 and not move.divisible:
        raise Code.NC_EDIT.refusal(
            f"the block would become {pieces}, and does more than move: what comes first is not known",
            hint="write its other functions in a block of their own, or allow more: --tolerance-um",
            place=program.place(move.block.start),
        )


def _require_small(program: Program, done: Corrected, lines: Integers, limit_mm: float) -> None:
    size = float(done.error_mm.max(initial=0.0))
    if size > limit_mm:
        line = int(lines[int(done.error_mm.argmax())])
        raise Code.CMP_SIZE.refusal(
            f"the machine's error of {UM_PER_MM * size:.1f} µm is larger than {UM_PER_MM * limit_mm:g} µm",
            hint="check the unit and the sign of the model, and where the program is in the machine",
            place=program.place(program.block(line - 1).start),
            override=f"--limit-um {int(np.ceil(UM_PER_MM * size))}",
            values={"size_um": UM_PER_MM * size, "limit_um": UM_PER_MM * limit_mm},
        )


def _require_reached(
    program: Program, correction: PoseCorrection, places: Places, done: Corrected, lines: Integers
) -> None:
    """Raises what the model refuses, for the first block that it refuses."""
    try:
        correction.require_reached(places, done.words)
    except TrueloopError:
        for k, line in enumerate(lines.tolist()):
            with in_file(program.file or "program", line):
                correction.require_reached(places.at(np.array([k])), done.words[[k]])
        raise


def _require_as_intended(again: FiveAxisPath, writing: _Writing) -> None:
    """Raises CMP-READ-BACK where the path of the written program is not the intended one."""
    ends = np.array([move.end for move in again.moves]).reshape(-1, len(LETTERS))
    wanted = np.array(writing.ends).reshape(-1, len(LETTERS))
    if len(ends) != len(wanted):
        raise not_as_intended(f"the written program has {len(ends)} moves instead of {len(wanted)}")
    checked = np.array([letter in writing.letters for letter in LETTERS])
    compared = np.isfinite(ends) & np.isfinite(wanted) & checked
    off = np.where(compared, np.abs(ends - wanted), 0.0).max(axis=1, initial=0.0).tolist()
    for move, far in zip(again.moves, off, strict=True):
        if far > writing.program.dialect.step_mm(move.state.inch):
            raise not_as_intended(f"line {move.block.line} of the written program is {far:.6f} mm or ° from its place")


def _notes(
    correction: PoseCorrection, places: Places, done: Corrected, lines: Integers, cuts: Flags, step_rad: float
) -> Iterator[str]:
    """Yields what the correction leaves or changes that the user has to know."""
    chain, ends = correction.model.machine.chain, cuts | np.append(cuts[1:], False)
    unnamed = " ".join(name for name in chain.order if name in ROTARY and name not in correction.turning)
    by_axes = ends & ~done.parallel
    beyond = done.lean_rad > AXIS_TOLERANCE_RAD + 2.0 * step_rad
    for why, of in (
        ("the tool is within 1° of a rotary axis, which stays where it is", ends & done.parallel),
        (f"the program names no word of {unnamed}, which stays", by_axes & bool(unnamed)),
        ("no rotary axis turns the tool where it has to", by_axes & beyond & (not unnamed)),
    ):
        if of.any():
            worst = int(np.where(of, done.lean_rad, -1.0).argmax())
            yield (
                f"at {int(of.sum())} of {int(ends.sum())} ends of cuts {why}: the tool leans from the programmed "
                f"direction by up to {URAD_PER_RAD * done.lean_rad[worst]:.1f} µrad, in line {lines[worst]}"
            )
    for name in sorted(correction.turning):
        low, high = chain.axis(name).travel
        column = LETTERS.index(name)
        before, after = places.words[:, column], done.words[:, column]
        passes = np.flatnonzero(np.floor(before / _TURN) != np.floor(after / _TURN))
        if high - low >= 2 * np.pi and len(passes):
            k = int(passes[0])
            yield (
                f"{name} passes a full turn by its correction in {len(passes)} blocks, first in line {lines[k]}: "
                f"{name}{before[k]:g} becomes {name}{after[k]:.4f}; see that the control takes it for the near place"
            )


def _around(rows: Sequence[PoseMove], of: Flags) -> Iterator[str]:
    if of.any():
        yield (
            f"{int(of.sum())} cuts turn an axis by more than half a turn, first line "
            f"{rows[int(of.argmax())].block.line}: their ends are corrected, not their ways, which the control chooses"
        )
