"""Tools, M functions and other words of a block that do not move it."""

import re
from collections.abc import Iterator
from typing import Final

from trueloop.errors import Severity
from trueloop.nc.program.program import Word
from trueloop.nc.translate.executed import Executed, Said, Source
from trueloop.nc.translate.statements import Dwell, End, Lost, SpeedLimit, Switch, ToolChange, Verbatim

BEFORE: Final = frozenset({3, 4, 7, 8})
"""M codes that mean the same everywhere and are done before the block's move."""
AFTER: Final = frozenset({0, 1, 5, 9})
CANCELS: Final = frozenset({13.1, 15.0, 49.0, 50.0, 67.0, 69.0, 80.0, 113.0})
"""G codes that switch off what this program cannot have switched on: that is an error of its own."""
SILENT: Final = re.compile(r"BEGIN PGM|END PGM|CYCL DEF 7\.0|PROC|EXTERN|FN ?([0-8]|13):")
DRAWN_TEXTS: Final = ("BLK FORM", "TOOL DEF", "CYCL DEF 9.0")
KLARTEXT_DWELL: Final = re.compile(r"CYCL DEF 9\.1\D*([\d.]+)", re.IGNORECASE)


def functions_before(source: Source, executed: Executed) -> Iterator[Said]:
    """What comes before the block's moves."""
    for word in executed.block.data:
        meaning = executed.meanings.get(word.index, "")
        if word.letter == "T":
            yield from _tool_word(source, executed, word)
        elif meaning.startswith("M") and word.letter == "M":
            yield from _function(source, executed, word, meaning)
        elif meaning == "Inert" and word.letter != "M":
            yield from _inert(source, word)


def functions_after(executed: Executed) -> Iterator[Said]:
    """What comes after them."""
    for word in executed.block.data:
        if word.letter == "M" and word.kind == "number" and int(word.value) in AFTER:
            yield word, Switch(int(word.value))
        elif word.kind == "name" and word.text.upper().startswith("STOP") and word.text.upper() != "STOPRE":
            yield word, Switch(0)
    end = executed.codes.get("MEnd")
    if end is not None:
        yield end, End(int(end.value))


def _function(source: Source, executed: Executed, word: Word, meaning: str) -> Iterator[Said]:
    code = int(word.value) if word.kind == "number" else -1
    if code in BEFORE:
        yield word, Switch(code)
    elif code == 6:
        yield from _change(source, executed, word)
    elif meaning == "MInert" and code not in AFTER and source.same:
        yield word, Verbatim(word.text.strip())
    elif meaning == "MInert" and code not in AFTER:
        moves = code >= source.control.functions_that_move
        severity = Severity.ERROR if moves else Severity.WARNING
        yield word, Lost(severity, "the control or its builder says what it does")


def _tool_word(source: Source, executed: Executed, word: Word) -> Iterator[Said]:
    number = int(source.path.states["tool"][executed.state])
    way = source.control.tool_offset
    if number < 0 or '"' in word.text:
        yield word, Lost(Severity.ERROR, "a tool without a number")
    elif way == "T" and number >= 100:
        yield word, ToolChange(number // 100, number % 100, by_m6=False)
    elif way == "T":
        yield word, ToolChange(number, None, by_m6=False)
    elif way == "call":
        yield word, ToolChange(number, number, by_m6=True)
    elif way == "D" and not source.changes_by_m6:
        yield from _with_edge(executed, word, number, by_m6=False)
    elif not source.changes_by_m6:
        yield word, Lost(Severity.WARNING, "a tool that is only made ready: the program does not change to it")


def _change(source: Source, executed: Executed, word: Word) -> Iterator[Said]:
    number = int(source.path.states["tool"][executed.state])
    if number < 0 or (number == 0 and source.names_tools):
        yield word, Lost(Severity.ERROR, "a change to a tool without a number")
    elif source.control.tool_offset == "D":
        yield from _with_edge(executed, word, number, by_m6=True)
    else:
        yield word, ToolChange(number, None, by_m6=True)


def other_edge(edge: Word) -> Iterator[Said]:
    """An edge beside the first has lengths of its own: no control that is written to is given them."""
    if edge.value > 1:
        yield edge, Lost(Severity.ERROR, "the offsets of the tool's first edge are taken for that edge's")


def _with_edge(executed: Executed, word: Word, number: int, *, by_m6: bool) -> Iterator[Said]:
    """A tool of Sinumerik: its first edge is in force with it unless D says otherwise."""
    edge = executed.number("D")
    row = number if edge is None or edge.value != 0 else 0
    if edge is not None:
        yield from other_edge(edge)
    yield word, ToolChange(number, row, by_m6=by_m6)


def _inert(source: Source, word: Word) -> Iterator[Said]:
    text = word.text.strip().upper()
    dwell = KLARTEXT_DWELL.match(text)
    if dwell is not None:
        yield word, Dwell(float(dwell[1]))
    elif text.startswith("LIMS"):
        yield from _limit(word)
    elif source.same and word.kind != "name":
        yield word, Verbatim(word.text.strip())
    elif not _is_said(word, text):
        drawn = text.startswith(DRAWN_TEXTS) or (word.letter == "G" and word.value in CANCELS)
        why = "not written: nothing here needs it" if drawn else "what it asks for is not written"
        yield word, Lost(Severity.NOTE if drawn else Severity.WARNING, why)


def _is_said(word: Word, text: str) -> bool:
    """Whether it is in the path, or is said by another statement."""
    stop = text.startswith("STOP") and text != "STOPRE"
    return stop or bool(SILENT.match(text))


def _limit(word: Word) -> Iterator[Said]:
    try:
        yield word, SpeedLimit(float(word.text.partition("=")[2]))
    except ValueError:
        yield word, Lost(Severity.WARNING, "the greatest spindle speed is no plain number")
