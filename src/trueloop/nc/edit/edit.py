"""Editing by span: an edit replaces bytes of the source; everything else stays as it was.

Lengths given are millimetres with X as a radius; inch and diameter are dealt with here, from the `CoordinateState` of
the move. Results are rounded to the control's resolution.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import pairwise
from typing import Final

from trueloop.errors import Code
from trueloop.nc.edit.number_text import digits_of, number_text, resolution_of, restyled, rounded, with_term
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import CoordinateState

AXES: Final = frozenset("XYZ")
CODES: Final = frozenset({"N", "G", "M", ""})
"""Letters of the words before which no coordinate is written; names have none."""


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
    source, pieces, done = program.source, [], 0
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.end)):
        if not done <= edit.start <= edit.end <= len(source):
            raise Code.NC_EDIT.refusal(
                f"the edit of bytes {edit.start} to {edit.end} overlaps another or lies outside the program",
                hint="edit each word once",
                place=program.place(min(edit.start, len(source))),
            )
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
    unit_mm, resolution = state.unit_mm(letter), resolution_of(program.dialect, state)
    delta = rounded(delta_mm / unit_mm, resolution)
    if delta == 0:
        return None, 0.0
    if word.is_expression:
        text = with_term(program, word, delta, state)
        if text is None:
            raise Code.NC_EDIT.refusal(
                f"{word.text} is an expression that takes no sum, and would have to be moved by {delta_mm:.4g} mm",
                hint="write the coordinate as a number",
                place=program.place(word.start),
            )
        return Edit(word.value_start, word.end, text), float(delta) * unit_mm
    old = program.source[word.value_start : word.end].decode("latin-1")
    given = Decimal(digits_of(old))
    new = rounded(given + Decimal(delta_mm) / Decimal(unit_mm), resolution)
    edit = Edit(word.value_start, word.end, restyled(program.dialect, old, new, state))
    return edit, float(new - given) * unit_mm


def _as_positions(program: Program, word: Word) -> str:
    """How positions are given to a control. G90 of a lathe of code system A cuts."""
    if word.letter in "UVW":
        return f"{'XYZ'['UVW'.index(word.letter)]} in place of {word.letter}"
    return "take the increment out of the word" if word.increment else "G90"


def coordinate_text(dialect: Dialect, letter: str, value_mm: float, state: CoordinateState) -> str:
    """Returns a word that sets that coordinate, with as many decimals as the control resolves: `X2.98422`."""
    value = rounded(value_mm / state.unit_mm(letter), resolution_of(dialect, state))
    address = dialect.radius_address if letter == "R" else letter
    return address + number_text(dialect, value, state)


def line_texts(dialect: Dialect, places: Sequence[str]) -> list[str]:
    """Blocks that go straight at feed from place to place, each given by its coordinates."""
    if dialect.klartext:
        return [f"L {place}" for place in places]
    return [f"G01 {place}" if index == 0 else place for index, place in enumerate(places)]


def insert_word(program: Program, block: int, letter: str, value_mm: float, state: CoordinateState) -> Edit:
    """Writes a word into a block that inherits that coordinate, in the order X, Y, Z and before all other data."""
    text = coordinate_text(program.dialect, letter, value_mm, state)
    words = program.block(block).words
    before = [word for word in words if _comes_before(program, words, word, letter)]
    if not words:
        empty = program.block(block)
        return Edit(empty.start, empty.start, text + (" " if empty.end > empty.start else ""))
    spaced = any(left.end < right.start for left, right in pairwise(words))
    space = " " if spaced or len(words) == 1 else ""
    if before:
        return Edit(before[-1].end, before[-1].end, space + text)
    return Edit(words[0].start, words[0].start, text + space)


def _comes_before(program: Program, words: Sequence[Word], word: Word, letter: str) -> bool:
    """Whether a coordinate is written behind a word: number, code, name or earlier axis; Klartext's L comes first."""
    if word.letter in AXES:
        return word.letter < letter
    if program.dialect.klartext:
        return word.letter == "N" or word is next((other for other in words if other.letter != "N"), None)
    return word.letter in CODES


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
    value = rounded(value_mm / written.unit_mm(axis), resolution_of(program.dialect, written))
    return Edit(statement.value_start, statement.value_end, restyled(program.dialect, old, value, written))


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
