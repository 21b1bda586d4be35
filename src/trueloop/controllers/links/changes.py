"""What a control is known to change in a program that it stores, and text as it is compared then."""

from collections.abc import Set
from enum import StrEnum


class Change(StrEnum):
    """What a control may do to a program that it stores, if its settings say that it does."""

    CAPITALS = "capitals"  # small letters made capitals
    BLANKS = "blanks"  # blanks and tabs added or left out
    LINE_ENDS = "line ends"  # CR, LF, CR LF; empty lines; NUL between them


def compared(text: bytes, passes: Set[Change]) -> bytes:
    """Returns a line, or a word, without what passes; line ends are the business of whoever splits lines."""
    if Change.CAPITALS in passes:
        text = text.upper()
    return text.translate(None, b" \t") if Change.BLANKS in passes else text
