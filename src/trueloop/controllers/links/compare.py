"""Compares two texts as programs, except for what a control is known to change, and where not."""

import re
from collections.abc import Iterator, Sequence, Set
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from enum import StrEnum
from itertools import zip_longest
from typing import Final, TypeAlias

from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import Word, read_program


class Change(StrEnum):
    """The changes that a control's settings allow it to make to a program that it stores."""

    CAPITALS = "capitals"  # small letters made capitals
    BLANKS = "blanks"  # blanks and tabs added or left out
    LINE_ENDS = "line ends"  # CR, LF, CR LF; empty lines; NUL between them


def compared(text: bytes, passes: Set[Change]) -> bytes:
    """Returns a line, or a word, without what passes; line ends are the business of whoever splits lines."""
    if Change.CAPITALS in passes:
        text = text.upper()
    return text.translate(None, b" \t") if Change.BLANKS in passes else text


BLANK: Final = b" \t\r\n"


@dataclass(frozen=True)
class WordDifference:
    """A word that differs: its columns in both lines, from 1 in bytes, and what stands there; None: no such word.

    `what` is its letter or name; `comment`; `text` for anything that is not a word; `blanks` or `line end` where
    nothing else differs, and then before and after are the whole lines.
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
    found = tuple(_differing_words(one, other))
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
    """Text between two words: a comment, or characters that the reader does not take for a word."""
    text = line[start:end]
    if kept := text.strip(BLANK):
        yield "comment" if kept.startswith(opened) else "text", start + text.index(kept), kept


def _name(word: Word) -> str:
    """The letter; a statement's own text up to its value where it has none."""
    if word.kind == "unknown":
        return word.letter or "text"
    return word.letter or word.text.split("(")[0].split(" ")[0]


def _differing_words(tokens: Sequence[_Token], other: Sequence[_Token]) -> Iterator[WordDifference]:
    """Same words are paired first; between them, words of one name."""
    for a, b in _stretches(tokens, other, [token.compared for token in tokens], [token.compared for token in other]):
        for c, d in _stretches(a, b, [token.what for token in a], [token.what for token in b], equal=True):
            for x, y in zip_longest(c, d):
                if x is None or y is None or x.what != y.what:
                    yield from (_word_difference(p, q) for p, q in ((x, None), (None, y)) if p or q)
                elif x.compared != y.compared:
                    yield _word_difference(x, y)


def _stretches(
    tokens: Sequence[_Token],
    other: Sequence[_Token],
    keys: Sequence[object],
    others: Sequence[object],
    equal: bool = False,
) -> Iterator[tuple[Sequence[_Token], Sequence[_Token]]]:
    """The stretches that differ by their keys, and with `equal` those that do not."""
    for tag, a, a_end, b, b_end in SequenceMatcher(None, keys, others, autojunk=False).get_opcodes():
        if equal or tag != "equal":
            yield tokens[a:a_end], other[b:b_end]


def _word_difference(a: _Token | None, b: _Token | None) -> WordDifference:
    what = (a or b or _NONE).what
    return WordDifference(what, *_place(a), *_place(b))


def _place(token: _Token | None) -> tuple[int, str] | tuple[None, None]:
    return (None, None) if token is None else (token.start + 1, token.text.decode("latin-1"))


_NONE: Final = _Token("", 0, b"", b"")


@dataclass(frozen=True)
class Difference:
    """A line that differs: its numbers in both texts, from 1, and what stands there; None: no such line.

    `block` is its number as the program spells it (`N120`), `words` those that differ, where both lines are there and
    the reader was asked.
    """

    line: int | None
    before: str | None
    other_line: int | None
    after: str | None
    block: str = ""
    words: tuple[WordDifference, ...] = ()


SHOWN: Final = 20
"""Differences that are listed at most."""
MOST_ALIGNED: Final = 20_000
"""Lines up to which lines left out and added are found; beyond, lines are compared one by one."""
MOST_PAIRED: Final = 40_000
"""Pairs of changed lines in one place up to which each is paired with the most similar one."""
WORDS: Final = re.compile(rb"[A-Za-z]+[^A-Za-z\s]*|[^A-Za-z\s]+")


def differences(first: bytes, second: bytes, passes: frozenset[Change] = frozenset()) -> list[Difference]:
    """Returns the lines in which two programs differ, other than by `passes`; at most `SHOWN`, none: they are equal.

    Without LINE_ENDS a line's end belongs to it. A difference in one byte of a word is a difference: `X10.` and
    `X10.0` are not the same text.
    """
    if first == second:
        return []
    one, other = (_lines(text, passes) for text in (first, second))
    first_at = _alike([line for *_, line in one], [line for *_, line in other])
    one, other = one[first_at:], other[first_at:]
    last = _alike([line for *_, line in reversed(one)], [line for *_, line in reversed(other)])
    return list(_differing(one[: len(one) - last], other[: len(other) - last]))[:SHOWN]


def in_words(differences: Sequence[Difference], dialect: str, passes: frozenset[Change]) -> list[Difference]:
    """Returns the differences with blocks and words, as the reader of that dialect splits the lines."""
    return [_in_words(difference, dialect, passes) for difference in differences]


def _in_words(difference: Difference, dialect: str, passes: frozenset[Change]) -> Difference:
    both = difference.before is not None and difference.after is not None
    words = differing_words(difference.before or "", difference.after or "", dialect, passes) if both else ()
    return replace(difference, block=block_name(difference.before or difference.after or "", dialect), words=words)


_Line: TypeAlias = tuple[int, str, bytes]


def _lines(text: bytes, passes: frozenset[Change]) -> list[_Line]:
    """Each line's number, as it is, and as it is compared."""
    loose = Change.LINE_ENDS in passes
    split = text.replace(b"\0", b"").replace(b"\r\n", b"\n").replace(b"\r", b"\n").split(b"\n") if loose else None
    lines = split if split is not None else text.splitlines(keepends=True)
    every = [(k, line.decode("latin-1"), compared(line, passes)) for k, line in enumerate(lines, 1)]
    return [one for one in every if one[2] or not loose]


def _alike(lines: Sequence[bytes], other: Sequence[bytes]) -> int:
    """How many first lines are the same."""
    pairs = enumerate(zip(lines, other, strict=False))
    return next((k for k, (a, b) in pairs if a != b), min(len(lines), len(other)))


def _differing(lines: list[_Line], other: list[_Line]) -> Iterator[Difference]:
    if max(len(lines), len(other)) > MOST_ALIGNED:
        pairs = zip_longest(lines, other)
        yield from (_difference(a, b) for a, b in pairs if a is None or b is None or a[2] != b[2])
        return
    matcher = SequenceMatcher(None, [line for *_, line in lines], [line for *_, line in other], autojunk=False)
    for tag, a0, a1, b0, b1 in matcher.get_opcodes():
        if tag != "equal":
            yield from (_difference(a, b) for a, b in _paired(lines[a0:a1], other[b0:b1]))


_Pair: TypeAlias = tuple[_Line | None, _Line | None]


def _paired(left: Sequence[_Line], other: Sequence[_Line]) -> list[_Pair]:
    """Changed lines beside their new versions: the pairs, in order, with the most words in common."""
    if len(left) == len(other) == 1 or len(left) * len(other) > MOST_PAIRED:
        return list(zip_longest(left, other))
    words, others = ([set(WORDS.findall(line.upper())) for *_, line in lines] for lines in (left, other))
    best = [[0.0] * (len(other) + 1) for _ in range(len(left) + 1)]
    for i in reversed(range(len(left))):
        for j in reversed(range(len(other))):
            together = _likeness(words[i], others[j]) + best[i + 1][j + 1]
            best[i][j] = max(together, best[i + 1][j], best[i][j + 1])
    return list(_path(left, other, best))


def _path(lines: Sequence[_Line], other: Sequence[_Line], best: list[list[float]]) -> Iterator[_Pair]:
    i = j = 0
    while i < len(lines) and j < len(other):
        if best[i][j] > max(best[i + 1][j], best[i][j + 1]):
            yield lines[i], other[j]
            i, j = i + 1, j + 1
        elif best[i][j] == best[i + 1][j]:
            yield lines[i], None
            i += 1
        else:
            yield None, other[j]
            j += 1
    yield from ((line, None) for line in lines[i:])
    yield from ((None, line) for line in other[j:])


def _likeness(one: set[bytes], other: set[bytes]) -> float:
    """Words in common count twice, their first letters once; 0 to 1."""
    letters, others = ({word[:1] for word in words} for words in (one, other))
    return (2 * len(one & other) + len(letters & others)) / (3 * max(len(one), len(other), 1))


def _difference(a: _Line | None, b: _Line | None) -> Difference:
    return Difference(a and a[0], a and a[1], b and b[0], b and b[1])
