"""What readers of tool tables share: lines with their places, and numbers."""

from collections.abc import Iterator
from decimal import Decimal, InvalidOperation
from pathlib import Path

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.tables.tool_tables.tool_table import HINT

Line = tuple[int, int, str]
"""Its number from 1, the place of its first character in the text, and its characters without the line's end."""


def lines_of(text: str) -> Iterator[Line]:
    """The lines of a text, which end with a line feed, with or without a carriage return."""
    start = 0
    for number, line in enumerate(text.split("\n"), 1):  # `splitlines` would split at bytes of UTF-8 letters too
        yield number, start, line.rstrip("\r")
        start += len(line) + 1


def decimal(text: str, path: Path, line: int, column: int) -> Decimal:
    """A number. Raises OFS-NUMBER for what is none."""
    try:
        value = Decimal(text.strip())
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite() or abs(value) > 10**6:
        raise TrueloopError(
            Code.OFS_NUMBER,
            f"{text!r} is no number that a tool table could hold",
            hint="save the table anew at the control",
            place=Place(str(path), line, column),
            values={"text": text},
        )
    return value


def whole(text: str, path: Path, line: int, column: int) -> int:
    """A whole number. Raises OFS-NUMBER for what is none."""
    value = decimal(text, path, line, column)
    if value != int(value):
        raise TrueloopError(
            Code.OFS_NUMBER,
            f"{text!r} is no whole number",
            hint=HINT,
            place=Place(str(path), line, column),
            values={"text": text},
        )
    return int(value)


def words_of(text: str) -> str:
    """Text of a comment or a name: UTF-8 where it is that."""
    raw = text.encode("latin-1")
    try:
        return raw.decode("utf-8").strip()
    except UnicodeDecodeError:
        return text.strip()
