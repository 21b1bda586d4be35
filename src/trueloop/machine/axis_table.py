"""A model reduced to what a control's table holds: the error along one axis as a function of one axis' position."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.machine.chain import ZERO, Vector
from trueloop.machine.model import MachineModel, State
from trueloop.machine.term import Signals
from trueloop.machine.validity import check_signals, check_travel

CHECKS = 16
"""Points between two entries at which the table is compared with the model."""


@dataclass(frozen=True)
class AxisTable:
    """E along `output` at positions of `input_axis`, mm: (n,) forward and return. Between entries it is linear.

    `deviation_mm` is the largest difference to the model along the line of the table, all other axes at the base
    position; elsewhere the model differs by what other axes do, up to `elsewhere_mm` over the corners of travel.
    """

    input_axis: str
    output: str
    position_mm: Array
    forward_mm: Array
    reverse_mm: Array
    deviation_mm: float
    elsewhere_mm: float

    def error_mm(self, position_mm: Array, way: float) -> Array:
        """What the table says, (n,); end values hold outside."""
        values = self.forward_mm if way > 0 else self.reverse_mm
        return np.interp(position_mm, self.position_mm, values)


def axis_table(
    model: MachineModel,
    input_axis: str,
    output: str,
    count: int,
    base: Mapping[str, float],
    signals: Signals | None = None,
    tool_mm: Vector = ZERO,
    extrapolate: Collection[str] = (),
) -> AxisTable:
    """`count` equal steps over the travel of `input_axis`; `base` holds the positions of the other axes.

    Raises MCH-TRAVEL for others beyond travel, MCH-RANGE for signals beyond the data that `extrapolate` does not name.
    """
    for name, position in base.items():
        check_travel(model.machine.chain.axis(name), np.array([position]))
    check_signals(model, signals or {}, extrapolate)
    low, high = model.machine.chain.axis(input_axis).travel
    positions = np.linspace(low, high, count)
    dense = np.linspace(low, high, (count - 1) * CHECKS + 1)

    def error(at: Array, way: float, others: Mapping[str, float]) -> Array:
        given: dict[str, Array | float] = {**others, input_axis: at}
        state = State(model.machine.chain.positions(given), way, signals or {}, tool_mm)
        along: Array = model.error_mm(state)[:, "XYZ".index(output)]
        return along

    forward, reverse = error(positions, 1.0, base), error(positions, -1.0, base)
    table = AxisTable(input_axis, output, positions, forward, reverse, 0.0, 0.0)
    corners = [base, *_corners(model, input_axis)]
    off = [
        max(float(np.abs(table.error_mm(dense, way) - error(dense, way, others)).max()) for way in (1.0, -1.0))
        for others in corners
    ]
    return AxisTable(input_axis, output, positions, forward, reverse, off[0], max(off))


def _corners(model: MachineModel, input_axis: str) -> list[dict[str, float]]:
    corners: list[dict[str, float]] = [{}]
    for name in model.machine.chain.order:
        low, high = model.machine.chain.axis(name).travel
        if name != input_axis and np.isfinite(low) and np.isfinite(high):
            corners = [corner | {name: end} for corner in corners for end in (low, high)]
    return corners
