"""Nelson's eight tests for special causes [L. S. Nelson, Journal of Quality Technology 16 (1984) 237].

Each marks the value at which its pattern is complete. Values are in standard deviations about the centre.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from trueloop.arrays import Array, Flags
from trueloop.wording import wording


@dataclass(frozen=True)
class Rule:
    """One test: its number, its finding in words, and the function that marks where it holds."""

    number: int
    meaning: str
    marks: Callable[[Array], Flags]


def beyond(z: Array) -> Flags:
    """Marks one value more than 3 σ from the centre."""
    return np.abs(z) > 3.0


def one_side(z: Array) -> Flags:
    """Marks nine in a row on one side of the centre."""
    return _in_a_row(z > 0.0, 9) | _in_a_row(z < 0.0, 9)


def trend(z: Array) -> Flags:
    """Marks six in a row that rise, or fall, steadily: five steps of one sign."""
    step = _steps(z)
    return _in_a_row(step > 0.0, 5) | _in_a_row(step < 0.0, 5)


def alternating(z: Array) -> Flags:
    """Marks fourteen in a row up and down in turn: thirteen steps, each against the one before."""
    step = np.sign(_steps(z))
    turned = np.zeros(z.shape, dtype=bool)
    turned[..., 2:] = step[..., 2:] * step[..., 1:-1] < 0.0
    return _in_a_row(turned, 12)


def two_of_three(z: Array) -> Flags:
    """Marks two of three in a row more than 2 σ off, on one side."""
    return _so_many(z > 2.0, 2, 3) | _so_many(z < -2.0, 2, 3)


def four_of_five(z: Array) -> Flags:
    """Marks four of five in a row more than 1 σ off, on one side."""
    return _so_many(z > 1.0, 4, 5) | _so_many(z < -1.0, 4, 5)


def hugging(z: Array) -> Flags:
    """Marks fifteen in a row within 1 σ of the centre, on either side."""
    return _in_a_row(np.abs(z) < 1.0, 15)


def avoiding(z: Array) -> Flags:
    """Marks eight in a row more than 1 σ off, on either side."""
    return _in_a_row(np.abs(z) > 1.0, 8)


RULES: Final = (
    Rule(1, wording("one value beyond 3 σ"), beyond),
    Rule(2, wording("nine in a row on one side"), one_side),
    Rule(3, wording("six in a row rising or falling"), trend),
    Rule(4, wording("fourteen in a row up and down in turn"), alternating),
    Rule(5, wording("two of three beyond 2 σ on one side"), two_of_three),
    Rule(6, wording("four of five beyond 1 σ on one side"), four_of_five),
    Rule(7, wording("fifteen in a row within 1 σ"), hugging),
    Rule(8, wording("eight in a row beyond 1 σ on either side"), avoiding),
)


def _steps(z: Array) -> Array:
    """Returns the step from each value's predecessor to it; 0 at the first."""
    return np.diff(z, axis=-1, prepend=z[..., :1])


def _in_a_row(holds: Flags, count: int) -> Flags:
    return _so_many(holds, count, count)


def _so_many(holds: Flags, least: int, among: int) -> Flags:
    """Marks where it holds now, and `least` times at least among the last `among`, fewer at the beginning."""
    padding = np.zeros((*holds.shape[:-1], among - 1), dtype=bool)
    windows = sliding_window_view(np.concatenate([padding, holds], axis=-1), among, axis=-1)
    marked: Flags = holds & (windows.sum(axis=-1) >= least)
    return marked
