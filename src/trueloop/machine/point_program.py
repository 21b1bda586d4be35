"""Correcting a program of points, such as a drilling program, by a planar field: X and Y of every block, in place.

Works on the words, not on the tool path, because drilling cycles and a shop's own macros need not be understood for
it. Only X and Y words change; where a block names one of them, the other is written in when its correction differs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.machine.planar_field import PlanarField
from trueloop.nc.edit import Edit, displace_word, insert_word
from trueloop.nc.program import Block, Program, Word
from trueloop.nc.tool_path import CoordinateState

NO_POSITIONS: Final = frozenset({4.0, 10.0, 28.0, 30.0, 52.0, 53.0, 68.0, 92.0})
"""G codes whose X and Y are a time, set a coordinate system, or stand in machine coordinates: G4, G10, G28, G30, G52,
G53, G68, G92."""

NOT_FOLLOWED: Final = frozenset({16.0, 51.0, 51.1})
"""G codes after which X and Y are no positions of the plane: polar, scaled or mirrored ones."""


@dataclass(frozen=True)
class _Point:
    block: Block
    words: dict[str, Word]
    position: tuple[float, float]
    before: tuple[float, float]
    state: CoordinateState


def displace_points(program: Program, field: PlanarField, no_positions: frozenset[float] = NO_POSITIONS) -> list[Edit]:
    """Edits that add −E(x, y) to every programmed point. Blocks with a G code of `no_positions` are left alone.

    Raises MCH-PROGRAM for an incremental coordinate or one that is computed when the program runs.
    """
    if program.dialect.formulas:
        raise TrueloopError(
            Code.MCH_PROGRAM,
            f"programs of the dialect {program.dialect.name} are not corrected point by point",
            hint="have the program written for another control",
            place=program.place(0),
        )
    points = list(_points(program, no_positions))
    if not points:
        return []
    at = -field.error_mm(np.array([point.position for point in points]))
    before = -field.error_mm(np.array([point.before for point in points]))
    edits = []
    for point, correction, last in zip(points, at, before, strict=True):
        for k, letter in enumerate("XY"):
            word = point.words.get(letter)
            if word is not None:
                edit = displace_word(program, word, float(correction[k]), point.state)
            elif abs(correction[k] - last[k]) > 0.5 * program.dialect.step_mm(point.state.inch):
                value = point.position[k] + float(correction[k])
                edit = insert_word(program, point.block.index, letter, value, point.state)
            else:
                edit = None
            edits += [] if edit is None else [edit]
    return edits


def _points(program: Program, no_positions: frozenset[float]) -> Iterator[_Point]:
    """Every block with an X or Y word, with the position it leads to and the one before, in mm."""
    last, inch, incremental = {"X": 0.0, "Y": 0.0}, False, False
    for block in program.blocks:
        codes = {word.value for word in block.words if word.letter == "G" and word.kind == "number"}
        for word in block.words:
            if word.letter == "G" and word.value in NOT_FOLLOWED:
                raise _no_point(program, word, "a frame that is not followed here")
        inch = 20 in codes or (inch and 21 not in codes)
        incremental = 91 in codes or (incremental and 90 not in codes)
        words = {word.letter: word for word in block.words if word.letter in ("X", "Y")}
        if not words or codes & no_positions:
            continue
        state = CoordinateState(inch=inch, diameter=False)
        for word in words.values():
            if incremental or word.kind != "number":
                raise _no_point(program, word, "an increment" if incremental else "computed when the program runs")
        before = (last["X"], last["Y"])
        last |= {letter: word.value * state.unit_mm(letter) for letter, word in words.items()}
        yield _Point(block, words, (last["X"], last["Y"]), before, state)


def _no_point(program: Program, word: Word, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_PROGRAM,
        f"{word.text} in block {word.block + 1} is {why}: positions are not known from the words",
        hint="write the points as numbers in absolute coordinates (G90)",
        place=program.place(word.start),
    )
