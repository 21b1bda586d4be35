"""Words of explicit moves as each control has them: motion codes, radius or centre of an arc, feed."""

import math
from collections.abc import Sequence
from typing import Final

from trueloop.arrays import Array
from trueloop.nc.edit.edit import circle_text, coordinate_text
from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.units import MM_PER_INCH

WIDE_RAD: Final = math.radians(120.0)
"""Arcs that turn more are written by their centre: from a radius, rounding would move one too far."""
_CODES: Final = {Motion.RAPID: 0, Motion.LINE: 1}


def g_digits(program: Program) -> int:
    """Returns the number of digits of the program's motion codes: 2 of `G01`, 1 of `G1`; 2 without any."""
    for block in program.blocks:
        word = motion_word(program, block)
        if word is not None and word.kind == "number" and word.value in range(4):
            return len(word.text) - 1
    return 2


def g_code(path: ToolPath, move: int, digits: int) -> str:
    """Returns the code of a rapid, a line or an arc; empty for other moves."""
    kind = Motion(path.motion[move])
    if kind == Motion.ARC:
        return f"G{2 if path.sweep_rad[move] > 0 else 3:0{digits}d}"
    return f"G{_CODES[kind]:0{digits}d}" if kind in _CODES else ""


def motion_word(program: Program, block: Block) -> Word | None:
    """Returns the first word of a block that sets its motion; DR of Klartext comes after it."""
    meanings = ((word, program.core.meaning(word.index) or "") for word in block.data)
    return next((word for word, meaning in meanings if meaning.startswith("Motion(")), None)


def klartext_name(path: ToolPath, move: int, block: Block, new: Sequence[str]) -> str:
    """Returns the name of a Klartext move: L of a line; of an arc CR where it has a radius, C about its pole."""
    if path.motion[move] != Motion.ARC:
        return "L"
    return "CR" if any(text.startswith("R") for text in [*new, *(w.text for w in block.data)]) else "C"


def circle_words(program: Program, path: ToolPath, move: int, start: Array, end: Array) -> str:
    """Returns the radius, or of a wide arc its centre from the start, moved to be as far from both rounded ends."""
    state, axes, centre = path.coordinate_state(move), PLANE_AXES[int(path.plane[move])], path.centre_mm[move]
    if is_wide(path, move):
        return circle_text(program, state, axes, centre, start, by_radius=False, end_mm=end)
    return circle_text(program, state, axes, centre, path.start_mm[move], by_radius=True)


def is_wide(path: ToolPath, move: int) -> bool:
    """Returns whether an arc is to be written by its centre."""
    return bool(abs(path.sweep_rad[move]) > WIDE_RAD)


def klartext_turn(path: ToolPath, move: int) -> str:
    """Returns the word of an arc's direction in Klartext: DR- clockwise."""
    return f"DR{'-' if path.sweep_rad[move] > 0 else '+'}"


def pole_block(program: Program, path: ToolPath, move: int) -> str:
    """Returns the CC block of an arc of Klartext."""
    state = path.coordinate_state(move)
    axes = sorted(PLANE_AXES[int(path.plane[move])])
    words = [coordinate_text(program.dialect, "XYZ"[axis], float(path.centre_mm[move, axis]), state) for axis in axes]
    return " ".join(["CC", *words])


def feed_word(program: Program, path: ToolPath, move: int) -> str:
    """Returns the F word of a move's feed."""
    feed = float(path.feed[move]) / (MM_PER_INCH if path.inch[move] else 1.0)
    text = f"F{feed:.6f}".rstrip("0")
    return text.rstrip(".") if program.dialect.klartext else text
