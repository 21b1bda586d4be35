"""The moves of a block in no control's words."""

import math
from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.errors import Severity
from trueloop.nc.program.along import PLANE_AXES, lengths_mm
from trueloop.nc.program.program import Word
from trueloop.nc.program.tool_path import INVERSE_TIME, Motion, ToolPath
from trueloop.nc.translate.executed import Course, Executed, Said, Source
from trueloop.nc.translate.statements import Circle, Compensation, Home, Lost, Partial, Straight, Thread, Vector
from trueloop.nc.translate.stretches import STANDS_MM
from trueloop.units import MM_PER_INCH

AXES: Final = (*"XYZ", *"UVW")
BY_INCREMENT: Final = frozenset("UVWnAa")
"""U, V, W, and the angle of a line, from where the tool stands."""


def moves_of(
    source: Source, course: Course, executed: Executed, compensation: Compensation | None
) -> Generator[Said, None, Course]:
    """What the block moves; the compensation goes with its first move where that is straight."""
    codes, path, moves = executed.codes, source.path, executed.moves
    home = codes.get("Home") or codes.get("HomeNamed")
    straight = bool(moves) and path.motion[moves[0]] in (Motion.RAPID, Motion.LINE) and home is None
    if compensation is not None and not straight:
        yield codes["Compensation"], compensation
        compensation = None
    if home is not None:
        return (yield from _home(source, course, executed, home))
    for move in moves:
        word = _word_of(source, executed, move)
        if "MachineCoordinates" in codes:
            course = yield from _machine(source, course, executed, move, word)
            continue
        yield from _unknown(source, course, move, word)
        course = yield from _move(source, course, executed, move, word, compensation)
        compensation = None
    return course


def waiting_moves(source: Source, course: Course, executed: Executed) -> Generator[Said, None, Course]:
    """The moves of earlier blocks that waited for this one."""
    for move in executed.before:
        word = source.program.block(int(source.path.block[move])).data[0]
        yield from _unknown(source, course, move, word)
        course = yield from _move(source, course, executed, move, word, None)
    return course


def _word_of(source: Source, executed: Executed, move: int) -> Word:
    """The first word that set a coordinate of a move, else the block's first."""
    own = [int(word) for word in source.path.word[move] if word >= 0]
    return source.program.word(min(own)) if own else executed.block.data[0]


def _move(
    source: Source, course: Course, executed: Executed, move: int, word: Word, compensation: Compensation | None
) -> Generator[Said, None, Course]:
    path, kind = source.path, Motion(source.path.motion[move])
    end_mm = _end(path, move, course.shift_mm)
    touched = frozenset(axis for axis in range(3) if end_mm[axis] is not None)
    if not np.isfinite(path.end_mm[move]).all():
        yield word, Lost(Severity.ERROR, "a position that is not known", refuses=True)
    elif kind == Motion.PROBE:
        yield word, Lost(Severity.ERROR, "probing moves are left out")
        return replace(course, known=course.known - touched)
    elif kind == Motion.THREAD:
        yield from _thread(source, move, word, end_mm)
    elif kind == Motion.ARC:
        yield word, _circle(path, move, course.shift_mm)
    else:
        yield word, Straight(kind == Motion.RAPID, end_mm, feed_of(path, move), compensation)
    return replace(course, known=course.known | touched) if not touched <= course.known else course


def _end(path: ToolPath, move: int, shift_mm: Vector) -> Partial:
    """The end along the axes that are named or move."""
    moves = (path.word[move] >= 0) | (np.abs(path.end_mm[move] - path.start_mm[move]) > STANDS_MM)
    x, y, z = (
        at + shift if named else None
        for at, shift, named in zip(path.end_mm[move].tolist(), shift_mm, moves.tolist(), strict=True)
    )
    return x, y, z


def _shifted(at_mm: np.ndarray, shift_mm: Vector) -> Vector:
    x, y, z = (at + shift for at, shift in zip(at_mm.tolist(), shift_mm, strict=True))
    return x, y, z


def _circle(path: ToolPath, move: int, shift_mm: Vector) -> Circle:
    plane = int(path.plane[move])
    third = 3 - sum(PLANE_AXES[plane])
    return Circle(
        _shifted(path.start_mm[move], shift_mm),
        _shifted(path.end_mm[move], shift_mm),
        _shifted(path.centre_mm[move], shift_mm),
        float(path.sweep_rad[move]),
        plane,
        _end(path, move, shift_mm)[third] is not None,
        feed_of(path, move),
    )


def feed_of(path: ToolPath, move: int) -> float | None:
    """mm/min or mm/rev of a cut; a time given (G93) becomes a feed a minute."""
    feed = float(path.feed[move])
    if path.rapid[move] or math.isnan(feed):
        return None
    timed = path.feed_mode[move] == INVERSE_TIME
    return feed * float(lengths_mm(path, np.array([move]))[0]) if timed else feed


def _thread(source: Source, move: int, word: Word, end_mm: Partial) -> Iterator[Said]:
    """The feed of such a move is its lead, whatever word says it."""
    lead_mm = float(source.path.feed[move])
    if math.isnan(lead_mm):
        yield word, Lost(Severity.ERROR, "a thread whose lead is not known", refuses=True)
        return
    along_mm = np.abs(source.path.end_mm[move] - source.path.start_mm[move])
    axis = 2 - int(np.argmax(along_mm[::-1]))
    slant = float(np.linalg.norm(along_mm) / along_mm[axis]) if along_mm[axis] > 0 else 1.0
    if source.program.dialect.lead_along_thread:
        lead_mm /= slant
    yield word, Thread(end_mm, lead_mm / (MM_PER_INCH if source.path.inch[move] else 1.0), axis, slant)


def _machine(
    source: Source, course: Course, executed: Executed, move: int, word: Word
) -> Generator[Said, None, Course]:
    named = source.path.word[move] >= 0
    x, y, z = (
        at + offset if axis else None
        for at, offset, axis in zip(source.path.end_mm[move].tolist(), executed.offset_mm, named, strict=True)
    )
    yield word, Straight(bool(source.path.rapid[move]), (x, y, z), feed_of(source.path, move), machine=True)
    return replace(course, known=course.known - {axis for axis in range(3) if named[axis]})


def _home(source: Source, course: Course, executed: Executed, word: Word) -> Generator[Said, None, Course]:
    """Home from where the tool stands, along the axes named or all of them; by way of another place it is lost."""
    incremental = bool(source.path.states["incremental"][executed.state])
    found = [w for w in executed.block.words if w.letter in AXES]
    axes = tuple(sorted({AXES.index(w.letter) % 3 for w in found})) or (0, 1, 2)
    stands = all(w.value == 0 and (w.letter in AXES[3:] or incremental) for w in found)
    if executed.meanings[word.index] in ("Home(1)", "HomeNamed(1)") or not stands:
        yield word, Lost(Severity.ERROR, "the way home by another place, or to the second reference point, is left out")
    elif executed.moves:
        yield word, Home(axes)
    return replace(course, known=course.known - set(axes))


def _unknown(source: Source, course: Course, move: int, word: Word) -> Iterator[Said]:
    """An increment, or a move by no word, from where the program has not positioned an axis is no position."""
    path = source.path
    moves = np.abs(path.end_mm[move] - path.start_mm[move]) > STANDS_MM
    in_plane = PLANE_AXES[int(path.plane[move])] if path.motion[move] == Motion.ARC else ()
    for axis in set(range(3)) - course.known:
        index = int(path.word[move, axis])
        by = source.program.word(index) if index >= 0 else None
        if (by is None and (moves[axis] or axis in in_plane)) or (by is not None and _is_increment(by, path, move)):
            what = f"{'XYZ'[axis]} is not known here: taken to stand at zero where the program began"
            yield by or word, Lost(Severity.ERROR, what)


def _is_increment(word: Word, path: ToolPath, move: int) -> bool:
    if word.increment is not None:
        return word.increment
    return word.letter in BY_INCREMENT or bool(path.incremental[move])
