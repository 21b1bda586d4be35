"""Where a program at a control differs from a file: a row a word, and the same for machines."""

from collections.abc import Iterator, Sequence
from typing import Final

from trueloop.controllers.links.compare import Difference
from trueloop.controllers.links.words import WordDifference

HEADINGS: Final = ("line", "line there", "block", "word", "file", "control")
WHOLE: Final = ("blanks", "line end")
"""Differences whose texts are whole lines, and would look the same without their quotes."""


def difference_rows(found: Sequence[Difference]) -> list[tuple[str, ...]]:
    """A row for each word that differs, and for each line that only one of the two has."""
    return [row for one in found for row in _rows(one)]


def _rows(one: Difference) -> Iterator[tuple[str, ...]]:
    place = str(one.line or "–"), str(one.other_line or "–"), one.block
    if not one.words:
        yield *place, "whole line", *(_text(text, quoted=True) for text in (one.before, one.after))
    for word in one.words:
        yield *place, word.what, *(_text(text, quoted=word.what in WHOLE) for text in (word.before, word.after))


def _text(text: str | None, *, quoted: bool) -> str:
    if text is None:
        return "–"
    return repr(text) if quoted or not text.isprintable() else text


def differences_as_dict(found: Sequence[Difference]) -> dict[str, object]:
    """Lines by their numbers, words by their columns, both texts of each; what is not there is None."""
    return {"differences": [_as_dict(one) for one in found]}


def _as_dict(one: Difference) -> dict[str, object]:
    return {
        "line": one.line,
        "file": one.before,
        "other_line": one.other_line,
        "control": one.after,
        "block": one.block,
        "words": [_word_as_dict(word) for word in one.words],
    }


def _word_as_dict(word: WordDifference) -> dict[str, object]:
    return {
        "word": word.what,
        "column": word.column,
        "file": word.before,
        "other_column": word.other_column,
        "control": word.after,
    }
