"""The tool-offset variant: the program's coordinates stay, a constant moves the whole contour [6811 §3.2].

Where the program can set the tool's offset for one run (GE 2000T: UPD) it does. Elsewhere the contour is cut in a
shifted frame:
`shifted_frame` says which moves. G52 is written as what is in force plus the offset and set back to what was in force;
ATRANS adds to what is in force and is taken back. A program that is stopped in the cut leaves G52 on, LinuxCNC even
over a restart: it is set to zero at the program's head, so that the next run begins as the first did. A shift that was
in force before the program began is thereby taken back as well: the program is read as one that begins without.

The offset variant read back: in machine coordinates the contour has moved by the offset, and nothing else has.
"""

from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code
from trueloop.nc.edit.changes import not_as_intended, verify_written
from trueloop.nc.edit.edit import Edit, coordinate_text, insert_blocks_after, set_offset
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import CoordinateState, ToolPath
from trueloop.turned.program.read_back import SAME_MM
from trueloop.turned.program.shifted_frame import Shifted, positions_set
from trueloop.units import UM_PER_MM

LEFT_BEHIND: Final = "takes back the shift of a run that was stopped in the cut"


def has_local_shift(program: Program) -> bool:
    """Returns whether the offset is written as a shift of the frame; otherwise it is an update of the tool's offset.

    Raises NC-OFFSET for a control of which neither is known.
    """
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
    """Writes UPD statements with these values, written before move `lead` where there are none. The control adds the
    value to the programmed coordinate.
    """
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
    """Returns the moves whose end a word of their block set; whether a finishing cycle adds a way back depends on the
    frame.
    """
    return np.flatnonzero(np.max(path.word, axis=1) >= 0)


def _microns(xyz_mm: Array) -> str:
    x, _, z = xyz_mm * UM_PER_MM
    return f"x {x:.2f} µm (radius), z {z:.2f} µm"
