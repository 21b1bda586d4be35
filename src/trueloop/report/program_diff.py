"""What was changed in a program, line by line: the source's lines crossed out, the corrected ones below them."""

from collections.abc import Sequence
from difflib import SequenceMatcher
from typing import Final

from trueloop.report.markup import esc

FOLD_FROM: Final = 8
"""New lines in one place from which on the middle ones are folded away: an arc written as many moves."""
SHOWN_BEFORE_FOLD: Final = 3


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
    """Line under line while the two versions are alike, then what is left of either."""
    rows: list[str] = []
    alike = 0
    while alike < min(len(old), len(new)) and _alike(old[alike], new[alike]):
        was, became = _marked(old[alike], new[alike])
        rows += [_row("old", old_number + alike, was), _row("new", new_number + alike, became)]
        alike += 1
    rows += [_row("old", old_number + k, esc(old[k])) for k in range(alike, len(old))]
    return rows + _folded([_row("new", new_number + k, esc(new[k])) for k in range(alike, len(new))])


def _alike(old: str, new: str) -> bool:
    return SequenceMatcher(None, old, new).ratio() > 0.6


def _folded(rows: list[str]) -> list[str]:
    if len(rows) < FOLD_FROM:
        return rows
    hidden = rows[SHOWN_BEFORE_FOLD:-1]
    fold = f"<details><summary>{len(hidden)} more lines</summary>{''.join(hidden)}</details>"
    return [*rows[:SHOWN_BEFORE_FOLD], fold, rows[-1]]


def _marked(old: str, new: str) -> tuple[str, str]:
    """Two versions of one line, with what differs between their common beginning and end marked."""
    start = _common_start(old, new)
    same_end = _common_start(old[start:][::-1], new[start:][::-1])

    def mark(line: str, tag: str) -> str:
        stop = len(line) - same_end
        middle = f"<{tag}>{esc(line[start:stop])}</{tag}>" if stop > start else ""
        return esc(line[:start]) + middle + esc(line[stop:])

    return mark(old, "del"), mark(new, "ins")


def _common_start(a: str, b: str) -> int:
    return next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))


def _row(kind: str, number: int, line: str) -> str:
    sign = {"old": "−", "new": "+"}.get(kind, " ")
    return f'<div class="line {kind}"><b>{number}</b><i>{sign}</i><code>{line}</code></div>'


def _lines(program: bytes) -> list[str]:
    """Lines of a program for people: UTF-8 where it is, else one byte a character."""
    try:
        return program.decode("utf-8").splitlines()
    except UnicodeDecodeError:
        return program.decode("latin-1").splitlines()
