"""Bounds of the numbers of an image, alike in `crates/rtec`, so that nothing overflows in a servo period."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.realtime.image import Bank, Block, Body, RealTimeLimits, Signal

MOST: Final = 1e3
"""Errors, rows of a table and limits, mm and rad; lengths are less than its square."""
MOST_SIGNAL: Final = 1e9
MOST_SLOPE: Final = 1.0
MOST_POWER: Final = 1e100


class NoImageError(Exception):
    """Why a file is no image: the refusal's name, as in docs/realtime-image.md, and what was found."""

    def __init__(self, refusal: str, found: str) -> None:
        super().__init__(found)
        self.refusal = refusal


def check_numbers(limits: RealTimeLimits, bank: Bank, blocks: tuple[Block, ...]) -> None:
    """Raises NoImageError (limits, body, order) where the numbers do not make limits, functions and a table."""
    _require("limits", [*_of_limits(limits), *_of_bank(bank)])
    for number, body in enumerate(bank.bodies):
        _require("body", _of_body(f"body {number}", body, spans(bank.signals)))
    for before, after in pairwise(blocks):
        _require("order", [(f"program line {after.line} after {before.line}", before.line < after.line)])
    most = np.array([MOST**2, MOST**2, MOST, MOST])
    _require("limits", [(f"rows of line {b.line}", bool((np.abs(b.rows) <= most).all())) for b in blocks])


def _require(refusal: str, conditions: "list[tuple[str, bool]] | Iterator[tuple[str, bool]]") -> None:
    for what, holds in conditions:
        if not holds:
            raise NoImageError(refusal, what)


def spans(signals: tuple[Signal, ...]) -> Array:
    """Returns the largest difference of each signal from its reference within its range."""
    return np.array([max(abs(s.low - s.reference), abs(s.high - s.reference)) for s in signals])


def _of_limits(limits: RealTimeLimits) -> Iterator[tuple[str, bool]]:
    yield f"limit {limits.limit_mm:g} mm", 0 < limits.limit_mm <= MOST
    yield f"gate {limits.gate_mm:g} mm", 0 < limits.gate_mm <= MOST
    for axis, (low, high) in zip("XYZ", limits.travel_mm, strict=True):
        yield f"travel of {axis} from {low:g} to {high:g} mm", low <= high


def _of_bank(bank: Bank) -> Iterator[tuple[str, bool]]:
    yield f"tool {bank.tool_mm} mm", max(map(abs, bank.tool_mm)) <= MOST**2
    for s in bank.signals:
        small = max(abs(s.low), abs(s.high), abs(s.reference)) <= MOST_SIGNAL
        yield f"{s.name} from {s.low:g} to {s.high:g}, reference {s.reference:g}", small and s.low <= s.high
        yield f"steps of {s.name} up to {s.most_step:g}", s.most_step > 0
    slope = np.tensordot(np.array([1.0, *spans(bank.signals)]), np.abs(bank.slope), axes=1)
    yield f"squareness up to {slope.max():g}", bool((slope <= MOST_SLOPE).all())


def _of_body(name: str, body: Body, span: Array) -> Iterator[tuple[str, bool]]:
    places = [place for place, _ in body.per_unit]
    yield f"{name}: breaks {body.breaks.tolist()}", bool((np.diff(body.breaks) > 0).all())
    yield f"{name}: signals {places}", sorted(set(places)) == places
    reach = _reach(body.breaks, body.powers) + sum(span[k] * _reach(body.breaks, added) for k, added in body.per_unit)
    yield f"{name}: errors up to {reach:g} mm or rad", reach <= MOST
    largest = max(np.abs(powers).max() for powers in (body.powers, *(added for _, added in body.per_unit)))
    yield f"{name}: coefficients up to {largest:g}", bool(largest <= MOST_POWER)
    yield f"{name}: arm {body.arm_mm.tolist()} mm", bool((np.abs(body.arm_mm) <= MOST**2).all())
    yield f"{name}: carries {body.carries.tolist()}", bool((np.abs(body.carries) <= 1).all())


def _reach(breaks: Array, powers: Array) -> float:
    """What no error of these powers is beyond: of all segments the largest sum of |power| times width."""
    width = np.diff(breaks)[:, None] ** np.arange(powers.shape[2])
    return float((np.abs(powers) * width[:, :, None]).sum(axis=2).max())
