"""What is in force after the blocks written so far, and how numbers are written."""

import math
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import CoordinateState
from trueloop.nc.translate.controls import Control
from trueloop.nc.translate.statements import Lost, Vector

NOWHERE: Vector = (math.nan, math.nan, math.nan)


@dataclass(frozen=True)
class Target:
    """The dialect to be written, its row, and the decimals of coordinates where they are asked for; those of the source
    are in `dialect`'s steps.

    `rows` of the offset table that each tool is used with, as `rows_of_tools` has them.
    """

    dialect: Dialect
    control: Control
    decimals: int | None = None
    rows: Mapping[int, tuple[int, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class InForce:
    """What the blocks written so far have set.

    `at_mm` is where they have the tool, NaN along an axis that they have not positioned; `words` the word of each kind
    (unit, plane, feed …); `rounded_mm` the largest distance along an axis by which a position was rounded.
    """

    at_mm: Vector = NOWHERE
    coordinates: CoordinateState = field(default_factory=lambda: CoordinateState(False, False))
    words: Mapping[str, str] = field(default_factory=dict)
    rounded_mm: float = 0.0

    def now(self, kind: str, word: str) -> "InForce":
        """With the word of that kind in force."""
        return replace(self, words={**self.words, kind: word})

    def unless(self, kind: str, word: str) -> str:
        """The word, or nothing where it is in force already."""
        return "" if self.words.get(kind) == word else word

    def forget(self, *axes: int) -> "InForce":
        """With these axes at places that are not known."""
        x, y, z = (math.nan if axis in axes else at for axis, at in enumerate(self.at_mm))
        return replace(self, at_mm=(x, y, z))


Writing: TypeAlias = Generator[str | Lost, None, InForce]
"""Blocks and losses, and at its end what is in force."""


def number(value: float, decimals: int) -> str:
    """With a decimal point always: some controls count least increments without one."""
    text = f"{value:.{decimals}f}".rstrip("0") if decimals else f"{value:.0f}."
    text = text + "0" if text.endswith(".") else text
    return "0.0" if float(text) == 0.0 else text


def decimals(target: Target, state: InForce) -> int:
    """Those asked for, else those of the control's resolution or the source's own, whichever are more."""
    if target.decimals is not None:
        return target.decimals
    return max(0, round(-math.log10(target.dialect.step(state.coordinates.inch))))


def step_mm(target: Target, state: InForce) -> float:
    """The distance between neighbouring positions that can be written, along Y and Z."""
    return float(10.0 ** -decimals(target, state)) * state.coordinates.unit_mm("Z")


def position(target: Target, state: InForce, axis: int, value_mm: float) -> tuple[str, InForce]:
    """The number that positions an axis, which then stands where the rounded number says."""
    unit_mm = state.coordinates.unit_mm("XYZ"[axis])
    text = number(value_mm / unit_mm, decimals(target, state))
    stands_mm = float(text) * unit_mm
    x, y, z = (stands_mm if k == axis else at for k, at in enumerate(state.at_mm))
    rounded_mm = max(state.rounded_mm, abs(stands_mm - value_mm))
    return text, replace(state, at_mm=(x, y, z), rounded_mm=rounded_mm)


def block(*words: str) -> str:
    """The words that are not empty, with spaces between."""
    return " ".join(filter(None, words))


def once(state: InForce, **words: str) -> Writing:
    """One block of those of the words that are not in force yet, by their kinds."""
    line = block(*(state.unless(kind, word) for kind, word in words.items()))
    if line:
        yield line
    return replace(state, words={**state.words, **words})
