"""The tool-offset variant: the program's coordinates stay, a constant moves the whole contour [6811 §3.2]."""

from dataclasses import replace
from typing import Final

from trueloop.nc.edit import Edit, coordinate_text, insert_blocks_after, set_offset
from trueloop.nc.program import Program
from trueloop.nc.tool_path import CoordinateState, ToolPath

LOCAL_SHIFT: Final = ("linuxcnc", "fanuc", "haas", "siemens")
"""Controls whose tool table a program cannot set for one run only: the contour is put into a shifted frame."""
FINISHING_CYCLE: Final = 70.0
CONTOUR_WORDS: Final = frozenset({"P", "Q"})
"""They name the first and last block of its contour."""


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
    if program.dialect.name.startswith(LOCAL_SHIFT):
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
            edits.append(_before(program, int(path.block[first]), f"(UPD, {tool}, TOV({axis}), {text})"))
    return edits


def _local_shift(
    program: Program, path: ToolPath, span: tuple[int, int], offset_mm: tuple[float, float], state: CoordinateState
) -> list[Edit]:
    """A shift before the contour, taken back after it: it holds for as long as the contour is cut and no longer.

    Sinumerik's ATRANS adds to a shift that may be in force, and takes X as a radius.
    """
    added = program.dialect.name == "siemens"
    written = replace(state, diameter=False) if added else state

    def shift(offset_mm: tuple[float, float]) -> str:
        words = (coordinate_text(program.dialect, a, v, written) for a, v in zip("XZ", offset_mm, strict=True))
        return " ".join(["ATRANS" if added else "G52", *words])

    first, last = (int(path.block[move]) for move in span)
    cycle = _finishing_cycle(program, last)
    first, last = (first, last) if cycle is None else (cycle, cycle)
    zero = "0." if "." in shift(offset_mm) else "0"
    back = shift((-offset_mm[0], -offset_mm[1])) if added else f"G52 X{zero} Z{zero}"
    return [
        _before(program, first, shift(offset_mm)),
        insert_blocks_after(program, last, [back]),
    ]


def _finishing_cycle(program: Program, contour_block: int) -> int | None:
    """The block of the G70 that runs the contour; None where the program cuts it in its own course."""
    if program.dialect.name in ("linuxcnc", "ge2000t"):
        return None
    blocks = list(program.blocks)
    for block in blocks:
        values = {word.letter: word.value for word in block.words if word.letter in CONTOUR_WORDS}
        if len(values) == 2 and any(word.letter == "G" and word.value == FINISHING_CYCLE for word in block.words):
            places = [b.index for b in blocks if b.number in values.values()]
            if min(places, default=1) <= contour_block <= max(places, default=0):
                return block.index
    return None


def _before(program: Program, block: int, text: str) -> Edit:
    """A block before another one: after the block that stands there."""
    if block == 0:
        start = program.block(0).start
        return Edit(start, start, text + "\n")
    return insert_blocks_after(program, block - 1, [text])
