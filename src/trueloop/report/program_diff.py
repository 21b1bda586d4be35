"""The changes in a program, line by line: the source's lines crossed out, the corrected ones below them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from html import unescape
from itertools import groupby
from typing import Final, Literal

from trueloop.controllers.links.compare import Difference, WordDifference
from trueloop.report.markup import esc, text_of
from trueloop.report.texts.texts import ENGLISH, Texts

HEADINGS: Final = ("line", "line there", "block", "word", "file", "control")
WHOLE: Final = ("blanks", "line end")
"""Differences whose texts are whole lines, and would look the same without their quotes."""


def difference_rows(differences: Sequence[Difference]) -> list[tuple[str, ...]]:
    """Returns a row for each word that differs, and for each line that only one of the two has."""
    return [row for difference in differences for row in _rows(difference)]


def _rows(difference: Difference) -> Iterator[tuple[str, ...]]:
    place = str(difference.line or "–"), str(difference.other_line or "–"), difference.block
    if not difference.words:
        yield *place, "whole line", *(_text(text, quoted=True) for text in (difference.before, difference.after))
    for word in difference.words:
        yield *place, word.what, *(_text(text, quoted=word.what in WHOLE) for text in (word.before, word.after))


def _text(text: str | None, *, quoted: bool) -> str:
    if text is None:
        return "–"
    return repr(text) if quoted or not text.isprintable() else text


def differences_as_dict(differences: Sequence[Difference]) -> dict[str, object]:
    """Lines by their numbers, words by their columns, both texts of each; what is not there is None."""
    return {"differences": [_as_dict(difference) for difference in differences]}


def _as_dict(difference: Difference) -> dict[str, object]:
    return {
        "line": difference.line,
        "file": difference.before,
        "other_line": difference.other_line,
        "control": difference.after,
        "block": difference.block,
        "words": [_word_as_dict(word) for word in difference.words],
    }


def _word_as_dict(word: WordDifference) -> dict[str, object]:
    return {
        "word": word.what,
        "column": word.column,
        "file": word.before,
        "other_column": word.other_column,
        "control": word.after,
    }


FOLD_FROM: Final = 8
"""New lines in one place from which on the middle ones are folded away: an arc written as many moves."""
SHOWN_BEFORE_FOLD: Final = 3
SHOWN: Final = 800
"""Lines of a diff that a page shows: it is to stay small enough to be sent by mail."""
ALIKE: Final = 0.6
"""Share of common characters from which on a line counts as another's new version."""
WORDS: Final = re.compile(r"\s+|[A-Za-z_]+|[\d.]+|.")
SIGNS: Final = {"old": "−", "new": "+", "same": " "}


@dataclass(frozen=True)
class DiffLine:
    """A line of a diff: number and content, which is HTML with the changed words marked.

    An old line has its number in the source, a new one in the corrected program, one that is the same in the source.
    """

    kind: Literal["same", "old", "new"]
    number: int
    content: str

    @property
    def text(self) -> str:
        """Returns the line's text."""
        return unescape(text_of(self.content))

    @property
    def comes_alone(self) -> bool:
        """Returns whether it is new, and no version of an old line."""
        return self.kind == "new" and "<ins>" not in self.content


def program_diff(source: bytes, corrected: bytes, say: Texts = ENGLISH) -> str:
    """Writes changed lines with one around them, their stretches marked (HTML); beyond `SHOWN` lines a count."""
    hunks = diff(source, corrected)
    if not hunks:
        return f"<p>{say('No line differs from the source program.')}</p>"
    blocks, left = [], SHOWN
    for lines in hunks:
        if shown := lines[: max(left, 0)]:
            blocks.append(f'<div class="hunk">{_folded(shown, say)}</div>')
        left -= len(lines)
    rest = say("{n} more lines are not shown here: compare the two files.", n=-left) if left < 0 else ""
    return f'<div class="diff">{"".join(blocks)}</div>' + (f"<p>{rest}</p>" if rest else "")


def diff(source: bytes, corrected: bytes) -> list[list[DiffLine]]:
    """Returns the changed lines, place by place, each place with one line around it."""
    before, after = _lines(source), _lines(corrected)
    hunks = []
    for group in SequenceMatcher(None, before, after).get_grouped_opcodes(1):
        lines: list[DiffLine] = []
        for tag, i, i_end, j, j_end in group:
            if tag == "equal":
                lines += _whole("same", before[i:i_end], i + 1)
            else:
                lines += _changed(before[i:i_end], i + 1, after[j:j_end], j + 1)
        hunks.append(lines)
    return hunks


def changed_lines(source: bytes, corrected: bytes) -> tuple[int, int]:
    """Counts the lines of the source that are gone or changed, and the new ones in their place."""
    matcher = SequenceMatcher(None, _lines(source), _lines(corrected))
    changed = [opcode for opcode in matcher.get_opcodes() if opcode[0] != "equal"]
    return sum(i_end - i for _, i, i_end, _, _ in changed), sum(j_end - j for _, _, _, j, j_end in changed)


def _changed(old: Sequence[str], old_number: int, new: Sequence[str], new_number: int) -> Iterator[DiffLine]:
    """Line under line where both versions begin and end alike; between, what is left of the old and of the new."""
    first = _alike_from_start(old, new)
    last = _alike_from_start(old[first:][::-1], new[first:][::-1])
    old_end, new_end = len(old) - last, len(new) - last
    yield from _pairs(old[:first], old_number, new[:first], new_number)
    yield from _whole("old", old[first:old_end], old_number + first)
    yield from _whole("new", new[first:new_end], new_number + first)
    yield from _pairs(old[old_end:], old_number + old_end, new[new_end:], new_number + new_end)


def _whole(kind: Literal["same", "old", "new"], lines: Sequence[str], number: int) -> Iterator[DiffLine]:
    return (DiffLine(kind, number + k, esc(line)) for k, line in enumerate(lines))


def _alike_from_start(old: Sequence[str], new: Sequence[str]) -> int:
    """How many first lines are versions of one another."""
    pairs = enumerate(zip(old, new, strict=False))
    return next((k for k, (a, b) in pairs if SequenceMatcher(None, a, b).ratio() < ALIKE), min(len(old), len(new)))


def _pairs(old: Sequence[str], old_number: int, new: Sequence[str], new_number: int) -> Iterator[DiffLine]:
    for k, (a, b) in enumerate(zip(old, new, strict=True)):
        was, became = _marked(a, b)
        yield DiffLine("old", old_number + k, was)
        yield DiffLine("new", new_number + k, became)


def _folded(lines: Sequence[DiffLine], say: Texts) -> str:
    """Lines with the middle of every long run of new ones folded away; on paper it is unfolded."""
    parts = []
    for comes, run in groupby(lines, lambda line: line.comes_alone):
        rows = [_row(line) for line in run]
        if not comes or len(rows) < FOLD_FROM:
            parts += rows
            continue
        hidden = rows[SHOWN_BEFORE_FOLD:-1]
        label = f"<label><input type='checkbox'>{say('{n} more lines', n=len(hidden))}</label>"
        fold = f"<div class='fold'>{label}<div class='folded'>{''.join(hidden)}</div></div>"
        parts += [*rows[:SHOWN_BEFORE_FOLD], fold, rows[-1]]
    return "".join(parts)


def _marked(old: str, new: str) -> tuple[str, str]:
    """Two versions of one line, with the words that differ marked."""
    before, after = WORDS.findall(old), WORDS.findall(new)
    was, became = "", ""
    for tag, i, i_end, j, j_end in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        gone, come = esc("".join(before[i:i_end])), esc("".join(after[j:j_end]))
        was += gone if tag == "equal" or not gone else f"<del>{gone}</del>"
        became += come if tag == "equal" or not come else f"<ins>{come}</ins>"
    return was, became


def _row(line: DiffLine) -> str:
    kind = "" if line.kind == "same" else line.kind
    code = f"<code>{line.content}</code>"
    return f'<div class="line {kind}"><b>{line.number}</b><i>{SIGNS[line.kind]}</i>{code}</div>'


def _lines(program: bytes) -> list[str]:
    """Lines of a program for people: UTF-8 where it is, else one byte a character."""
    try:
        return program.decode("utf-8").splitlines()
    except UnicodeDecodeError:
        return program.decode("latin-1").splitlines()
