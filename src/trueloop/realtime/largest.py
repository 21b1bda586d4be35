"""The largest correction that an image calls for: over the travel, both directions of travel and all signals.

Positions are sampled; in the signals E is linear, so the corners of their ranges are exact.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.chain import Vector
from trueloop.machine.model.compiled import Body, evaluator_of
from trueloop.realtime.image import Bank, Image

STEPS: Final = 24
"""Into which every travel is divided, besides the breaks of the model's functions."""


@dataclass(frozen=True)
class Largest:
    """The largest correction of one axis: which, how much, where, at which signals."""

    axis: str
    correction_mm: float
    position_mm: Vector
    signals: tuple[float, ...] = ()


@dataclass(frozen=True)
class Extent:
    """The largest corrections of an image; None for a part that it does not have. `whole`: model and table together.

    `jump_mm`: by how much a correction changes at most where one axis turns round. `places`: how many were sampled.
    """

    whole: Largest
    model: Largest | None
    table: Largest | None
    jump_mm: float
    places: int


def extent_of(image: Image) -> Extent:
    """Returns the largest corrections of an image, with its tool and no tool offset in force."""
    table = _of_table(image)
    if image.bank is None:
        assert table is not None  # an image holds one of the two
        return Extent(table, None, table, 0.0, 0)
    positions = _grid(image, image.bank)
    model, jump = _of_model(image.bank, positions, np.zeros(3))
    both = [model]
    for block in image.blocks:
        along = np.stack([block.rows[:, 0], np.zeros(len(block.rows)), block.rows[:, 1]], axis=1)
        added = np.stack([block.rows[:, 2], np.zeros(len(block.rows)), block.rows[:, 3]], axis=1)
        both.append(_of_model(image.bank, along, added)[0])
    return Extent(max(both, key=_size), model, table, jump, len(positions))


def _size(largest: Largest) -> float:
    return abs(largest.correction_mm)


def _of_table(image: Image) -> Largest | None:
    """Returns the largest row of the table; None where there is no table."""
    if not image.blocks:
        return None
    rows = np.concatenate([block.rows for block in image.blocks])
    row, column = np.unravel_index(int(np.abs(rows[:, 2:]).argmax()), (len(rows), 2))
    x, z, *added = rows[row].tolist()
    return Largest("XZ"[column], added[column], (x, 0.0, z))


def _grid(image: Image, bank: Bank) -> Array:
    """Places over the travel, (n, 3)."""
    along = []
    for axis, (low, high) in enumerate(image.limits.travel_mm):
        breaks = [body.breaks for body in bank.bodies if body.axis == axis]
        every = np.concatenate([np.linspace(low, high, STEPS + 1), *breaks])
        along.append(np.unique(np.clip(every, low, high)))
    return np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, 3)


def _of_model(bank: Bank, positions: Array, added: Array) -> tuple[Largest, float]:
    """Returns the largest of −E + added, and the largest jump of −E where one axis turns round."""
    best, jump, by_way = None, 0.0, {}
    spans = np.array([(s.low - s.reference, s.high - s.reference) for s in bank.signals]).reshape(-1, 2)
    for way in _ways(bank):
        parts = -_parts(bank, positions, np.array(way))
        parts[0] += added
        by_way[way] = parts
        found = _largest(bank, positions, parts, spans)
        best = found if best is None or _size(found) > _size(best) else best
    for way, axis in product(by_way, range(3)):
        back = tuple(-w if k == axis else w for k, w in enumerate(way))
        if way[axis] > 0:
            difference = by_way[way] - by_way[back]
            jump = max(jump, _size(_largest(bank, positions, difference, spans)))
    assert best is not None  # there is one way at least
    return best, jump


def _ways(bank: Bank) -> Iterator[tuple[float, ...]]:
    """Directions of travel of axes for which they count."""
    both = [any(body.axis == axis and body.powers.shape[0] == 3 for body in bank.bodies) for axis in range(3)]
    return product(*((1.0, -1.0) if counts else (0.0,) for counts in both))


def _parts(bank: Bank, positions: Array, way: Array) -> Array:
    """Returns E at the references and what one unit of each signal adds to it, (1 + signals, n, 3)."""
    travel, tool = np.tile(way, (len(positions), 1)), np.array(bank.tool_mm)
    found = []
    for signal in range(len(bank.signals) + 1):
        bodies = []
        for body in bank.bodies:
            powers = body.powers if signal == 0 else dict(body.per_unit).get(signal - 1)
            if powers is not None:
                bodies.append(Body(body.axis, body.breaks, powers, body.arm_mm + tool, body.carries))
        found.append(evaluator_of(bodies, bank.slope[signal]).error(positions, travel, 1))
    return np.array(found)


def _largest(bank: Bank, positions: Array, parts: Array, spans: Array) -> Largest:
    """Returns the largest over all places, each signal at that end of its range which makes it larger."""
    ends = parts[1:, :, :, None] * spans[:, None, None, :]
    high, low = parts[0] + ends.max(axis=-1).sum(axis=0), parts[0] + ends.min(axis=-1).sum(axis=0)
    sizes = np.maximum(high, -low)
    place, axis = np.unravel_index(int(sizes.argmax()), sizes.shape)
    above = high[place, axis] >= -low[place, axis]
    chosen = ends[:, place, axis].argmax(axis=-1) if above else ends[:, place, axis].argmin(axis=-1)
    signals = tuple((s.low, s.high)[end] for s, end in zip(bank.signals, chosen.tolist(), strict=True))
    x, y, z = positions[place].tolist()
    return Largest("XYZ"[axis], float((high if above else low)[place, axis]), (x, y, z), signals)
