"""Numbers and formulas as a program writes them: rounded to the control's resolution, in the style of the old ones."""

import math
import re
from decimal import ROUND_HALF_EVEN, Decimal
from typing import Final

from trueloop._core import nc_number, nc_restyled, nc_with_term
from trueloop.errors import Code
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import CoordinateState

_NUMBER: Final = re.compile(r"(?:AC|IC|DC)\s*\(\s*([-+]?[\d.]+)\s*\)\s*|([-+]?[\d.]+)\s*", re.IGNORECASE)
_MOST_STEPS: Final = 10**15
"""More of the control's steps than any machine is long."""


def resolution_of(dialect: Dialect, state: CoordinateState) -> Decimal:
    """Returns the smallest programmable step, in the unit of the program."""
    return Decimal(str(dialect.step(state.inch)))


def rounded(value: float | Decimal, resolution: Decimal) -> Decimal:
    """Rounds to the control's resolution, in plain notation, never minus zero."""
    return Decimal(value).quantize(resolution, rounding=ROUND_HALF_EVEN) + 0


def _steps(value: Decimal, step: Decimal) -> int:
    steps = int(value / step)
    if abs(steps) > _MOST_STEPS:
        raise Code.NC_EDIT.refusal(
            f"{float(value):g} is no coordinate that a control could go to",
            hint="look for a slip in the program, or in its unit",
        )
    return steps


def digits_of(text: str) -> str:
    """Returns a number without spaces and with a decimal point."""
    return "".join(text.split()).replace(",", ".")


def number_text(dialect: Dialect, value: Decimal, state: CoordinateState) -> str:
    """Returns the text of a rounded number that is new, with as many decimals as the dialect's step has."""
    step = resolution_of(dialect, state)
    return nc_number(_steps(value, step), float(step), dialect.name, dialect.decimal_comma)


def restyled(dialect: Dialect, old: str, value: Decimal, state: CoordinateState) -> str:
    """Returns a rounded number in the style of the old one: sign habit, leading zeros, at least as many decimals."""
    step = resolution_of(dialect, state)
    return nc_restyled(old.encode("latin-1"), _steps(value, step), float(step), dialect.name, dialect.decimal_comma)


def with_term(program: Program, word: Word, delta: Decimal, state: CoordinateState) -> str | None:
    """Returns the expression of a word plus a rounded term; None where it takes no sum."""
    step = resolution_of(program.dialect, state)
    return nc_with_term(program.core, word.index, _steps(delta, step), float(step))


def rounded_mm(dialect: Dialect, letter: str, value_mm: float, state: CoordinateState) -> float:
    """Returns the coordinate, mm, of a word that is written with that value."""
    unit_mm = state.unit_mm(letter)
    return float(rounded(value_mm / unit_mm, resolution_of(dialect, state))) * unit_mm


def word_with(word: Word, value_mm: float, dialect: Dialect, state: CoordinateState) -> str:
    """Returns the text of a word that is a number, with another value: it is restyled, its address stays."""
    value = rounded(value_mm / state.unit_mm(word.letter), resolution_of(dialect, state))
    head, old = word.text[: word.value_start - word.start], word.text[word.value_start - word.start :]
    return head + restyled(dialect, old, value, state)


def number_said(word: Word) -> float:
    """Returns the number in a word, be it as `AC(5)`; NaN of a formula."""
    if word.kind == "number":
        return word.value
    found = _NUMBER.fullmatch(word.text[word.value_start - word.start :])
    return float(found.group(found.lastindex or 0)) if found else math.nan
