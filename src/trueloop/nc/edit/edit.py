"""Editing by span: an edit replaces bytes of the source; everything else stays as it was.

Lengths given are millimetres with X as a radius; inch and diameter are dealt with here, from the `CoordinateState` of
the move. Results are rounded to the control's resolution.
"""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from trueloop._core import nc_circle, nc_number, nc_restyled
from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import CoordinateState

_NUMBER: Final = re.compile(r"(?:AC|IC|DC)\s*\(\s*([-+]?[\d.]+)\s*\)\s*|([-+]?[\d.]+)\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Edit:
    """Bytes `start` to `end` of the source replaced by `text`."""

    start: int
    end: int
    text: str


def apply_edits(program: Program, edits: Iterable[Edit]) -> bytes:
    """Returns the source with the edits made. Insertions at one place keep the order given.

    Raises NC-EDIT when two edits overlap or one lies outside the source.
    """
    source, done = program.source, 0
    ordered = in_order(edits)
    for edit in ordered:
        if not done <= edit.start <= edit.end <= len(source):
            raise Code.NC_EDIT.refusal(
                f"the edit of bytes {edit.start} to {edit.end} overlaps another or lies outside the program",
                hint="edit each word once",
                place=program.place(min(edit.start, len(source))),
            )
        done = edit.end
    return spliced(source, ordered)


def in_order(edits: Iterable[Edit]) -> list[Edit]:
    """Returns edits by their places; insertions at one place as they are given."""
    return sorted(edits, key=lambda edit: (edit.start, edit.end))


def spliced(source: bytes, edits: Iterable[Edit]) -> bytes:
    """Returns bytes with edits made that do not overlap."""
    pieces, done = [], 0
    for edit in in_order(edits):
        pieces += [source[done : edit.start], edit.text.encode("latin-1")]
        done = edit.end
    return b"".join([*pieces, source[done:]])


def displace_word(program: Program, word: Word, delta_mm: float, state: CoordinateState) -> Edit | None:
    """Moves the coordinate that a word sets by delta_mm (X: on the radius); None when that rounds to nothing.

    A plain number is replaced by the sum, written in its own style; into an expression goes a term, inside the
    programmer's brackets. Raises NC-EDIT for an incremental coordinate: it would move everything that follows.
    """
    if state.incremental if word.increment is None else word.increment:
        raise Code.NC_EDIT.refusal(
            f"{word.text} is an increment: moving it by {delta_mm:.4g} mm would move all that follows",
            hint=f"program the contour by positions: {_as_positions(program, word)}",
            place=program.place(word.start),
        )
    if word.letter.islower():
        raise Code.NC_EDIT.refusal(
            f"{word.text} sets the end of its move by an angle or a radius: it cannot be moved",
            hint="program the contour by the coordinates of its points",
            place=program.place(word.start),
        )
    return moved_word(program, word, word.letter, delta_mm, state)[0]


def moved_word(
    program: Program, word: Word, letter: str, delta_mm: float, state: CoordinateState
) -> tuple[Edit | None, float]:
    """Changes what a word sets on the axis of `letter`, a position or an increment, by delta_mm (X: on the radius).

    Returns the edit, None where that rounds to nothing, and by how much the word is changed as written, mm. A plain
    number is replaced by the sum, written in its own style; into an expression goes a term.
    """
    dialect, unit_mm = program.dialect, state.unit_mm(letter, word.increment)
    with _writable(program, word):
        moved = program.core.moved(word.index, delta_mm / unit_mm, dialect.step(state.inch), dialect.decimal_comma)
    if moved is None:
        return None, 0.0
    start, end, text, by = moved
    return Edit(start, end, text), by * unit_mm


@contextmanager
def _writable(program: Program | None = None, word: Word | None = None) -> Iterator[None]:
    """Turns the core's refusal to write a number into NC-EDIT, at the word."""
    try:
        yield
    except ValueError as error:
        message, hint = error.args
        place = program.place(word.start) if program is not None and word is not None else None
        raise Code.NC_EDIT.refusal(message, hint=hint, place=place) from error


def _as_positions(program: Program, word: Word) -> str:
    """How positions are given to a control. G90 of a lathe of code system A cuts."""
    if word.letter in "UVW":
        return f"{'XYZ'['UVW'.index(word.letter)]} in place of {word.letter}"
    return "take the increment out of the word" if word.increment else "G90"


def number(dialect: Dialect, letter: str, value_mm: float, state: CoordinateState) -> tuple[str, float]:
    """Returns a new number of that word with as many decimals as the control resolves, and the coordinate that it then
    sets, mm.
    """
    unit_mm = state.unit_mm(letter)
    with _writable():
        text, value = nc_number(value_mm / unit_mm, dialect.step(state.inch), dialect.name, dialect.decimal_comma)
    return text, value * unit_mm


def coordinate_text(dialect: Dialect, letter: str, value_mm: float, state: CoordinateState) -> str:
    """Returns a word that sets that coordinate: `X2.98422`."""
    return letter + number(dialect, letter, value_mm, state)[0]


def rounded_mm(dialect: Dialect, letter: str, value_mm: float, state: CoordinateState) -> float:
    """Returns the coordinate, mm, of a word that is written with that value."""
    return number(dialect, letter, value_mm, state)[1]


def word_with(word: Word, value_mm: float, dialect: Dialect, state: CoordinateState) -> str:
    """Returns the text of a word that is a number, with another value: it is restyled, its address stays."""
    head, old = word.text[: word.value_start - word.start], word.text[word.value_start - word.start :]
    return head + _restyled(dialect, old, value_mm / state.unit_mm(word.letter), state)


def _restyled(dialect: Dialect, old: str, value: float, state: CoordinateState) -> str:
    """Returns a number of program units in the style of the old one."""
    step = dialect.step(state.inch)
    with _writable():
        return nc_restyled(old.encode("latin-1"), value, step, dialect.name, dialect.decimal_comma)


def number_said(word: Word) -> float:
    """Returns the number in a word, be it as `AC(5)`; NaN of a formula."""
    if word.kind == "number":
        return word.value
    found = _NUMBER.fullmatch(word.text[word.value_start - word.start :])
    return float(found.group(found.lastindex or 0)) if found else math.nan


def circle_text(
    program: Program,
    state: CoordinateState,
    axes: tuple[int, int],
    centre_mm: Array,
    start_mm: Array,
    *,
    by_radius: bool,
    end_mm: Array | None = None,
) -> str:
    """Returns the words of an arc's circle in the plane of two axes: its radius, or its centre from the start.

    `end_mm`: the centre is first moved along the chord, to be as far from both rounded ends.
    """
    dialect = program.dialect
    return nc_circle(
        *(axes, centre_mm.tolist(), start_mm.tolist(), by_radius, state.unit_mm("R"), dialect.step(state.inch)),
        *(dialect.name, dialect.decimal_comma),
        end_mm=None if end_mm is None else end_mm.tolist(),
    )


def line_texts(dialect: Dialect, places: Sequence[str]) -> list[str]:
    """Blocks that go straight at feed from place to place, each given by its coordinates."""
    if dialect.klartext:
        return [f"L {place}" for place in places]
    return [f"G01 {place}" if index == 0 else place for index, place in enumerate(places)]


def insert_word(program: Program, block: int, letter: str, value_mm: float, state: CoordinateState) -> Edit:
    """Writes a word into a block that inherits that coordinate: behind its number, its codes and the axes before."""
    at, text = program.core.inserted(block, coordinate_text(program.dialect, letter, value_mm, state))
    return Edit(at, at, text)


def set_offset(
    program: Program,
    axis: str,
    value_mm: float,
    state: CoordinateState,
    *,
    tool: int | None = None,
    diameter: bool | None = None,
) -> Edit:
    """Sets the value of the tool offset update of that axis (X: on the radius).

    diameter: whether the control takes X offsets as diameters, which depends on its set-up; as the coordinates are
    when not said. tool: which, when the program updates several. Raises NC-OFFSET when there is no such statement, or
    more than one.
    """
    found = [s for s in program.offset_statements if s.axis == axis and tool in (None, s.tool)]
    if len(found) != 1:
        which = f" of tool {tool}" if tool is not None else ""
        raise Code.NC_OFFSET.refusal(
            f"{len(found)} statements update the {axis} offset{which}; one is needed",
            hint=f"write one (UPD, tool, TOV({axis}), 0.00000) before the cut, or name the tool",
        )
    written = CoordinateState(state.inch, state.diameter if diameter is None else diameter)
    statement = found[0]
    old = program.source[statement.value_start : statement.value_end].decode("latin-1")
    text = _restyled(program.dialect, old, value_mm / written.unit_mm(axis), written)
    return Edit(statement.value_start, statement.value_end, text)


def replace_block(program: Program, block: int, texts: Sequence[str]) -> Edit:
    """Puts blocks in the place of one: the first keeps its number and comments, the others are numbered on from it."""
    old = program.block(block)
    _require_words(program, block, texts)
    data = old.data
    if not data:
        raise Code.NC_EDIT.refusal(
            "the block to be replaced is empty", hint="insert blocks after it instead", place=program.place(old.start)
        )
    first, last = data[0], data[-1]
    between = pairwise(data)
    comments = [program.source[left.end : right.start].decode("latin-1").strip() for left, right in between]
    head = " ".join([texts[0], *filter(None, comments)]) if texts else " ".join(filter(None, comments))
    tail = program.source[last.end : old.end].decode("latin-1")
    return Edit(first.start, old.end, head + tail + _new_lines(program, block, texts[1:]))


def insert_blocks_after(program: Program, block: int, texts: Sequence[str]) -> Edit:
    """Writes blocks after one, each on its line, numbered as the program numbers its blocks.

    N0420 is followed by N0421, N0422 …; without numbers when they do not fit before the next number, another block has
    one of them, or the program has none.
    """
    end = program.block(block).end
    _require_words(program, block, texts)
    return Edit(end, end, _new_lines(program, block, texts))


def _require_words(program: Program, block: int, texts: Sequence[str]) -> None:
    if program.dialect.klartext and not all(text.startswith((";", "L ")) for text in texts):
        raise Code.NC_EDIT.refusal(
            f"{len(texts)} new blocks would be needed here, and of moves in Klartext only lines are written",
            hint="have the program written in shorter moves, or as G code",
            place=program.place(program.block(block).start),
        )


def _new_lines(program: Program, block: int, texts: Sequence[str]) -> str:
    return program.core.new_lines(block, [text.encode("latin-1") for text in texts]).decode("latin-1")


def line_ending(program: Program) -> str:
    """Returns the line ending of the program."""
    at = program.source.find(b"\n")
    return "\r\n" if at > 0 and program.source[at - 1 : at] == b"\r" else "\n"
