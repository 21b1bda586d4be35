"""What the reading of a program loses: what it does not understand, and words that no statement carries."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.errors import Code, Finding, Severity
from trueloop.nc.program.program import PLAIN_MOVES, Block, Word
from trueloop.nc.program.understood import NOT_UNDERSTOOD
from trueloop.nc.translate.executed import Executed, Said, Source
from trueloop.nc.translate.statements import Lost

UNWRITTEN: Final = {
    "SetData": "the offset has to be entered at the control",
    "SetWorkOffset": "the offset has to be entered at the control",
    "StoreHome": "the position is not stored at the control",
    "CompensationGiven": "compensation by a tool whose size the program gives is not written",
    "OpaqueCycle": "its moves are not known",
    "OpaqueMotion": "its moves are not known",
    "OpaqueBlock": "its moves are not known",
    "OpaqueMode": "it changes where positions are",
}
"""What moves the tool, or changes where it is taken to be, and is not written."""
REPORTED: Final = frozenset({"Compensation", "ToolTableOffset", "Shift", *UNWRITTEN})
"""Codes whose NC-OPAQUE says no more than what is said of the code itself."""
CALLS: Final = frozenset({"MCallProgram", "MCallBlock", "CallMacro", "ModalMacro", "FinishContour"})
BY_PATH: Final = frozenset("XYZUVWIJKRFSTNOGMapqnijktmrcws")
"""Letters whose values are in the path and its states, or are said with their code."""
BY_CODE: Final = {
    "Dwell": "PXUFS",
    "Pause": "P",
    "CallMacro": "ABCDEHLPQ",
    "ModalMacro": "ABCDEHLPQ",
    "Groove": "DPQ",
    "ExtendedOffset": "P",
    "Pass": "Q",
    "Thread": "DEHLPQ",
    "ToolTableOffset": "H",
    "Compensation": "D",
    "Motion": "Q",
    "MCallProgram": "PL",
    "MCallBlock": "PL",
    "MReturn": "P",
    "MChangeTool": "DH",
    "FinishContour": "PQ",
    "RoughContour": "DPQ",
    "Profile": "DEPQ",
    "TurningCycle": "P",
}
"""Letters that a code takes with it."""
DRILLING: Final = "PQLKR"
"""Letters of drilling cycles: their holes stay in force, so any block may have them."""
MOVING: Final = frozenset("defg")
"""Klartext's DL, DR, DR2 and feeds a tooth: they change where or how fast the tool goes."""
FULL_DRILLING: Final = frozenset({73.0, 81.0, 83.0, 87.0})
"""Drilling cycles that are their moves and nothing else."""


def lost_in_findings(source: Source) -> Iterator[Said]:
    """What was not understood or is not in the path. Raises what keeps the program from being run."""
    executed = set(source.path.executed[:, 0].tolist())
    numbers = []
    for found in (*source.program.findings, *source.path.findings):
        word = _word_at(source, found)
        if found.severity == Severity.ERROR and found.code not in NOT_UNDERSTOOD:
            raise found.as_error()
        if word is not None and word.block not in executed and found.code != Code.NC_FLOW:
            continue
        if found.code == Code.NC_NUMBER:
            numbers.append(word)
        elif not _reported(source, found, word):
            yield word, Lost(_severity(found, source, word), _said(found, word))
    if numbers:
        what = f"whole units are written for {len(numbers)} numbers without a point, which may count least increments"
        yield numbers[0], Lost(Severity.WARNING, what)


def _word_at(source: Source, found: Finding) -> Word | None:
    line, column = found.place.line or 1, found.place.column or 0
    words = source.program.block(line - 1).words if line <= source.program.block_count else ()
    exact = (word for word in words if word.column <= column < word.column + max(1, word.end - word.start))
    return next(exact, words[0] if words else None)


def _reported(source: Source, found: Finding, word: Word | None) -> bool:
    if found.code != Code.NC_OPAQUE or word is None:
        return False
    meanings = {(source.program.core.meaning(w.index) or "").partition("(")[0] for w in _block(source, word).words}
    return word.letter in ("T", "D") or (bool(meanings & REPORTED) and word.letter not in ("A", "B", "C"))


def _block(source: Source, word: Word) -> Block:
    return source.program.block(word.block)


def _severity(found: Finding, source: Source, word: Word | None) -> Severity:
    """An error is what makes the machine move otherwise."""
    meaning = (source.program.core.meaning(word.index) or "") if word is not None else ""
    lifts = meaning.startswith(("Drill", "RoughContour", "Profile")) and found.severity == Severity.NOTE
    if found.code in (*NOT_UNDERSTOOD, Code.NC_UNIT, Code.NC_DIAMETER) or (found.code == Code.NC_OPAQUE and not lifts):
        return Severity.ERROR
    return Severity.WARNING


def _said(found: Finding, word: Word | None) -> str:
    return found.message.removeprefix(f"{word.text}: ") if word else found.message


def not_run(source: Source) -> Iterator[Said]:
    """Blocks that were not run, and that loops and calls are written out."""
    executed = np.zeros(source.program.block_count, dtype=np.bool_)
    executed[source.path.executed[:, 0]] = True
    left_out = np.flatnonzero((source.program.plain >= PLAIN_MOVES) & ~executed).tolist()
    formulas, unrolled = bool(source.program.parameters_used()), None
    for block in source.program.other_blocks:
        if not executed[block.index] and _has_to_run(block):
            left_out.append(block.index)
        unrolled = unrolled or next((word for word in block.words if _runs_once(source, word, formulas)), None)
    if left_out:
        word, what = _run_words(source.program.block(min(left_out)))[0], "blocks were not run, from this one on"
        yield word, Lost(Severity.WARNING, f"{len(left_out)} {what}, and are not written")
    if unrolled is not None:
        yield unrolled, Lost(Severity.NOTE, "loops, calls and expressions are written out as they ran")


def _has_to_run(block: Block) -> bool:
    words = _run_words(block)
    return bool(words) and not any(word.kind in ("flow", "label", "unknown") for word in words)


def _run_words(block: Block) -> list[Word]:
    return [word for word in block.data if word.letter != "O" and not word.text.upper().startswith("END PGM")]


def _runs_once(source: Source, word: Word, formulas: bool) -> bool:
    called = source.program.core.meaning(word.index) in CALLS
    computed = word.is_expression and (formulas or source.program.dialect.bracket_open in word.text)
    return called or computed or word.kind in ("flow", "call", "assignment")


def lost_in_words(source: Source, executed: Executed) -> Iterator[Said]:
    """Codes and words of a block that no statement carries."""
    lost = False
    for word in executed.block.data:
        base, _, argument = executed.meanings.get(word.index, "").partition("(")
        if base in UNWRITTEN or word.kind == "statement":
            lost = True
            yield word, Lost(Severity.ERROR, UNWRITTEN.get(base, "an offset is not entered at the control"))
        elif base in ("Drill", "DrillAlong"):
            yield from _drilling(word, argument)
    if lost or "Inert" in executed.codes or "SetRegister" in executed.codes:
        return
    carried = BY_PATH.union(*(BY_CODE.get(base, "") for base in executed.codes), DRILLING)
    for word in executed.block.data:
        if word.kind in ("number", "expression") and word.letter not in carried | _of_control(source):
            severity = Severity.ERROR if word.letter in MOVING else Severity.WARNING
            yield word, Lost(severity, "what it says is not written")


def _of_control(source: Source) -> frozenset[str]:
    """D of Sinumerik is an edge of the tool; further axes are reported as NC-OPAQUE."""
    return frozenset("DABCo") if source.control.tool_offset == "D" else frozenset("ABC")


def _drilling(word: Word, argument: str) -> Iterator[Said]:
    if argument.startswith("Tap"):
        yield word, Lost(Severity.ERROR, "tapping is written as feed moves: the spindle does not turn with them")
    elif word.value not in FULL_DRILLING:
        yield word, Lost(Severity.WARNING, "written as moves: what it does at the bottom beside moving is not")
    else:
        yield word, Lost(Severity.NOTE, "written as moves")
