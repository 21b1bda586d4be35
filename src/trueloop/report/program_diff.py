"""What was changed in a program, line by line: the source's lines crossed out, the corrected ones below them."""

import re
from collections.abc import Sequence
from difflib import SequenceMatcher
from typing import Final

from trueloop.report.markup import esc

FOLD_FROM: Final = 8
"""New lines in one place from which on the middle ones are folded away: an arc written as many moves."""
SHOWN_BEFORE_FOLD: Final = 3
ALIKE: Final = 0.6
"""Share of common characters from which on a line counts as another's new version."""
WORDS: Final = re.compile(r"\s+|[A-Za-z_]+|[\d.]+|.")


def program_diff(source: bytes, corrected: bytes) -> str:
    """The changed lines with one line around them; the changed stretch of a line that was replaced is marked."""
    before, after = _lines(source), _lines(corrected)
    groups = SequenceMatcher(None, before, after).get_grouped_opcodes(1)
    hunks = []
    for group in groups:
        rows: list[str] = []
        for tag, i, i_end, j, j_end in group:
            if tag == "equal":
                rows += [_row("", i + k + 1, esc(line)) for k, line in enumerate(before[i:i_end])]
            else:
                rows += _changed(before[i:i_end], i + 1, after[j:j_end], j + 1)
        hunks.append(f'<div class="hunk">{"".join(rows)}</div>')
    return f'<div class="diff">{"".join(hunks)}</div>' if hunks else "<p>No line differs from the source program.</p>"


def changed_lines(source: bytes, corrected: bytes) -> tuple[int, int]:
    """How many lines of the source are gone or changed, and how many new ones stand in their place."""
    matcher = SequenceMatcher(None, _lines(source), _lines(corrected))
    changed = [opcode for opcode in matcher.get_opcodes() if opcode[0] != "equal"]
    return sum(i_end - i for _, i, i_end, _, _ in changed), sum(j_end - j for _, _, _, j, j_end in changed)


def _changed(old: Sequence[str], old_number: int, new: Sequence[str], new_number: int) -> list[str]:
    """Line under line where both versions begin and end alike; between, what is left of the old and of the new."""
    first = _alike_from_start(old, new)
    last = _alike_from_start(old[first:][::-1], new[first:][::-1])
    old_end, new_end = len(old) - last, len(new) - last
    gone = [_row("old", old_number + i, esc(old[i])) for i in range(first, old_end)]
    come = [_row("new", new_number + j, esc(new[j])) for j in range(first, new_end)]
    above = _pairs(old[:first], old_number, new[:first], new_number)
    below = _pairs(old[old_end:], old_number + old_end, new[new_end:], new_number + new_end)
    return [*above, *gone, *_folded(come), *below]


def _alike_from_start(old: Sequence[str], new: Sequence[str]) -> int:
    """How many first lines are versions of one another."""
    pairs = enumerate(zip(old, new, strict=False))
    return next((k for k, (a, b) in pairs if SequenceMatcher(None, a, b).ratio() < ALIKE), min(len(old), len(new)))


def _pairs(old: Sequence[str], old_number: int, new: Sequence[str], new_number: int) -> list[str]:
    rows = []
    for k, (a, b) in enumerate(zip(old, new, strict=True)):
        was, became = _marked(a, b)
        rows += [_row("old", old_number + k, was), _row("new", new_number + k, became)]
    return rows


def _folded(rows: list[str]) -> list[str]:
    if len(rows) < FOLD_FROM:
        return rows
    hidden = rows[SHOWN_BEFORE_FOLD:-1]
    fold = f"<details><summary>{len(hidden)} more lines</summary>{''.join(hidden)}</details>"
    return [*rows[:SHOWN_BEFORE_FOLD], fold, rows[-1]]


def _marked(old: str, new: str) -> tuple[str, str]:
    """Two versions of one line, with the words that differ marked."""
    before, after = WORDS.findall(old), WORDS.findall(new)
    was, became = "", ""
    for tag, i, i_end, j, j_end in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        gone, come = esc("".join(before[i:i_end])), esc("".join(after[j:j_end]))
        was += gone if tag == "equal" or not gone else f"<del>{gone}</del>"
        became += come if tag == "equal" or not come else f"<ins>{come}</ins>"
    return was, became


def _row(kind: str, number: int, line: str) -> str:
    sign = {"old": "−", "new": "+"}.get(kind, " ")
    return f'<div class="line {kind}"><b>{number}</b><i>{sign}</i><code>{line}</code></div>'


def _lines(program: bytes) -> list[str]:
    """Lines of a program for people: UTF-8 where it is, else one byte a character."""
    try:
        return program.decode("utf-8").splitlines()
    except UnicodeDecodeError:
        return program.decode("latin-1").splitlines()
