"""Which words of two lines of a program differ, as the lossless reader splits them."""

from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from difflib import SequenceMatcher
from itertools import zip_longest
from typing import Final

from trueloop.controllers.links.changes import Change, compared
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import Word, read_program

BLANK: Final = b" \t\r\n"


@dataclass(frozen=True)
class WordDifference:
    """A word that differs: its columns in both lines, from 1 in bytes, and what stands there; None: no such word.

    `what` is its letter or name; `comment`; `text` for what is no word; `blanks` or `line end` where nothing else
    differs, and then before and after are the whole lines.
    """

    what: str
    column: int | None
    before: str | None
    other_column: int | None
    after: str | None


@dataclass(frozen=True)
class _Token:
    what: str
    start: int
    text: bytes
    compared: bytes


def differing_words(before: str, after: str, dialect: str, passes: AbstractSet[Change]) -> tuple[WordDifference, ...]:
    """Returns the words that differ, other than by `passes`, of two lines that differ. Lines are bytes as Latin-1."""
    one, other = (_tokens(line.encode("latin-1"), dialect, passes) for line in (before, after))
    found = tuple(_differing(one, other))
    if found:
        return found
    what = "line end" if before.rstrip("\r\n") == after.rstrip("\r\n") else "blanks"
    return (WordDifference(what, 1, before, 1, after),)


def block_name(line: str, dialect: str) -> str:
    """Returns the block's number as the line spells it, `N120`; empty where it has none."""
    words = _tokens(line.encode("latin-1"), dialect, frozenset())
    return next((word.text.decode("latin-1") for word in words[:2] if word.what == "N"), "")


def _tokens(line: bytes, dialect: str, passes: AbstractSet[Change]) -> list[_Token]:
    program, opened, at, found = read_program(line, dialect), dialect_named(dialect).comment_open.encode(), 0, []
    for block in program.blocks:
        for word in block.words:
            found += [*_between(line, at, word.start, opened), (_name(word), word.start, line[word.start : word.end])]
            at = word.end
    found += _between(line, at, len(line), opened)
    return [_Token(*one, compared(one[2], passes)) for one in found]


def _between(line: bytes, start: int, end: int, opened: bytes) -> Iterator[tuple[str, int, bytes]]:
    """What stands between two words: a comment, or what the reader takes for no word."""
    text = line[start:end]
    if kept := text.strip(BLANK):
        yield "comment" if kept.startswith(opened) else "text", start + text.index(kept), kept


def _name(word: Word) -> str:
    """The letter; a statement's own text up to its value where it has none."""
    if word.kind == "unknown":
        return word.letter or "text"
    return word.letter or word.text.split("(")[0].split(" ")[0]


def _differing(one: Sequence[_Token], other: Sequence[_Token]) -> Iterator[WordDifference]:
    """Same words are paired first; between them, words of one name."""
    for a, b in _stretches(one, other, [token.compared for token in one], [token.compared for token in other]):
        for c, d in _stretches(a, b, [token.what for token in a], [token.what for token in b], equal=True):
            for x, y in zip_longest(c, d):
                if x is None or y is None or x.what != y.what:
                    yield from (_difference(p, q) for p, q in ((x, None), (None, y)) if p or q)
                elif x.compared != y.compared:
                    yield _difference(x, y)


def _stretches(
    one: Sequence[_Token],
    other: Sequence[_Token],
    keys: Sequence[object],
    others: Sequence[object],
    equal: bool = False,
) -> Iterator[tuple[Sequence[_Token], Sequence[_Token]]]:
    """The stretches that differ by their keys, and with `equal` those that do not."""
    for tag, a, a_end, b, b_end in SequenceMatcher(None, keys, others, autojunk=False).get_opcodes():
        if equal or tag != "equal":
            yield one[a:a_end], other[b:b_end]


def _difference(a: _Token | None, b: _Token | None) -> WordDifference:
    what = (a or b or _NONE).what
    return WordDifference(what, *_place(a), *_place(b))


def _place(token: _Token | None) -> tuple[int, str] | tuple[None, None]:
    return (None, None) if token is None else (token.start + 1, token.text.decode("latin-1"))


_NONE: Final = _Token("", 0, b"", b"")
