"""The numbers of an image, one after the other, and back. Names of refusals are those of docs/realtime-image.md."""

from collections.abc import Iterator, Sequence
from itertools import accumulate, chain
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.realtime.image_checks import NoImageError
from trueloop.machine.model.chain import Vector
from trueloop.realtime.image import SIGNALS, Bank, Block, Body, Image, RealTimeLimits, Signal

AXES: Final = 3
BODIES: Final = 8
POWERS: Final = 8
COMPONENTS: Final = 6
BREAKS: Final = 1 << 20
ROWS: Final = 1 << 21
LINE: Final = (1 << 31) - 1


def image_words(image: Image) -> Array:
    """The words of an image, in their order."""
    limits, bank = image.limits, image.bank or Bank((), (), np.zeros((1, AXES, AXES)))
    signals = [(s.reference, s.low, s.high, s.most_step) for s in bank.signals]
    parts = [
        [limits.limit_mm, limits.gate_mm, *chain.from_iterable(limits.travel_mm)],
        bank.tool_mm,
        [len(signals), *chain.from_iterable(signals)],
        bank.slope.ravel(),
        [len(bank.bodies)],
        *chain.from_iterable(_body_words(body) for body in bank.bodies),
        *_block_words(image.blocks),
    ]
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])


def _body_words(body: Body) -> Iterator[Array | Sequence[float]]:
    tables, _, powers, _ = body.powers.shape
    yield [body.axis, len(body.breaks), tables, powers, len(body.per_unit)]
    yield from (body.arm_mm, body.carries, body.breaks, body.powers.ravel())
    for place, added in body.per_unit:
        yield [place]
        yield added.ravel()


def _block_words(blocks: tuple[Block, ...]) -> Iterator[Array | Sequence[float]]:
    ends = list(accumulate((len(block.rows) for block in blocks), initial=0))
    yield [len(blocks)]
    yield from ((block.line, first, len(block.rows)) for block, first in zip(blocks, ends, strict=False))
    yield [ends[-1]]
    yield from (block.rows.ravel() for block in blocks)


def read_words(words: Array, named: Sequence[tuple[str, str]]) -> tuple[RealTimeLimits, Bank, tuple[Block, ...]]:
    """What the words say; `named` holds name and unit of the signals. A model that is none is a bank of nothing.

    Raises NoImageError: not finite, count.
    """
    for number in np.flatnonzero(~np.isfinite(words)):
        raise NoImageError("not finite", f"word {number} is {words[number]}")
    rest = _Words(words)
    limit, gate = rest.take(2)
    x, y, z = ((float(low), float(high)) for low, high in rest.take(2 * AXES).reshape(AXES, 2))
    limits = RealTimeLimits((x, y, z), float(limit), float(gate))
    tool = _vector(rest.take(AXES))
    count = rest.count("signals", 0, SIGNALS)
    numbers = rest.take(4 * count).reshape(count, 4).tolist()
    signals = tuple(Signal(name, unit, *four) for (name, unit), four in zip(named, numbers, strict=False))
    slope = rest.take((1 + count) * AXES**2).reshape(-1, AXES, AXES)
    bodies = tuple(_body(rest, count) for _ in range(rest.count("bodies", 0, BODIES)))
    blocks = _blocks(rest)
    if rest.left:
        raise NoImageError("count", f"{rest.left} words are left over")
    return limits, Bank(signals, bodies, slope, tool), blocks


class _Words:
    """Words taken from the front."""

    def __init__(self, words: Array) -> None:
        self.words, self.at = words, 0

    @property
    def left(self) -> int:
        """How many there still are."""
        return len(self.words) - self.at

    def take(self, count: int) -> Array:
        """The next so many. Raises NoImageError where there are fewer."""
        if count > self.left:
            raise NoImageError("count", f"{count} words are needed from word {self.at} on, {self.left} are there")
        self.at += count
        return self.words[self.at - count : self.at].astype(np.float64)

    def count(self, what: str, low: int, high: int) -> int:
        """A whole number within bounds."""
        value = float(self.take(1)[0])
        if value != round(value) or not low <= value <= high:
            raise NoImageError("count", f"{what}: {value:g}, from {low} to {high}")
        return int(value)


def _vector(three: Array) -> Vector:
    x, y, z = three.tolist()
    return x, y, z


def _body(rest: _Words, signals: int) -> Body:
    axis, breaks = rest.count("axis", 0, AXES - 1), rest.count("breaks", 2, BREAKS)
    tables, powers = rest.count("tables", 1, AXES), rest.count("powers", 1, POWERS)
    if tables == 2:
        raise NoImageError("count", "tables: 2, where 1 or 3 are")
    dependents = rest.count("dependents", 0, signals)
    arm, carries, ends = rest.take(AXES), rest.take(AXES), rest.take(breaks)
    shape = (tables, breaks - 1, powers, COMPONENTS)
    size = int(np.prod(shape))
    rows = rest.take(size).reshape(shape)
    per_unit = tuple(
        (rest.count("place of a signal", 0, signals - 1), rest.take(size).reshape(shape)) for _ in range(dependents)
    )
    return Body(axis, ends, rows, per_unit, arm, carries)


def _blocks(rest: _Words) -> tuple[Block, ...]:
    listed = [
        (
            rest.count("program line", 0, LINE),
            rest.count("first row", 0, ROWS),
            rest.count("rows", 2, ROWS),
        )
        for _ in range(rest.count("blocks", 0, ROWS))
    ]
    rows = rest.take(4 * rest.count("rows", 0, ROWS)).reshape(-1, 4)
    if bool(listed) != bool(len(rows)):
        raise NoImageError("count", f"{len(listed)} blocks, {len(rows)} rows")
    for line, first, count in listed:
        if first + count > len(rows):
            raise NoImageError("count", f"line {line}: rows {first} to {first + count} of {len(rows)}")
    return tuple(Block(line, rows[first : first + count]) for line, first, count in listed)
