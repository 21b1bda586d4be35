"""Values of macro variables: numbers, and the expressions in brackets that old controls write for them.

`[25283*65536+65536]/134217728` is 12.3457: numbers, + − * / and [ ], nothing else.
"""

import re
from typing import Final

from trueloop.formats.inspections.shared.text import MOST

TOKEN: Final = re.compile(r"\s*(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|[-+*/\[\]])")
PLAIN: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)")
DEEPEST: Final = 20
"""No control writes brackets as deep."""


def value_of(text: str) -> float | None:
    """The value of an expression; None for what is none, divides by zero, or is beyond `MOST`."""
    if PLAIN.fullmatch(text):
        return float(text) if abs(float(text)) <= MOST else None
    tokens = _tokens(text)
    if not tokens:
        return None
    try:
        value, rest = _sum(tokens, 0, 0)
    except (ValueError, ZeroDivisionError, OverflowError, IndexError):
        return None
    return value if rest == len(tokens) and abs(value) <= MOST else None


def _tokens(text: str) -> list[str]:
    """The tokens of a text; none where it has others."""
    tokens, at, text = [], 0, text.rstrip()
    while at < len(text):
        found = TOKEN.match(text, at)
        if found is None:
            return []
        tokens.append(found[1])
        at = found.end()
    return tokens


def _sum(tokens: list[str], at: int, depth: int) -> tuple[float, int]:
    value, at = _product(tokens, at, depth)
    while at < len(tokens) and tokens[at] in "+-":
        term, after = _product(tokens, at + 1, depth)
        value, at = (value + term if tokens[at] == "+" else value - term), after
    return value, at


def _product(tokens: list[str], at: int, depth: int) -> tuple[float, int]:
    value, at = _signed(tokens, at, depth)
    while at < len(tokens) and tokens[at] in "*/":
        factor, after = _signed(tokens, at + 1, depth)
        value, at = (value * factor if tokens[at] == "*" else value / factor), after
    return value, at


def _signed(tokens: list[str], at: int, depth: int) -> tuple[float, int]:
    if tokens[at] in "+-":
        value, after = _bracketed(tokens, at + 1, depth)
        return (-value if tokens[at] == "-" else value), after
    return _bracketed(tokens, at, depth)


def _bracketed(tokens: list[str], at: int, depth: int) -> tuple[float, int]:
    if tokens[at] != "[":
        return float(tokens[at]), at + 1
    if depth == DEEPEST:
        raise ValueError("too deep")
    value, after = _sum(tokens, at + 1, depth + 1)
    if tokens[after] != "]":
        raise ValueError("not closed")
    return value, after + 1
