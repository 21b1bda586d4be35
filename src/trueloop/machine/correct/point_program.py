"""Correcting a program of points, such as a drilling program, by a planar field: X and Y of every block, in place.

Works on the words, not on the tool path, because drilling cycles and a shop's own macros need not be understood for
it. Only X and Y words change; where a block names one of them, the other is written in when its correction differs.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.machine.standards.planar_field import PlanarField
from trueloop.nc.edit.edit import Edit, displace_word, insert_word
from trueloop.nc.field.field import Field
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import CoordinateState
from trueloop.units import UM_PER_MM

IN_NO_CASE: Final = frozenset({4.0, 68.0})
"""G codes whose X and Y are a time and the centre of a rotation: G4, G68."""

NO_POSITIONS: Final = IN_NO_CASE | {10.0, 28.0, 30.0, 52.0, 53.0, 92.0}
"""Those, and the ones that set a coordinate system or go to a place of the machine: G10, G28, G30, G52, G53, G92."""

NOT_FOLLOWED: Final = {
    2.0: "an arc, whose centre would stay",
    3.0: "an arc, whose centre would stay",
    7.0: "diameter mode",
    16.0: "polar coordinates",
    51.0: "a scaled frame",
    51.1: "a mirrored frame",
}
"""G codes after which X and Y are not, or not only, points of the plane."""


ROTARY: Final = frozenset("ABC")
MACRO_CALLS: Final = frozenset({65.0, 66.0, 66.1})
_UNITS: Final = {"mm": False, "inch": True}


@dataclass(frozen=True)
class TableField:
    """The error that a table of displacements undoes: E = −displacement. Raises MCH-PROGRAM for more than a plane."""

    field: Field

    def __post_init__(self) -> None:
        nodes = self.field.identity["nodes"]
        if isinstance(nodes, list) and nodes[2] > 1:
            raise TrueloopError(
                Code.MCH_PROGRAM,
                f"the table has {nodes[2]} values of z_mm: points of a plane have none",
                hint="leave z_mm and dz out, or give the table to `trueloop nc map`",
            )

    def error_mm(self, point_mm: Array) -> Array:
        """E at (n, 2) points. Raises NC-FIELD outside of the table."""
        moved = self.field.displacement_mm(np.column_stack([point_mm, np.zeros(len(point_mm))]))
        if np.any(moved[:, 2]):
            raise TrueloopError(
                Code.MCH_PROGRAM,
                f"the table displaces Z by {UM_PER_MM * np.abs(moved[:, 2]).max():.1f} µm: points have X and Y only",
                hint="leave dz out, or give the table to `trueloop nc map`",
            )
        return -moved[:, :2]


@dataclass(frozen=True)
class Displaced:
    """A program's edits, where its points are to be (n, 2), the largest correction of X and of Y, and its byte."""

    edits: list[Edit]
    wanted_mm: Array
    largest_mm: tuple[float, float]
    largest_at: int


@dataclass(frozen=True)
class _Point:
    block: Block
    words: dict[str, Word]
    position: tuple[float, float]
    state: CoordinateState


def displace_points(program: Program, field: PlanarField, no_positions: frozenset[float] = NO_POSITIONS) -> Displaced:
    """Adds −E(x, y) to every programmed point. Blocks with a G code of `no_positions` are left alone.

    Words are as fine afterwards as the control resolves, or as the program itself writes them. The plane is that of the
    words: under a rotation (G68) the field turns with it. Raises MCH-PROGRAM for a dialect that is no mill's, an
    incremental coordinate, one that is computed when the program runs, arcs, and frames that are not followed.
    """
    if not program.dialect.plane_of_points:
        mills = sorted(name for name, dialect in DIALECTS.items() if dialect.plane_of_points)
        raise TrueloopError(
            Code.MCH_PROGRAM,
            f"programs of the dialect {program.dialect.name} are not corrected point by point: {len(mills)} mills' are",
            hint=f"have it written for another control, or say which this is: --dialect {' or '.join(mills)}",
            place=program.place(0),
        )
    points = list(_points(program, no_positions))
    if not points:
        return Displaced([], np.empty((0, 2)), (0.0, 0.0), 0)
    at = -_error_mm(program, field, points)
    before = np.vstack([at[:1], at[:-1]])
    edits = [
        edit
        for point, correction, last in zip(points, at, before, strict=True)
        for edit in _edits(program, point, correction, last)
    ]
    size = np.abs(at)
    x, y = size.max(axis=0).tolist()
    worst = points[int(size.max(axis=1).argmax())]
    wanted = np.array([point.position for point in points]) + at
    return Displaced(edits, wanted, (x, y), min(word.start for word in worst.words.values()))


def off_mm(
    written: Program, wanted_mm: Array, no_positions: frozenset[float] = NO_POSITIONS
) -> list[tuple[int, float]]:
    """How far the points of a written program are from where they shall be: line and distance along X or Y of those
    that are further off than a step of the control; line 0 and infinity where there are more or fewer.
    """
    points = list(_points(written, no_positions))
    if len(points) != len(wanted_mm):
        return [(0, math.inf)]
    off = np.abs(np.array([point.position for point in points]).reshape(-1, 2) - wanted_mm).max(axis=1)
    step = [written.dialect.step_mm(point.state.inch) for point in points]
    return [(points[k].block.line, float(off[k])) for k in np.flatnonzero(off > step)]


def _error_mm(program: Program, field: PlanarField, points: Sequence[_Point]) -> Array:
    """E at every point, (n, 2); what the field refuses is refused at the block."""
    try:
        return field.error_mm(np.array([point.position for point in points]))
    except TrueloopError:
        for point in points:
            with in_file(program.file or "program", point.block.line):
                field.error_mm(np.array([point.position]))
        raise


def _edits(program: Program, point: _Point, correction: Array, before: Array) -> Iterator[Edit]:
    for k, letter in enumerate("XY"):
        word = point.words.get(letter)
        if word is not None:
            edit = displace_word(program, word, float(correction[k]), point.state)
        elif abs(correction[k] - before[k]) > 0.5 * program.dialect.step_mm(point.state.inch):
            value = point.position[k] + float(correction[k])
            edit = insert_word(program, point.block.index, letter, value, point.state)
        else:
            continue
        if edit is not None:
            yield edit


def _points(program: Program, no_positions: frozenset[float]) -> Iterator[_Point]:
    """Every block with an X or Y word, with the position it leads to in mm."""
    last: dict[str, float] = {}
    angles = {word.letter: math.nan for block in program.blocks for word in _rotary(block)}
    inch, incremental = _UNITS.get(program.unit or ""), False
    for block in program.blocks:
        codes = {word.value for word in block.words if word.letter == "G" and word.kind == "number"}
        for word in block.words:
            if word.letter == "G" and word.value in NOT_FOLLOWED:
                raise _no_point(program, word, NOT_FOLLOWED[word.value])
        inch = _unit(program, block, inch, first=not last)
        incremental = 91 in codes or (incremental and 90 not in codes)
        for word in _rotary(block):
            angles[word.letter] = word.value if word.kind == "number" and not incremental else math.nan
        words = {word.letter: word for word in block.words if word.letter in ("X", "Y")}
        if not words or codes & no_positions:
            continue
        first = next(iter(words.values()))
        if inch is None:
            raise _no_unit(program, first)
        for axis, angle in angles.items():
            if angle % 360.0 != 0.0:  # NaN as well
                raise _no_point(program, first, f"a point where {axis} does not stand at 0 degrees, or is not known to")
        state = CoordinateState(inch=inch, diameter=False)
        for word in words.values():
            if incremental or word.kind != "number":
                raise _no_point(program, word, "an increment" if incremental else "computed when the program runs")
        last |= {letter: word.value * state.unit_mm(letter) for letter, word in words.items()}
        if len(last) < 2:
            raise _no_point(program, next(iter(words.values())), "one of X and Y, and the other has no position yet")
        yield _Point(block, words, (last["X"], last["Y"]), state)


def _rotary(block: Block) -> list[Word]:
    """Words of rotary axes; in a block that calls a macro these letters are its arguments."""
    words = [word for word in block.words if word.letter in ROTARY and word.kind in ("number", "expression")]
    calls = words and any(word.letter == "G" and word.value in MACRO_CALLS for word in block.words)
    return [] if calls else words


def _unit(program: Program, block: Block, inch: bool | None, *, first: bool) -> bool | None:
    """Whether the unit is the inch after the codes of a block; None while nothing says so.

    Raises NC-UNIT where the block states, before the first point, another unit than the one given.
    """
    stated = [word for word in block.words if word.letter == "G" and word.kind == "number" and word.value in (20, 21)]
    if not stated or block.skipped:
        return inch
    now = stated[-1].value == 20
    if first and inch is not None and program.unit is not None and now is not inch:
        raise TrueloopError(
            Code.NC_UNIT,
            f"{stated[-1].text} states {'inch' if now else 'mm'}, and the unit was given as {program.unit}",
            hint="leave --unit out: the program states its unit itself",
            place=program.place(stated[-1].start),
        )
    return now


def _no_unit(program: Program, word: Word) -> TrueloopError:
    return TrueloopError(
        Code.NC_UNIT,
        f"the program does not state its unit before its first length, {word.text}: 1 is 1 mm or 25.4 mm",
        hint="write G20 or G21 before it, or say which unit is in force at the start: --unit mm or --unit inch",
        place=program.place(word.start),
    )


def _no_point(program: Program, word: Word, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_PROGRAM,
        f"{word.text} in block {word.block + 1} is {why}: positions are not known from the words",
        hint="write the points as numbers in absolute coordinates (G90); paths are for `trueloop nc map`",
        place=program.place(word.start),
    )
