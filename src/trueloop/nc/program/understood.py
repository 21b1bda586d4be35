"""A program that shall be changed must be without errors of its own, and understood whole."""

import re
from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Integers
from trueloop.errors import Code, Finding, Place, Severity, Unseen
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath

NOT_UNDERSTOOD: Final = frozenset({Code.NC_WORD, Code.NC_CODE})


def require_understood(program: Program, key: str = "programs.accept_unknown_words") -> None:
    """Raises NC-WORD or NC-CODE for the first word or code that the dialect does not know, with how many there are;
    `key` is that of the job which accepts them.
    """
    found = [finding for finding in program.findings if finding.code in NOT_UNDERSTOOD]
    if found:
        first, more = found[0], len(found) - 1
        raise first.code.refusal(
            first.message + (f", and {more} more that {program.dialect.name} does not know" if more else ""),
            hint=f"{first.hint}; `trueloop nc check` lists them all",
            place=first.place,
            override=f"{key} in the job" + ", --accept-unknown-words" * key.startswith("programs."),
            values=first.values,
        )


FROM_OUTSIDE: Final = frozenset({Code.NC_PARAMETER, Code.NC_EXPRESSION, Code.NC_FLOW, Code.NC_LIMIT})
"""Errors that values and programs which are not in the file would mend."""


def require_sound(path: ToolPath, apart_from: Collection[Code] = ()) -> None:
    """Raises the first error of a program that was run: what the control refuses must not be made into what it runs."""
    for found in errors_in(path, apart_from):
        raise found.as_error()


def errors_in(path: ToolPath, apart_from: Collection[Code] = ()) -> list[Finding]:
    """Returns the errors of a program that was run, in the order of its lines."""
    errors = (found for found in path.findings if found.severity is Severity.ERROR and found.code not in apart_from)
    return sorted(errors, key=lambda error: (error.place.line or 0, error.place.column or 0))


def require_unit(path: ToolPath) -> None:
    """Raises NC-UNIT where lengths come before their unit, or the one given contradicts the one stated."""
    for found in path.findings:
        if found.code is Code.NC_UNIT:
            raise found.as_error()


def require_plain_frame(path: ToolPath, moves: Sequence[int]) -> None:
    """Raises NC-MAP for the first of the moves whose coordinates the program turns, mirrors or scales."""
    framed = [move for move in moves if path.linear[move]]
    if framed:
        raise Code.NC_MAP.refusal(
            f"coordinates are turned, mirrored or scaled in {len(framed)} of {len(moves)} moves that are corrected: "
            "the correction is not turned with them",
            hint="have this cut written in the coordinates of the work offset, without G68, ROT, MIRROR or SCALE: "
            "`trueloop nc path` prints the positions that it has there",
            place=Place(line=int(path.line[framed[0]]), column=1),
        )


def require_unturned(path: ToolPath, moves: Sequence[int]) -> None:
    """Raises NC-MAP for the first of the moves that a rotary axis or the program's own frame turns: a displacement
    along X, Y, Z is not turned.
    """
    require_plain_frame(path, moves)
    turned = [move for move in moves if path.turned[move]]
    if turned:
        letter = chr(path.turned[turned[0]])
        axis = "a rotary axis" if letter == "o" else letter
        raise Code.NC_MAP.refusal(
            f"{axis} does not stand at 0 degrees, or is not known to, in {len(turned)} of {len(moves)} moves that are "
            "corrected: the correction is not turned with it",
            hint=f"correct what is cut with {axis} at 0, said by a position before the first cut",
            place=Place(line=int(path.line[turned[0]]), column=1),
        )


def require_known_frame(path: ToolPath) -> None:
    """Raises NC-OPAQUE where a code before the last cut changes coordinates in a way the path does not follow.

    A rotation, a scaling or a corner left to the control: the positions after it are not those of the machine. Raises
    NC-DIAMETER where the program leaves it to machine data whether X is a diameter.
    """
    cuts = path.line[(path.motion == Motion.LINE) | (path.motion == Motion.ARC)]
    last_line = int(cuts.max(initial=0))
    for found in path.findings:
        unfollowed = found.code == Code.NC_OPAQUE and found.severity == Severity.WARNING
        unfollowed |= found.code == Code.NC_DIAMETER
        if unfollowed and (found.place.line or 0) <= last_line:
            raise found.as_error()


_COMMON: Final = re.compile(r"#\s*[1-9]\d\d")
"""A variable that a macro shares with the program that calls it."""


def require_seen(program: Program, path: ToolPath, moves: Sequence[int], axes: str) -> None:
    """Raises NC-OPAQUE for what is not in the path between the first and the last of the moves, if no position names
    each of these axes after it before the next of them, or a common variable sets a later one.

    It may move the axes, and a macro may change variables: nothing in the program tells.
    """
    ordered = np.unique(np.asarray(moves, dtype=np.int64))
    for found in path.findings:
        line = found.place.line or 0
        if found.unseen not in (Unseen.BLOCK, Unseen.TOUCHES):
            continue
        later = ordered[path.line[ordered] > line]
        if not len(later) or not (path.line[ordered] < line).any():
            continue
        named, shared = _named_between(program, path, line, int(later[0])), _set_by_common(program, path, later)
        if shared is None and set(axes) <= named:
            continue
        missing = "".join(axis for axis in axes if axis not in named)
        why = f"where {missing} stand{'s' * (len(missing) == 1)}" if missing else f"the value of {shared}"
        raise Code.NC_OPAQUE.refusal(
            f"{found.message}, between cuts that are corrected: {why} after it is not known",
            hint="write what it does into the program's file, or name every axis by a position in a move after it, "
            "and set variables anew",
            place=found.place,
        )


def _named_between(program: Program, path: ToolPath, line: int, move: int) -> set[str]:
    """The axes that positions name after a line and before a move."""
    between = np.flatnonzero((path.line[:move] > line) & ~path.incremental[:move])
    words = (program.word(int(index)) for index in path.word[between].ravel() if index >= 0)
    return {word.letter for word in words if word.increment is not True}


def _set_by_common(program: Program, path: ToolPath, moves: Integers) -> str | None:
    """The first word of the moves that a common variable sets."""
    words = (program.word(int(index)) for index in path.word[moves].ravel() if index >= 0)
    return next((word.text for word in words if _COMMON.search(word.text)), None)
