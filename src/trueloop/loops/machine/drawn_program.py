"""A program file whose contours are drawn with less than every point, written out before a field is applied to it."""

import re
from collections.abc import Collection, Mapping
from typing import Final

import numpy as np

from trueloop.errors import Code
from trueloop.nc.edit.changes import PLAIN_CORNER, SHAPE, TURNS
from trueloop.nc.expand.block import gives_spline, motion_word
from trueloop.nc.expand.expand import WrittenOut, written_out
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.nc.program.understood import require_sound

_SHAPING: Final = re.compile(
    rb",[ \t]*[RCA]|RND|CHF|CHR|ANG|A[RP]|RP|\bC[TP]|\bLP|CIP|[PI][AR][-+ \t\d]|A[ \t]*[-+\d.#]|[@^]", re.IGNORECASE
)
"""Pattern of blocks whose words may shape a move beside its end; it may match more."""


_POLAR: Final = ("LP", "CP")
"""Moves of Klartext to a radius and an angle about the pole."""

_SPLINE: Final = tuple(re.compile(letter + rb"[ \t]*0*5(?!\d)") for letter in (b"G", b"g"))
"""Splines of LinuxCNC, G5 to G5.2; they may match more. One that minds no case takes four times as long."""


def has_shapes(letters: Collection[str], dialect: Dialect) -> bool:
    """Returns whether words of these letters shape moves beside their ends."""
    shapes = SHAPE - {TURNS} | ({"A"} if dialect.line_angle else set())
    shapes |= PLAIN_CORNER if dialect.plain_corners else set()
    return bool(shapes & set(letters))


def written_out_file(
    program: Program, parameters: Mapping[str, float], *, skipped_blocks: bool, keeps_polar: bool
) -> tuple[Program, WrittenOut]:
    """Writes the whole program out and returns both. Raises what running it strictly does, and NC-EDIT.

    keeps_polar: LP and CP of Klartext keep their words: where every position has one displacement, CC has it too.
    """

    def run(program: Program) -> ToolPath:
        return program.run(
            parameters, skipped_blocks=skipped_blocks, roughing=False, placed=False, roughed_contours=True
        )

    path = run(program)
    require_sound(path)
    blocks = np.zeros(program.block_count, dtype=np.bool_)
    blocks[[program.core.block_at(found.start()) for found in _SHAPING.finditer(program.source)]] = True
    wordless = (path.word < 0).all(axis=1) | (path.motion == Motion.ARC)
    drawn = blocks[path.block] | wordless
    if keeps_polar and program.dialect.klartext:
        words = ((block.index, motion_word(program, block)) for block in program.blocks)
        kept = np.zeros(program.block_count, dtype=np.bool_)
        kept[[index for index, word in words if word is not None and word.text.upper() in _POLAR]] = True
        drawn &= ~kept[path.block]
    done = written_out(program, path, np.flatnonzero(drawn).tolist(), run)
    if program.dialect.splines:
        with done.in_lines_of(program):
            # Refuses a spline that was not written out, as one without any length: its end would stay where it was
            for start in sorted(found.start() for code in _SPLINE for found in code.finditer(done.program.source)):
                block = done.program.block(done.program.core.block_at(start))
                if gives_spline(done.program, block):
                    text = done.program.source[block.start : block.end].decode("latin-1").strip()
                    raise Code.NC_EDIT.refusal(
                        f"{text[:60]!r} cannot be written out as explicit moves: it is not run, or goes nowhere",
                        hint="take the block out",
                        place=done.program.place(start),
                    )
    return program, done
