"""Whether two texts are the same program, but for what a control is known to change."""

from dataclasses import dataclass
from difflib import SequenceMatcher
from enum import StrEnum
from itertools import zip_longest
from typing import Final


class Change(StrEnum):
    """What a control may do to a program that it stores, if its settings say that it does."""

    CAPITALS = "capitals"  # small letters made capitals
    BLANKS = "blanks"  # blanks and tabs added or left out
    LINE_ENDS = "line ends"  # CR, LF, CR LF; empty lines; NUL between them


@dataclass(frozen=True)
class Difference:
    """A line that differs: its numbers in both texts, from 1, and what stands there; None: no such line."""

    line: int | None
    before: str | None
    other_line: int | None
    after: str | None


SHOWN: Final = 20
"""Differences that are listed at most."""
MOST_ALIGNED: Final = 20_000
"""Lines up to which lines left out and added are found; beyond, lines are compared one by one."""


def differences(first: bytes, second: bytes, passes: frozenset[Change] = frozenset()) -> list[Difference]:
    """The lines of two programs that differ, other than by `passes`; at most `SHOWN`, empty: they are the same.

    Without LINE_ENDS a line's end belongs to it. A difference in one byte of a word is a difference: `X10.` and
    `X10.0` are not the same text.
    """
    if first == second:
        return []
    one, other = (_lines(text, passes) for text in (first, second))
    if [line for _, _, line in one] == [line for _, _, line in other]:
        return []
    return list(_differing(one, other))[:SHOWN]


_Line = tuple[int, str, bytes]


def _lines(text: bytes, passes: frozenset[Change]) -> list[_Line]:
    """Each line's number, as it is, and as it is compared."""
    loose = Change.LINE_ENDS in passes
    split = text.replace(b"\0", b"").replace(b"\r\n", b"\n").replace(b"\r", b"\n").split(b"\n") if loose else None
    lines = split if split is not None else text.splitlines(keepends=True)
    compared = [(k, line.decode("latin-1"), _compared(line, passes)) for k, line in enumerate(lines, 1)]
    return [one for one in compared if one[2] or not loose]


def _compared(line: bytes, passes: frozenset[Change]) -> bytes:
    if Change.CAPITALS in passes:
        line = line.upper()
    return line.translate(None, b" \t") if Change.BLANKS in passes else line


def _differing(one: list[_Line], other: list[_Line]) -> list[Difference]:
    if max(len(one), len(other)) > MOST_ALIGNED:
        pairs = [(a, b) for a, b in zip_longest(one, other) if a is None or b is None or a[2] != b[2]]
        return [_difference(a, b) for a, b in pairs[:SHOWN]]
    found = list[Difference]()
    matcher = SequenceMatcher(None, [line for *_, line in one], [line for *_, line in other], autojunk=False)
    for tag, a0, a1, b0, b1 in matcher.get_opcodes():
        if tag != "equal":
            found += [_difference(a, b) for a, b in zip_longest(one[a0:a1], other[b0:b1])]
    return found


def _difference(a: _Line | None, b: _Line | None) -> Difference:
    return Difference(a and a[0], a and a[1], b and b[0], b and b[1])
