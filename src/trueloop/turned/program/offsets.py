"""The tool-offset variant: the program's coordinates stay, a constant moves the whole contour [6811 §3.2].

Where the program can set the tool's offset for one run (GE 2000T: UPD) it does. Elsewhere the contour is cut in a
shifted frame:
`shifted_frame` says which moves. G52 is written as what is in force plus the offset and set back to what was in force;
ATRANS adds to what is in force and is taken back. A program that is stopped in the cut leaves G52 on, LinuxCNC even
over a restart: it is set to zero at the program's head, so that the next run begins as the first did. A shift that was
in force before the program began is thereby taken back as well: the program is read as one that begins without.

The offset variant read back: in machine coordinates the contour has moved by the offset, and nothing else has.

The moves that run in a shifted frame when a contour is to be cut there, and the blocks between which it is shifted.

A coordinate that a move inherits is not shifted: the tool stays where it is when the frame changes. So the shift begins
before both coordinates of the contour's beginning are set. It begins and ends outside of cutter compensation, under
which controls do not let the frame change (LinuxCNC stops in the cut), and around a finishing cycle as a whole.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.changes import not_as_intended, verify_written
from trueloop.nc.edit.edit import Edit, coordinate_text, insert_blocks_after, set_offset
from trueloop.nc.expand.loops import loops_of
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import CoordinateState, ToolPath
from trueloop.turned.program.contour_cycles import finishing_cycle
from trueloop.turned.program.read_back import SAME_MM
from trueloop.units import UM_PER_MM

OFF: Final = 40
ON: Final = frozenset({41, 42})
FINISHING_CYCLE: Final = 70.0


@dataclass(frozen=True)
class Shifted:
    """Moves `first` to `last` are shifted, both included: from before block `begin` to after block `end`."""

    first: int
    last: int
    begin: int
    end: int


@dataclass(frozen=True)
class _Cycle:
    """A finishing cycle: its block, and the blocks of its contour."""

    block: int
    contour: Collection[int]

    def runs(self, block: int) -> bool:
        return block == self.block or block in self.contour


def shifted_moves(program: Program, path: ToolPath, cuts: tuple[int, int]) -> Shifted:
    """Returns the moves to be shifted so that moves `cuts` (first, last) are. Raises NC-OFFSET where a block that
    begins or ends the shift is not to be found, or where frame or tool change in between.
    """
    cycle = _cycle_of_calls(program, path, cuts[0]) or _finishing_cycle(program, int(path.block[cuts[0]]))
    first, last = cuts[0] - 1, cuts[1]
    if cycle is not None:
        while first > 0 and cycle.runs(int(path.block[first - 1])):
            first -= 1
        while last + 1 < len(path) and cycle.runs(int(path.block[last + 1])):
            last += 1
    first, begin = _begin(program, path, _both_set(program, path, first, cuts[0]))
    last, end = _end(program, path, last)
    for loop in loops_of(program):  # shifted as a whole: a block inside runs again and again
        moves = np.flatnonzero((path.block >= loop.first) & (path.block <= loop.last))
        begin, first = (loop.first, min(first, int(moves[0]))) if loop.has(begin) else (begin, first)
        end, last = (loop.last, max(last, int(moves[-1]))) if loop.has(end) else (end, last)
    among = slice(first, last + 1)
    for values, what in ((path.origin_mm, "frame"), (path.tool[:, None], "tool")):
        changed = np.flatnonzero(np.any(values[among] != values[first], axis=1))
        if changed.size:
            raise _refusal(program, int(path.block[first + changed[0]]), f"the {what} changes among the shifted moves")
    # Refuses blocks that run outside of the shift too: another tool's pass would be shifted with them
    every = np.arange(len(path))
    outside = path.block[(every < first) | (every > last)]
    again = np.intersect1d(path.block[first : last + 1], outside)
    if again.size:
        raise _refusal(program, int(again[0]), "the blocks run several times")
    return Shifted(first, last, *(cycle.block if cycle and cycle.runs(block) else block for block in (begin, end)))


def positions_set(program: Program, path: ToolPath, move: int) -> Flags:
    """Returns whether a word sets each coordinate of a move's end as a position, (3,): not inherited, no increment."""
    found = np.zeros(3, dtype=np.bool_)
    for axis, index in enumerate(path.word[move]):
        if index >= 0:
            increment = program.word(int(index)).increment
            found[axis] = not (path.incremental[move] if increment is None else increment)
    return found


def _both_set(program: Program, path: ToolPath, first: int, cut: int) -> int:
    """Returns the last move not after `first` from which to the cut both X and Z are set."""
    found = np.zeros(3, dtype=np.bool_)
    for move in range(cut - 1, -1, -1):
        found |= positions_set(program, path, move)
        if found[0] and found[2] and move <= first:
            return move
    raise _refusal(program, int(path.block[cut]), "X and Z are not both set by words before the contour begins here")


def _begin(program: Program, path: ToolPath, first: int) -> tuple[int, int]:
    """Returns the first move of the compensation in force, and the block that switches it on; else move and block."""
    compensation, block = path.compensation, path.block
    while first > 0 and compensation[first] != OFF and compensation[first - 1] != OFF:
        first -= 1
    if compensation[first] == OFF:
        return first, int(block[first])
    earliest = int(block[first - 1]) if first else -1
    return first, _switch(program, range(int(block[first]), earliest, -1), ON, int(block[first]))


def _end(program: Program, path: ToolPath, last: int) -> tuple[int, int]:
    """Returns the last move of the compensation in force, and the block that switches it off; else move and block."""
    compensation, block = path.compensation, path.block
    if compensation[last] == OFF:
        return last, int(block[last])
    while last + 1 < len(path) and compensation[last + 1] != OFF:
        last += 1
    more = last + 1 < len(path)
    latest = int(block[last + 1]) if more else program.block_count - 1
    found = _switch(program, range(int(block[last]), latest + 1), {OFF}, int(block[last]))
    return last + (more and found == latest), found


def _switch(program: Program, blocks: Iterable[int], codes: Collection[int], seen_from: int) -> int:
    """Returns the first of the blocks with one of these G codes."""
    for block in blocks:
        words = (word for word in program.block(block).words if word.letter == "G" and word.kind == "number")
        if any(int(word.value) in codes for word in words):
            return block
    raise _refusal(
        program, seen_from, "compensation is in force, and the block that switches it is not next to the cut"
    )


def _cycle_of_calls(program: Program, path: ToolPath, cut: int) -> _Cycle | None:
    """Returns the G70 that calls the contour by its name; its blocks are those of its moves."""
    cycle = finishing_cycle(program, path, cut)
    if cycle is None or cycle.by == "numbers":
        return None
    return _Cycle(cycle.block.index, frozenset(path.block[path.call == path.call[cut]].tolist()))


def _finishing_cycle(program: Program, contour_block: int) -> _Cycle | None:
    """Returns the G70 that runs the contour; None where the program cuts it in its own course."""
    if not program.dialect.contours_by_number:
        return None
    blocks = list(program.blocks)
    for block in blocks:
        ends = [b.index for b in blocks if b.number is not None and b.number in _contour_of(block)]
        contour = range(min(ends, default=0), max(ends, default=-1) + 1)
        if contour_block in contour:
            return _Cycle(block.index, contour)
    return None


def _contour_of(block: Block) -> set[float]:
    """Returns the block numbers P and Q of a finishing cycle; of another block none."""
    if not any(word.letter == "G" and word.value == FINISHING_CYCLE for word in block.words):
        return set()
    return {word.value for word in block.words if word.letter in {"P", "Q"}}


def _refusal(program: Program, block: int, what: str) -> TrueloopError:
    return Code.NC_OFFSET.refusal(
        f"line {block + 1}: {what}, so that no shift of the frame can be put around the contour",
        hint="correct the contour, or set the tool's offset at the control",
        place=program.place(program.block(block).start),
    )


LEFT_BEHIND: Final = "takes back the shift of a run that was stopped in the cut"


def has_local_shift(program: Program) -> bool:
    """Returns whether the offset is a shift of the frame, else an update of the tool's. Raises NC-OFFSET: neither."""
    if not program.dialect.contour_shift:
        known = [name for name, dialect in DIALECTS.items() if dialect.contour_shift]
        raise Code.NC_OFFSET.refusal(
            f"how a {program.dialect.name} program shifts a contour by an offset is not known: that of {len(known)} "
            "dialects is",
            hint=f"known are {', '.join(known)}",
        )
    return program.dialect.contour_shift != "UPD"


def tool_offset_updates(
    program: Program, state: CoordinateState, offset_mm: tuple[float, float], tool: int
) -> dict[str, float]:
    """Returns the values (mm, x as a radius) that the tool's offsets shall get: those that the program sets, and the
    offset.

    `state` is how the program writes offsets (`offset_state`).
    """
    own = {s.axis: s.value * state.unit_mm(s.axis) for s in program.offset_statements if s.tool == tool}
    return {axis: own.get(axis, 0.0) + value_mm for axis, value_mm in zip("XZ", offset_mm, strict=True)}


def offset_state(state: CoordinateState, is_diameter: bool | None) -> CoordinateState:
    """Returns the style of offsets; `is_diameter` is how the control reads X (None: as its coordinates)."""
    return CoordinateState(state.inch, state.diameter if is_diameter is None else is_diameter)


def update_edits(
    program: Program, path: ToolPath, lead: int, values_mm: dict[str, float], tool: int, is_diameter: bool | None
) -> list[Edit]:
    """Writes UPD statements that add these values to coordinates, before move `lead` where there are none."""
    state = path.coordinate_state(lead)
    edits: list[Edit] = []
    for axis, value_mm in values_mm.items():
        if any((s.axis, s.tool) == (axis, tool) for s in program.offset_statements):
            edits.append(set_offset(program, axis, value_mm, state, tool=tool, diameter=is_diameter))
        else:
            text = coordinate_text(program.dialect, axis, value_mm, offset_state(state, is_diameter))[1:]
            edits.append(_before(program, int(path.block[lead]), f"(UPD, {tool}, TOV({axis}), {text})"))
    return edits


def shift_edits(program: Program, path: ToolPath, shifted: Shifted, offset_mm: tuple[float, float]) -> list[Edit]:
    """Writes a shift by (x as a radius, z) for those moves. Raises NC-OFFSET where it would replace another one."""
    state = path.coordinate_state(shifted.first)
    base_mm, offset = path.register_mm[shifted.first, [0, 2]], np.asarray(offset_mm)
    code = program.dialect.contour_shift
    if code == "ATRANS":  # X of a frame is a radius
        state = CoordinateState(state.inch, diameter=False)
        there, back, head = _words(program, code, offset, state), _words(program, code, -offset, state), []
    else:
        if np.any(base_mm) and not program.dialect.one_shift:
            raise Code.NC_OFFSET.refusal(
                f"a shift of x {base_mm[0]:g} mm (radius), z {base_mm[1]:g} mm is in force at line "
                f"{path.line[shifted.first]}; what G52 makes of it there depends on the control",
                hint="put the program's own shift into the work offset, or correct the contour",
                place=program.place(program.block(shifted.begin).start),
            )
        there, back = (_words(program, code, value, state) for value in (base_mm + offset, base_mm))
        nothing = f"{_words(program, code, 0 * offset, state)} {program.dialect.comment(LEFT_BEHIND)}"
        # The first block with a word that is not the program's number
        first_of_course = next((block.index for block in program.blocks if block.data and not _is_number(block)), 0)
        head = [_before(program, first_of_course, nothing)]
    return [*head, _before(program, shifted.begin, there), insert_blocks_after(program, shifted.end, [back])]


def _words(program: Program, code: str, value_mm: Array, state: CoordinateState) -> str:
    texts = (coordinate_text(program.dialect, a, float(v), state) for a, v in zip("XZ", value_mm, strict=True))
    return " ".join([code, *texts])


def _is_number(block: Block) -> bool:
    return all(word.kind == "unknown" or (word.letter == "O" and word.kind == "number") for word in block.data)


def _before(program: Program, block: int, text: str) -> Edit:
    """Inserts a block before another one: after the block that stands there."""
    if block == 0:
        start = program.block(0).start
        return Edit(start, start, text + "\n")
    return insert_blocks_after(program, block - 1, [text])


def require_same_path(before: ToolPath, after: ToolPath) -> None:
    """Refuses a program that does not command the same moves."""
    _require_same_kinds(before.motion, after.motion)
    moves = np.arange(len(before))
    verify_written(before, after, (moves, moves), before.end_mm, allowed_mm=SAME_MM)


def require_shift(
    program: Program,
    before: ToolPath,
    after: ToolPath,
    shifted: Shifted,
    cuts: tuple[int, int],
    offset_mm: tuple[float, float],
    tolerance_mm: float,
) -> None:
    """Refuses a program that does not cut moves `cuts` (first, last) off by the offset (x as a radius, z) in machine
    coordinates, from their beginning, or that ends a move outside of `shifted` elsewhere than the source.

    A coordinate that a move inherits or sets by an increment follows the tool: but in the cut it may be either.
    """
    moves = _programmed(before)
    _require_same_kinds(before.motion[moves], after.motion[_programmed(after)])
    inside = ((shifted.first <= moves) & (moves <= shifted.last))[:, None]
    offset = np.array([offset_mm[0], 0.0, offset_mm[1]])
    wanted, other = np.where(inside, offset, 0.0), np.where(inside, 0.0, offset)
    starts, ends = (_moved_mm(before, after, name) for name in ("start_mm", "end_mm"))
    off = np.abs(ends - wanted)
    free = ~np.array([positions_set(program, before, int(move)) for move in moves])
    off[free] = np.minimum(off, np.abs(ends - other))[free]
    cut = (cuts[0] <= moves) & (moves <= cuts[1])
    off[cut] = np.maximum(off, np.maximum(np.abs(ends - offset), np.abs(starts - offset)))[cut]
    if not np.max(off) <= tolerance_mm:
        worst = int(np.argmax(np.max(off, axis=1)))
        raise not_as_intended(
            f"line {before.line[moves[worst]]} would end shifted by {_microns(ends[worst])}, and begin by "
            f"{_microns(starts[worst])}; meant is {_microns(wanted[worst])}"
        )


def require_updates(after: Program, state: CoordinateState, values_mm: dict[str, float], tool: int) -> None:
    """Refuses a program that does not update that tool's offsets to these values; `state` is how it writes them."""
    for axis, value_mm in values_mm.items():
        step_mm = (after.dialect.resolution_inch if state.inch else after.dialect.resolution_mm) * state.unit_mm(axis)
        read = [s.value * state.unit_mm(axis) for s in after.offset_statements if (s.axis, s.tool) == (axis, tool)]
        if len(read) != 1 or not abs(read[0] - value_mm) <= step_mm / 2 + SAME_MM:
            raise not_as_intended(
                f"the {axis} offset of tool {tool} is updated to {read} mm instead of {value_mm:.6f} mm"
            )


def _moved_mm(before: ToolPath, after: ToolPath, name: str) -> Array:
    """Returns how far points of the programmed moves have moved in machine coordinates, (n, 3)."""
    there, here = ((getattr(path, name) + path.origin_mm)[_programmed(path)] for path in (after, before))
    return np.asarray(there - here)


def _require_same_kinds(before: Integers, after: Integers) -> None:
    if not np.array_equal(before, after):
        raise not_as_intended(f"the written program has {len(after)} moves, not the {len(before)} of the source")


def _programmed(path: ToolPath) -> Integers:
    """Returns the moves whose end a word of their block set; a way back that a cycle adds depends on the frame."""
    return np.flatnonzero(np.max(path.word, axis=1) >= 0)


def _microns(xyz_mm: Array) -> str:
    x, _, z = xyz_mm * UM_PER_MM
    return f"x {x:.2f} µm (radius), z {z:.2f} µm"
