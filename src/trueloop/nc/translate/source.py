"""What a program does, block by block as it was executed, in no control's words."""

import math
import re
from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import Final, TypeAlias

from trueloop.errors import Severity
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import NO_COMPENSATION, PER_REVOLUTION
from trueloop.nc.translate.executed import Course, Executed, Said, Source, executed_block
from trueloop.nc.translate.functions import functions_after, functions_before, other_edge
from trueloop.nc.translate.losses import lost_in_findings, lost_in_words, not_run
from trueloop.nc.translate.moves import moves_of, waiting_moves
from trueloop.nc.translate.statements import (
    Compensation,
    Dwell,
    End,
    LengthOffset,
    Lost,
    Modes,
    Partial,
    Register,
    Remark,
    SpeedLimit,
    Spindle,
    Vector,
    WorkOffset,
)
from trueloop.nc.translate.stretches import straights, stretches_of

Reading: TypeAlias = Generator[Said, None, Course]

SHIFTS: Final = frozenset(
    {"OffsetRegister", "Shift", "ToolOffset", "NoToolOffset", "CancelRegister", "RestoreRegister"}
)
"""What changes coordinates by an amount that the program says: added to the positions."""
COMMENTS: Final = {
    "(": re.compile(r"\(([^)\n]*)\)"),
    ";": re.compile(r";(.*)"),
    "!": re.compile(r"!(.*)"),
    "*": re.compile(r"^\s*\d*\s*\*(.*)"),
}
OPENINGS: Final = {"linuxcnc": "(;", "ge2000t": "!", "siemens": ";", "heidenhain": ";*"}
"""What begins a comment; `(` for all others."""
SIDES: Final = {"Off": 40, "Left": 41, "Right": 42}


def statements(source: Source) -> Iterator[Said]:
    """Everything that the program does, with the word that says it; of stretches of straight moves no word."""
    yield from lost_in_findings(source)
    yield from not_run(source)
    course, commented, stretches, row = Course(), set[int](), stretches_of(source), 0
    while row < len(source.path.executed):
        end = stretches.end(row, course) if _stands(source, course, row) else row
        if end > row:
            yield None, straights(source, course, row, end)
            row = end
            continue
        executed = executed_block(source.program, source.path, row)
        if executed.block.index not in commented:
            commented.add(executed.block.index)
            yield from ((None, Remark(text)) for text in comments(source.program, executed))
        if executed.block.data:
            course = yield from _block(source, course, executed)
        row += 1
    if not course.ended:
        yield None, End(30)


def comments(program: Program, executed: Executed) -> Iterator[str]:
    """The texts of a block's comments; what looks like one within another is part of it."""
    block = executed.block
    text = program.source[block.start : block.end].decode("latin-1")
    openings = OPENINGS.get(program.dialect.name, "(")
    matches = [(opening, found) for opening in openings for found in COMMENTS[opening].finditer(text)]
    end = 0
    for opening, found in sorted(matches, key=lambda match: match[1].start()):
        at = block.start + found.start()
        in_word = any(word.start <= at < word.end for word in block.words if opening != "*")
        if found.start() >= end and found[1].strip() and not in_word:
            end = found.end()
            yield found[1].strip()


def _block(source: Source, course: Course, executed: Executed) -> Reading:
    course = yield from waiting_moves(source, course, executed)
    if executed.moves or executed.codes:
        course = yield from _modes(source, course, executed)
    course = yield from _frame(source, course, executed)
    yield from lost_in_words(source, executed)
    course = yield from _spindle(source, course, executed)
    yield from functions_before(source, executed)
    yield from _dwell(source, executed)
    yield from _length_offset(source, executed)
    course, compensation = yield from _compensation(source, course, executed)
    course = yield from moves_of(source, course, executed, compensation)
    yield from functions_after(executed)
    return replace(course, ended=course.ended or "MEnd" in executed.codes)


def _stands(source: Source, course: Course, row: int) -> bool:
    """Whether modes and spindle of an executed block are those said last."""
    state = int(source.path.executed[row, 2])
    spindle = _spindle_at(source, state)
    return course.last.get("modes") == _modes_at(source, state) and spindle in (None, course.last.get("spindle"))


def _modes(source: Source, course: Course, executed: Executed) -> Reading:
    return (yield from once(course, "modes", _modes_at(source, executed.state), executed.block.data[0]))


def _modes_at(source: Source, state: int) -> Modes:
    states = source.path.states
    return Modes(
        bool(states["inch"][state]),
        bool(states["diameter"][state]),
        int(states["plane"][state]),
        bool(states["feed_mode"][state] == PER_REVOLUTION),
    )


def once(course: Course, kind: str, statement: Modes | Spindle, word: Word) -> Reading:
    """The statement where it is not the last one of its kind."""
    if course.last.get(kind) != statement:
        yield word, statement
    return replace(course, last={**course.last, kind: statement})


def _frame(source: Source, course: Course, executed: Executed) -> Reading:
    """Work offsets and the position register; what the program shifts itself is added to the positions."""
    codes = executed.codes
    selects = codes.get("WorkOffset") or codes.get("ExtendedOffset")
    if selects is not None:
        yield selects, WorkOffset(int(source.path.states["work_offset"][executed.state]))
        course = replace(course, known=frozenset())
    if codes.keys() & SHIFTS:
        course = _shifted(course, executed.offset_change_mm)
    if "SetRegister" in codes:
        course = yield from _register(source, course, executed)
    return course


def _shifted(course: Course, change_mm: Vector) -> Course:
    x, y, z = (old + change for old, change in zip(course.shift_mm, change_mm, strict=True))
    return replace(course, shift_mm=(x, y, z))


def _register(source: Source, course: Course, executed: Executed) -> Reading:
    """G92 or G50: with S the greatest speed, with axes the position register."""
    word, speed = executed.codes["SetRegister"], executed.number("S")
    if speed is not None:
        yield speed, SpeedLimit(speed.value)
    letters = {word.letter for word in executed.block.words}
    named = frozenset(axis for axis in range(3) if letters & {"XYZ"[axis], "UVW"[axis]})
    if not named:
        return course
    if source.target.register is not None:
        at: Partial = tuple(executed.at_mm[axis] if axis in named else None for axis in range(3))  # type: ignore[assignment]
        yield word, Register(at)
        x, y, z = (0.0 if axis in named else shift for axis, shift in enumerate(course.shift_mm))
        return replace(course, shift_mm=(x, y, z), known=course.known | named)
    if named <= course.known:
        return _shifted(course, executed.offset_change_mm)
    yield word, Lost(Severity.ERROR, "the position register is set where the program has not positioned the tool")
    return replace(course, known=course.known | named)


def _spindle(source: Source, course: Course, executed: Executed) -> Reading:
    spindle = _spindle_at(source, executed.state)
    if spindle is None:
        return course
    return (yield from once(course, "spindle", spindle, executed.block.data[0]))


def _spindle_at(source: Source, state: int) -> Spindle | None:
    states = source.path.states
    speed = float(states["spindle_speed"][state])
    return None if math.isnan(speed) else Spindle(bool(states["spindle_mode"][state] == 96), speed)


def _dwell(source: Source, executed: Executed) -> Iterator[Said]:
    word = executed.codes.get("Dwell") or executed.codes.get("Pause")
    if word is None:
        return
    letters = source.control.dwell_letters
    found = executed.number("".join(letters))
    if found is None:
        yield word, Lost(Severity.WARNING, "its time is no plain number of seconds")
        return
    scale = letters[found.letter] if "." not in found.text else max(letters[found.letter], 1.0)
    yield word, Dwell(found.value * scale)


def _length_offset(source: Source, executed: Executed) -> Iterator[Said]:
    codes, way = executed.codes, source.control.tool_offset
    if "NoToolOffset" in codes:
        yield codes["NoToolOffset"], LengthOffset(None, on=False)
    edge = executed.number("D")
    if way == "D" and edge is not None and not any(word.letter == "T" for word in executed.block.words):
        yield from other_edge(edge)
        yield edge, LengthOffset(None, on=edge.value != 0)
    on = codes.get("ToolTableOffset")
    if on is None:
        return
    if on.value != 43:
        yield on, Lost(Severity.ERROR, "the tool's length is not compensated")
        return
    row = executed.number("H")
    yield on, LengthOffset(int(row.value) if row else None, on=True)


def _compensation(
    source: Source, course: Course, executed: Executed
) -> Generator[Said, None, tuple[Course, Compensation | None]]:
    """What the block changes of the compensation, to go with its first straight move."""
    word = executed.codes.get("Compensation")
    if word is None:
        return course, None
    side = SIDES[executed.meanings[word.index].partition("(")[2].rstrip(")")]
    named = executed.number("D") if source.control.names_compensation else None
    wanted = Compensation(side, int(named.value) if named and side != NO_COMPENSATION else None)
    if course.last.get("compensation") == wanted:
        return course, None
    if side != NO_COMPENSATION:
        what = "kept as it is: how the tool enters and rounds corners is the new control's own"
        yield word, Lost(Severity.WARNING, what)
    return replace(course, last={**course.last, "compensation": wanted}), wanted
