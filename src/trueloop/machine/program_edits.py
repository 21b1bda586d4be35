"""A machine model's correction written into a program, word by word: COMP_MTG added to every programmed position."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.chain import AxisKind
from trueloop.machine.commanded_path import CommandedPath
from trueloop.machine.displaced_moves import PLANES, DisplacedMove, displaced_moves
from trueloop.machine.pieces import Piece
from trueloop.machine.point_program import NO_POSITIONS
from trueloop.nc.edit import Edit, coordinate_text, displace_word, insert_blocks_after, insert_word
from trueloop.nc.program import Program, Word
from trueloop.nc.shape_words import require_own_shape
from trueloop.nc.tool_path import CoordinateState, Motion

AXES: Final = "XYZ"
CENTRES: Final = "IJK"
CYCLES: Final = frozenset(range(73, 90)) - {80}
"""G73 to G89: canned cycles, whose own moves are not in a tool path."""
HALF: Final = 0.5
"""A correction that differs by less than half a resolution is the same number on the control."""


def compensation_edits(program: Program, placed: CommandedPath, tolerance_mm: float) -> list[Edit]:
    """Edits that make the program follow p − E(p) within `tolerance_mm`.

    Words keep their style, expressions get a term; a coordinate that a block inherits is written in when its correction
    changes; a move that one piece cannot follow becomes several blocks. Probing moves, and blocks that set coordinate
    systems or stand in machine coordinates, stay. Raises MCH-PROGRAM for coordinates that come from no word
    (a cycle's) and for blocks run several times that would need several corrections.
    """
    _check_frames_are_followed(program)
    _check_rotary_axes_stand(program, placed)
    moves = _live_moves(program, placed)
    require_own_shape(program, placed.path, moves.tolist(), absolute_centres=False)
    writer = _Writer(program, placed, tolerance_mm)
    for displaced in displaced_moves(placed, moves, tolerance_mm):
        writer.write(displaced)
    return [edit for edits in writer.edits.values() for edit in edits]


def _check_frames_are_followed(program: Program) -> None:
    """SUPA, M91, TRANS and datum shifts are no G codes: what stands in machine coordinates cannot be told here yet."""
    if program.dialect.formulas:
        raise TrueloopError(
            Code.MCH_PROGRAM,
            f"programs of the dialect {program.dialect.name} are not corrected by a machine model: "
            "frames and positions look alike",
            hint="load a compensation table into the control (`trueloop machine export`), or post for another control",
            place=program.place(0),
        )


def _check_rotary_axes_stand(program: Program, placed: CommandedPath) -> None:
    """A word that turns a rotary axis would change what every later position needs."""
    rotary = {axis.name for axis in placed.model.machine.chain.axes if axis.kind is AxisKind.ROTARY}
    for block in program.blocks if rotary else ():
        for word in block.words:
            if word.letter in rotary:
                raise TrueloopError(
                    Code.MCH_PROGRAM,
                    f"{word.text} in block {block.index + 1} turns a rotary axis, which has to stand still",
                    hint="leave the word out, say with --at where the axis stands, and correct one program a position",
                    place=program.place(word.start),
                )


def _live_moves(program: Program, placed: CommandedPath) -> NDArray[np.intp]:
    path = placed.path
    for finding in path.findings:
        if finding.place.line is not None and _codes(program, finding.place.line - 1) & CYCLES:
            raise _no_word(program, finding.place.line - 1, 1)
    still = {b for b in np.unique(path.block) if _codes(program, int(b)) & NO_POSITIONS}
    live = (path.motion != Motion.PROBE) & ~np.isin(path.block, list(still))
    wordless = (np.abs(path.end_mm - path.start_mm) > 1e-9) & (path.word < 0)
    full = (path.motion == Motion.ARC) & (np.abs(path.end_mm - path.start_mm).max(axis=1) < 1e-9)
    odd = np.flatnonzero(live & wordless.any(axis=1) & ~full)
    if len(odd):
        raise _no_word(program, int(path.block[odd[0]]), len(odd))
    return np.flatnonzero(live)


def _codes(program: Program, block: int) -> set[int]:
    words = program.block(block).words
    return {int(word.value) for word in words if word.letter == "G" and word.kind == "number"}


@dataclass
class _Writer:
    """Edits by block, and the correction that is in force on each axis of the control."""

    program: Program
    placed: CommandedPath
    tolerance_mm: float
    edits: dict[int, list[Edit]] = field(default_factory=dict)
    last: int | None = None
    written_mm: Array = field(default_factory=lambda: np.zeros(3))

    def write(self, displaced: DisplacedMove) -> None:
        """One move: the backlash of axes that turn round, words of its block, then the blocks that follow it."""
        move, path = displaced.move, self.placed.path
        block, state = int(path.block[move]), path.coordinate_state(move)
        edits: list[Edit] = []
        jump = displaced.start_mm - (path.start_mm[move] + self.written_mm)
        if path.motion[move] != Motion.RAPID and self.last is not None and np.abs(jump).max() > self.tolerance_mm:
            if path.motion[move] == Motion.ARC:
                edits += self._take_up(displaced, state)
            else:
                displaced = replace(displaced, pieces=[Piece(displaced.start_mm), *displaced.pieces])
        first, *rest = displaced.pieces
        self.last = block
        edits += self._first(displaced, first, bool(rest), state)
        if rest:
            texts = list(self._following(displaced, state))
            edits.append(insert_blocks_after(self.program, block, texts))
        if self.edits.setdefault(block, edits) != edits:
            raise _twice(self.program, block)

    def _first(self, displaced: DisplacedMove, piece: Piece, split: bool, state: CoordinateState) -> Iterator[Edit]:
        move, path = displaced.move, self.placed.path
        words = [None if w < 0 else self.program.word(int(w)) for w in path.word[move]]
        correction = displaced.pieces[-1].end_mm - path.end_mm[move]
        for k, word in enumerate(words):
            delta = float((piece.end_mm - path.end_mm[move])[k])
            if word is None:
                if split or abs(correction[k] - self.written_mm[k]) > HALF * self._resolution_mm(state):
                    yield insert_word(self.program, int(path.block[move]), AXES[k], float(piece.end_mm[k]), state)
                    self.written_mm[k] = correction[k]
                continue
            self.written_mm[k] = correction[k]
            if split:
                text = coordinate_text(self.program.dialect, AXES[k], float(piece.end_mm[k]), state)
                yield Edit(word.value_start, word.end, text[1:])
            elif (edit := displace_word(self.program, word, delta, state)) is not None:
                yield edit
        if piece.centre_mm is not None:
            yield from self._centre(displaced, piece, state)

    def _take_up(self, displaced: DisplacedMove, state: CoordinateState) -> Iterator[Edit]:
        """A straight block before an arc, which then has to say G2 or G3 itself."""
        assert self.last is not None
        move, path = displaced.move, self.placed.path
        start = Piece(displaced.start_mm)
        texts = [coordinate_text(self.program.dialect, a, float(start.end_mm[k]), state) for k, a in enumerate(AXES)]
        yield insert_blocks_after(self.program, self.last, [" ".join(["G1", *texts])])
        block = int(path.block[move])
        if not _codes(self.program, block) & {2, 3}:
            at = next(word for word in self.program.block(block).words if word.letter != "N").start
            yield Edit(at, at, "G2 " if path.sweep_rad[move] > 0 else "G3 ")

    def _centre(self, displaced: DisplacedMove, piece: Piece, state: CoordinateState) -> Iterator[Edit]:
        """I, J, K from the displaced start, or R, of the block's own arc."""
        move, path = displaced.move, self.placed.path
        assert piece.centre_mm is not None
        block = self.program.block(int(path.block[move]))
        by_letter = {word.letter: word for word in block.words}
        plane = PLANES[int(path.plane[move])]
        if "R" in by_letter:
            radius = float(np.linalg.norm((piece.centre_mm - displaced.start_mm)[list(plane)]))
            # R is negative where the arc is more than half a turn; the path holds its size.
            sign = -1.0 if abs(path.sweep_rad[move]) > np.pi else 1.0
            new_sign = sign if len(displaced.pieces) == 1 else 1.0
            yield from self._moved(
                by_letter["R"], new_sign * radius, sign * float(path.programmed_radius_mm[move]), state
            )
            return
        old = path.centre_mm[move] - path.start_mm[move]
        new = piece.centre_mm - displaced.start_mm
        for k in plane:
            word = by_letter.get(CENTRES[k])
            if word is not None:
                self._check_incremental(word, float(old[k]), state)
                yield from self._moved(word, float(new[k]), float(old[k]), state)
            elif abs(new[k]) > HALF * self._resolution_mm(state):
                yield insert_word(self.program, block.index, CENTRES[k], float(new[k]), state)

    def _moved(self, word: Word, new: float, old: float, state: CoordinateState) -> Iterator[Edit]:
        edit = displace_word(self.program, word, new - old, state)
        if edit is not None:
            yield edit

    def _following(self, displaced: DisplacedMove, state: CoordinateState) -> Iterator[str]:
        """Blocks after the first piece; the last keeps the programmer's expressions."""
        move, path = displaced.move, self.placed.path
        start = displaced.pieces[0].end_mm
        for piece in displaced.pieces[1:]:
            words = [self._text(move, k, piece, piece is displaced.pieces[-1], state) for k in range(3)]
            if piece.centre_mm is None and path.motion[move] == Motion.ARC:
                words = ["G1", *words]
            if piece.centre_mm is not None:
                plane = PLANES[int(path.plane[move])]
                offset = piece.centre_mm - start
                texts = [coordinate_text(self.program.dialect, CENTRES[k], float(offset[k]), state) for k in plane]
                words = ["G2" if path.sweep_rad[move] > 0 else "G3", *words, *texts]
            yield " ".join(words)
            start = piece.end_mm

    def _text(self, move: int, axis: int, piece: Piece, last: bool, state: CoordinateState) -> str:
        path = self.placed.path
        index = int(path.word[move][axis])
        word = self.program.word(index) if index >= 0 else None
        if last and word is not None and word.is_expression:
            delta = float((piece.end_mm - path.end_mm[move])[axis])
            edit = displace_word(self.program, word, delta, state)
            return word.text if edit is None else AXES[axis] + edit.text
        return coordinate_text(self.program.dialect, AXES[axis], float(piece.end_mm[axis]), state)

    def _resolution_mm(self, state: CoordinateState) -> float:
        dialect = self.program.dialect
        return (dialect.resolution_inch * 25.4) if state.inch else dialect.resolution_mm

    def _check_incremental(self, word: Word, old: float, state: CoordinateState) -> None:
        if word.kind == "number" and abs(word.value * state.unit_mm(word.letter) - old) > 1e-3:
            raise TrueloopError(
                Code.MCH_PROGRAM,
                f"{word.text} is not the way from the start of the arc to its centre ({old:g} mm)",
                hint="program arc centres as increments (G91.1)",
                place=self.program.place(word.start),
            )


def changed_blocks(edits: Sequence[Edit], program: Program) -> int:
    """How many blocks of the program the edits touch."""
    return len({program.place(edit.start).line for edit in edits})


def _no_word(program: Program, block: int, count: int) -> TrueloopError:
    return TrueloopError(
        Code.MCH_PROGRAM,
        f"{count} moves have coordinates that no word sets, the first in block {block + 1}: a cycle, or a subprogram's",
        hint="write cycles out as moves; a program of points alone can be corrected by a planar field",
        place=program.place(program.block(block).start),
    )


def _twice(program: Program, block: int) -> TrueloopError:
    return TrueloopError(
        Code.MCH_PROGRAM,
        f"block {block + 1} is run several times at different places, which need different corrections",
        hint="write the loop or subprogram out",
        place=program.place(program.block(block).start),
    )
