"""The order in which the parts of a series were cut, by what is known of it, and what contradicts that."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise

from trueloop.errors import Code, Finding, Severity

HINT = "state when the parts were cut or measured; a series in another order learns another drift"


@dataclass(frozen=True)
class When:
    """What is known of one part's place in the order: `kept` counts as the inspections were kept."""

    serial: str
    kept: int
    cut_order: int | None = None
    cut_at: datetime | None = None
    measured_at: datetime | None = None
    in_doubt: bool = False


def parts_in_order(parts: Sequence[When]) -> tuple[tuple[int, ...], tuple[Finding, ...]]:
    """Indices of the parts as they were cut, and what is in doubt (SER-ORDER).

    By the order of their cuts where all are counted, else by the time of the cuts, else by the time of inspection, else
    as they were kept. Serial numbers never decide, but contradict: NIST's 3811 was inspected before 3511 [6811 §4.3].
    """
    order = tuple(sorted(range(len(parts)), key=lambda k: (_key(parts, k), parts[k].kept)))
    sorted_parts = [parts[k] for k in order]
    findings = [_doubt(f"part {one.serial!r} is marked as cut in another order") for one in parts if one.in_doubt]
    return order, (*findings, *_clock_back(parts), *_against_serials(sorted_parts))


def _key(parts: Sequence[When], k: int) -> float:
    one = parts[k]
    if all(part.cut_order is not None for part in parts):
        return float(one.cut_order or 0)
    if all(part.cut_at is not None for part in parts):
        return _seconds(one.cut_at)
    if all(part.measured_at is not None for part in parts):
        return _seconds(one.measured_at)
    return 0.0


def _seconds(at: datetime | None) -> float:
    """A time without a zone is taken as UTC: within one file all are alike."""
    assert at is not None
    return (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()


def _clock_back(parts: Sequence[When]) -> tuple[Finding, ...]:
    """A part kept later that was measured earlier: a clock set back, or files taken in another order."""
    timed = sorted((part for part in parts if part.measured_at is not None), key=lambda part: part.kept)
    return tuple(
        _doubt(
            f"part {after.serial!r} came after {before.serial!r} but was measured before it, at "
            f"{after.measured_at:%Y-%m-%d %H:%M} against {before.measured_at:%Y-%m-%d %H:%M}"
        )
        for before, after in pairwise(timed)
        if _seconds(after.measured_at) < _seconds(before.measured_at)
    )


def _against_serials(parts: Sequence[When]) -> tuple[Finding, ...]:
    """The first place where serial numbers that count fall."""
    numbers = [re.search(r"(\d+)$", part.serial) for part in parts]
    if any(number is None for number in numbers):
        return ()
    counted = [(int(number[1]), part) for number, part in zip(numbers, parts, strict=True) if number is not None]
    for (low, before), (high, after) in pairwise(counted):
        if high < low:
            return (_doubt(f"part {after.serial!r} is taken as cut after {before.serial!r}"),)
    return ()


def _doubt(why: str) -> Finding:
    return Finding(Severity.WARNING, Code.SER_ORDER, f"the order of the parts is in doubt: {why}", HINT)
