"""The statements of a DMIS file, every byte of it kept.

A line is one statement. `$` at its end continues it, even inside a word; `$$` begins a comment; a comma before `$$`
continues it too, and so does a line that begins with what begins no statement (a comma, a number). All of it was seen
in files of measuring software; blanks at the beginning of a continued line are no part of it, outside of quoted text.
"""

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trueloop.formats.inspections.shared.text import decoded

BLANKS: Final = " \t\f\v\x1a\0\ufeff"
"""No part of a statement at a line's ends; ^Z ends files of old systems, the last is a byte order mark."""
STRIPPED: Final = BLANKS + "\r\n"
BEGINS: Final = re.compile(r"\s*(?:[A-Za-z]+\s*\(.*?\)\s*=|[A-Za-z]+\s*/|(?:DATE|TIME)\s*=|[A-Za-z]{6}\s*$)", re.I)
"""What a line that could continue another must not look like."""
QUOTE_OR_COMMENT: Final = re.compile(r"'|\$\$")


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement or, with empty `text`, one comment or blank line.

    `text` is without comments and line ends, `raw` as it stands in the file over one or more lines, the first `line`.
    """

    text: str
    line: int
    raw: str


@dataclass(frozen=True)
class DmisText:
    """A file as statements; `as_bytes` of what `read_dmis_text` gave is the file."""

    statements: tuple[Statement, ...]
    encoding: str

    def as_bytes(self) -> bytes:
        """The file's bytes."""
        return "".join(statement.raw for statement in self.statements).encode(self.encoding)


def read_dmis_text(content: bytes, path: Path) -> DmisText:
    """The statements of a file's bytes. Raises MSR-FILE where they are no text."""
    text, encoding = dmis_text(content, path)
    return DmisText(tuple(statements_of(text)), encoding)


def dmis_text(content: bytes, path: Path) -> tuple[str, str]:
    """A file's text and its encoding, in which it makes the same bytes again: Latin-1 where no likelier one does."""
    _, encoding = decoded(content, path)
    encoding = {"utf-8-sig": "utf-8", "utf-16": "utf-16-be" if content[:1] == b"\xfe" else "utf-16-le"}.get(
        encoding, encoding
    )
    try:
        text = content.decode(encoding)
        if text.encode(encoding) == content:
            return text, encoding
    except UnicodeError:
        pass
    return content.decode("latin-1"), "latin-1"


def statements_of(text: str) -> Iterator[Statement]:
    """The statements of a text, in its order; their `raw` put together is the text."""
    pieces: list[str] = []
    raws: list[str] = []
    first, state = 1, _CLOSED
    for number, raw in enumerate(io.StringIO(text, newline=""), 1):
        plain = state is _CLOSED and raw[:1].isalpha()  # begins a statement
        if raws and (plain or not _continues(state, raw, any(pieces))):
            yield Statement(_joined(pieces), first, "".join(raws))
            pieces, raws, state = [], [], _CLOSED
        if not raws:
            first = number
        raws.append(raw)
        if plain and "$" not in raw:
            pieces.append(raw)
            continue
        body = raw.rstrip("\r\n")
        if state is _COMMENT:
            state = _COMMENT if _cut(body) else _CLOSED
            continue
        piece, state = _piece(body, quoted=state is _QUOTED, begun=bool(pieces))
        pieces.append(piece)
    if raws:
        yield Statement(_joined(pieces), first, "".join(raws))


_CLOSED, _CUT, _QUOTED, _COMMA, _COMMENT = "closed", "cut", "cut inside a quoted text", "after a comma", "comment cut"
"""How a line leaves its statement: complete, to be continued in one of three ways, or a comment that goes on."""


def _joined(pieces: list[str]) -> str:
    """The text of a statement; a piece may have its line's end still."""
    if len(pieces) > 1:
        return "".join([piece.rstrip("\r\n") for piece in pieces]).strip(BLANKS)
    return pieces[0].strip(STRIPPED) if pieces else ""


def _continues(state: str, body: str, begun: bool) -> bool:
    """Whether a line belongs to the statement or, where none has begun, to the comment before it."""
    if state in (_CUT, _QUOTED):
        return True
    if state in (_COMMA, _COMMENT):
        return not BEGINS.match(body)
    begin = body.lstrip(BLANKS)[:1]
    return begun and begin != "" and begin in ",+-.0123456789"


def _piece(body: str, *, quoted: bool, begun: bool) -> tuple[str, str]:
    """What a line adds to its statement, and how it leaves it. A comment line within a statement adds nothing."""
    text = body if quoted else body.lstrip(BLANKS)
    if "$" not in text:
        return text, _CLOSED
    comment = _comment_at(text, quoted)
    if comment == 0:
        return "", _COMMA if begun else _COMMENT if _cut(text) else _CLOSED
    if comment > 0:
        text = text[:comment].rstrip(BLANKS)
        return text, _COMMA if text.endswith(",") else _CLOSED
    if not _cut(text):
        return text, _CLOSED
    text = text.rstrip(BLANKS)[:-1]
    return text, _QUOTED if (text.count("'") + quoted) % 2 else _CUT


def _cut(body: str) -> bool:
    """Whether a line ends with one `$`."""
    end = body.rstrip(BLANKS)
    return end.endswith("$") and not end.endswith("$$")


def _comment_at(text: str, quoted: bool) -> int:
    """Where a comment begins outside of quoted text; -1 where none does."""
    if "'" not in text:
        return -1 if quoted else text.find("$$")
    for found in QUOTE_OR_COMMENT.finditer(text):
        if found[0] == "'":
            quoted = not quoted
        elif not quoted:
            return found.start()
    return -1
