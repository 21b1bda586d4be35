"""The place of a comment about the whole program: after the lines that a control requires first."""

import re
from collections.abc import Sequence
from typing import Final

from trueloop.nc.edit.edit import Edit, insert_blocks_after, line_ending
from trueloop.nc.program.program import Program

_HAS_TO_BE_FIRST: Final = re.compile(
    rb"""\s*(?:
        % .*                                             # tape mark, or the program's name behind it
        | \$ [^\s%]+ %                                   # Okuma's name of the file
        | ;\$PATH .*                                     # where Sinumerik files the program
        | \d* [ \t]* BEGIN [ \t]+ PGM .*                 # head of Klartext
        | (?:[O:] \d+ | <[^<>]+>) [ \t]* (?:\(.*\))? ;?  # number or name: controls drop what comes before it
        | (?:N\d+)? [ \t]* \(ID, .*                      # GE 2000T's name of the program
    )?\s*""",
    re.IGNORECASE | re.VERBOSE,
)
"""A block that has to be among a program's first, or an empty one. `O100 sub` is a block of LinuxCNC's like others."""


def insert_heading(program: Program, texts: Sequence[str]) -> Edit:
    """Writes blocks behind those that have to be first, numbered as the program is; at the top where there are none."""
    last = _last_of_heading(program)
    if last is None:
        top = program.block(0).start if program.block_count else len(program.source)  # behind a byte order mark
        return Edit(top, top, "".join(f"{text}{line_ending(program)}" for text in texts))
    return insert_blocks_after(program, last, texts)


def _last_of_heading(program: Program) -> int | None:
    last = None
    for index in range(program.block_count):
        block = program.block(index)
        text = program.source[block.start : block.end]
        if not _HAS_TO_BE_FIRST.fullmatch(text):
            break
        if text.strip():
            last = index
    return last
