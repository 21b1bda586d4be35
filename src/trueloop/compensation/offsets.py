"""The tool-offset variant: the program's coordinates stay, a constant moves the whole contour [6811 §3.2]."""

from typing import Final

from trueloop.nc.edit import Edit, coordinate_text, insert_blocks_after, set_offset
from trueloop.nc.program import Program
from trueloop.nc.tool_path import CoordinateState, ToolPath

LOCAL_SHIFT: Final = frozenset({"linuxcnc"})
"""Controls whose tool table a program cannot add to: the contour is put into a shifted frame (G52) instead."""


def offset_edits(
    program: Program,
    path: ToolPath,
    span: tuple[int, int],
    offset_mm: tuple[float, float],
    tool: int,
    offset_is_diameter: bool | None,
) -> list[Edit]:
    """Edits that add (x as a radius, z) to the tool's offset for the moves `span` (first, last, both included).

    GE 2000T: the UPD statements, written before the contour where there are none. The value is added to the programmed
    coordinate; `offset_is_diameter` says how the control reads X (None: as its coordinates).
    """
    first, last = span
    state = path.coordinate_state(first)
    if program.dialect.name in LOCAL_SHIFT:
        return _local_shift(program, path, (first, last), offset_mm, state)
    written = CoordinateState(state.inch, state.diameter if offset_is_diameter is None else offset_is_diameter)
    edits: list[Edit] = []
    for axis, value_mm in zip("XZ", offset_mm, strict=True):
        old = [s for s in program.offset_statements if s.axis == axis and s.tool == tool]
        if old:
            value = old[0].value * written.unit_mm(axis) + value_mm
            edits.append(set_offset(program, axis, value, state, tool=tool, diameter=offset_is_diameter))
        else:
            text = coordinate_text(program.dialect, axis, value_mm, written)[1:]
            edits.append(_before(program, path, first, f"(UPD, {tool}, TOV({axis}), {text})"))
    return edits


def _local_shift(
    program: Program, path: ToolPath, span: tuple[int, int], offset_mm: tuple[float, float], state: CoordinateState
) -> list[Edit]:
    """G52 before the contour, taken back after it: it holds for as long as the contour is cut and no longer."""
    words = [coordinate_text(program.dialect, a, v, state) for a, v in zip("XZ", offset_mm, strict=True)]
    return [
        _before(program, path, span[0], " ".join(["G52", *words])),
        insert_blocks_after(program, int(path.block[span[1]]), ["G52 X0 Z0"]),
    ]


def _before(program: Program, path: ToolPath, move: int, text: str) -> Edit:
    """A block before that of a move: after the block that stands there."""
    block = int(path.block[move])
    if block == 0:
        start = program.block(0).start
        return Edit(start, start, text + "\n")
    return insert_blocks_after(program, block - 1, [text])
