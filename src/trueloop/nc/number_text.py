"""Numbers and formulas as a program writes them: rounded to the control's resolution, in the style of the old ones."""

import re
from decimal import ROUND_HALF_EVEN, Decimal
from typing import Final

from trueloop._core import nc_number, nc_restyled
from trueloop.errors import Code, TrueloopError
from trueloop.nc.dialect import Dialect
from trueloop.nc.program import Word
from trueloop.nc.tool_path import CoordinateState

_WEAKER_THAN_SUM: Final = re.compile(
    r"\b(eq|ne|gt|ge|lt|le|and|or|xor)\b|\d(eq|ne|gt|ge|lt|le|and|or|xor)|[<>=]|b_", re.IGNORECASE
)
"""What binds weaker than a sum: an expression with it is put into brackets before a term is added."""
_POSITION: Final = re.compile(r"(AC|DC|ACP|ACN)[ \t]*(?=\()", re.IGNORECASE)
"""What says in Sinumerik's words that a value is a position: a term goes into its brackets."""


_MOST_STEPS: Final = 10**15
"""More of the control's steps than any machine is long."""


def resolution_of(dialect: Dialect, state: CoordinateState) -> Decimal:
    """The smallest programmable step, in the unit of the program."""
    return Decimal(str(dialect.step(state.inch)))


def rounded(value: float | Decimal, resolution: Decimal) -> Decimal:
    """To the control's resolution, in plain notation, never minus zero."""
    return Decimal(value).quantize(resolution, rounding=ROUND_HALF_EVEN) + 0


def _steps(value: Decimal, step: Decimal) -> int:
    steps = int(value / step)
    if abs(steps) > _MOST_STEPS:
        raise TrueloopError(
            Code.NC_EDIT,
            f"{float(value):g} is no coordinate that a control could go to",
            hint="look for a slip in the program, or in its unit",
        )
    return steps


def digits_of(text: str) -> str:
    """A number without spaces and with a decimal point."""
    return "".join(text.split()).replace(",", ".")


def number_text(dialect: Dialect, value: Decimal, state: CoordinateState) -> str:
    """A rounded number as one that is new, with as many decimals as the dialect's step has."""
    step = resolution_of(dialect, state)
    return nc_number(_steps(value, step), float(step), dialect.name, dialect.decimal_comma)


def restyled(dialect: Dialect, old: str, value: Decimal, state: CoordinateState) -> str:
    """The same in the style of the old one: its sign habit, leading zeros, and at least as many decimals."""
    step = resolution_of(dialect, state)
    return nc_restyled(old.encode("latin-1"), _steps(value, step), float(step), dialect.name, dialect.decimal_comma)


def with_term(old: str, delta: Decimal, dialect: Dialect) -> str:
    """The expression plus a term: inside its own brackets, or in new ones where it has none."""
    term = f"{delta:+f}".rstrip("0").rstrip(".")
    opening, closing = dialect.bracket_open, dialect.bracket_close
    position = _POSITION.match(old) if dialect.formulas else None
    start = position.end() if position else 0
    whole = old[start:].startswith(opening) and _closes_at_end(old[start:], opening, closing)
    if whole and not _WEAKER_THAN_SUM.search(old):
        return f"{old[:-1]}{term}{closing}"
    if dialect.formulas and not _WEAKER_THAN_SUM.search(old):
        return f"{old}{term}"
    return f"{opening}{old}{term}{closing}"


def _closes_at_end(text: str, opening: str, closing: str) -> bool:
    depth = 0
    for position, letter in enumerate(text):
        depth += (letter == opening) - (letter == closing)
        if depth == 0:
            return position == len(text) - 1
    return False


def rounded_mm(dialect: Dialect, letter: str, value_mm: float, state: CoordinateState) -> float:
    """Where a word written with that value is taken to be."""
    unit_mm = state.unit_mm(letter)
    return float(rounded(value_mm / unit_mm, resolution_of(dialect, state))) * unit_mm


def word_with(word: Word, value_mm: float, dialect: Dialect, state: CoordinateState) -> str:
    """The text of a word that is a number, with another value: it is restyled, its address stays."""
    value = rounded(value_mm / state.unit_mm(word.letter), resolution_of(dialect, state))
    head, old = word.text[: word.value_start - word.start], word.text[word.value_start - word.start :]
    return head + restyled(dialect, old, value, state)
