"""The tool-offset variant: the program's coordinates stay, a constant moves the whole contour [6811 §3.2].

Where the program can set the tool's offset for one run (GE 2000T: UPD) it does. Elsewhere the contour is cut in a
shifted frame:
`shifted_frame` says which moves. G52 is written as what is in force plus the offset and set back to what was in force;
ATRANS adds to what is in force and is taken back. A program that is stopped in the cut leaves G52 on, LinuxCNC even
over a restart: it is set to zero at the program's head, so that the next run begins as the first did. A shift that was
in force before the program began is thereby taken back as well: the program is read as one that begins without.
"""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.nc.edit.edit import Edit, coordinate_text, insert_blocks_after, set_offset
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import CoordinateState, ToolPath
from trueloop.turned.program.shifted_frame import Shifted

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
        _require_followed(program, path, shifted, base_mm)
        there, back = (_words(program, code, value, state) for value in (base_mm + offset, base_mm))
        nothing = f"{_words(program, code, 0 * offset, state)} {program.dialect.comment(LEFT_BEHIND)}"
        head = [_before(program, _first_of_course(program), nothing)]
    return [*head, _before(program, shifted.begin, there), insert_blocks_after(program, shifted.end, [back])]


def _words(program: Program, code: str, value_mm: Array, state: CoordinateState) -> str:
    texts = (coordinate_text(program.dialect, a, float(v), state) for a, v in zip("XZ", value_mm, strict=True))
    return " ".join([code, *texts])


def _require_followed(program: Program, path: ToolPath, shifted: Shifted, base_mm: Array) -> None:
    if np.any(base_mm) and not program.dialect.one_shift:
        raise Code.NC_OFFSET.refusal(
            f"a shift of x {base_mm[0]:g} mm (radius), z {base_mm[1]:g} mm is in force at line "
            f"{path.line[shifted.first]}; what G52 makes of it there depends on the control",
            hint="put the program's own shift into the work offset, or correct the contour",
            place=program.place(program.block(shifted.begin).start),
        )


def _first_of_course(program: Program) -> int:
    """Returns the first block with a word that is not the program's number."""
    return next((block.index for block in program.blocks if block.data and not _is_number(block)), 0)


def _is_number(block: Block) -> bool:
    return all(word.kind == "unknown" or (word.letter == "O" and word.kind == "number") for word in block.data)


def _before(program: Program, block: int, text: str) -> Edit:
    """Inserts a block before another one: after the block that stands there."""
    if block == 0:
        start = program.block(0).start
        return Edit(start, start, text + "\n")
    return insert_blocks_after(program, block - 1, [text])
