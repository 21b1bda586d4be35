"""A model reduced to what a control's table holds: the error along one axis as a function of one axis' position."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import ZERO, Axis, AxisKind, Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import check_signals, check_travel

CHECKS = 16
"""Points between two entries at which the table is compared with the model."""


@dataclass(frozen=True)
class AxisTable:
    """E along `output` at positions of `input_axis`, mm: (n,) forward and return. Between entries it is linear.

    `deviation_mm` is the largest difference to the model along the line of the table, all other axes at the base
    position, however they came there; elsewhere the model differs by what other axes do, up to `elsewhere_mm` over the
    corners of travel and their ways there.
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

    How the other axes came where they stand a table does not know: it holds the mean of both ways.
    Raises MCH-AXIS where `input_axis` and `output` are no linear axes of the machine, MCH-TRAVEL for an axis without
    travel and for others beyond theirs, MCH-RANGE for signals beyond the data that `extrapolate` does not name.
    """
    chain = model.machine.chain
    low, high = _linear(chain.axis(input_axis), "runs over").travel
    _linear(chain.axis(output), "corrects")
    for name, position in base.items():
        check_travel(chain.axis(name), np.array([position]))
    check_signals(model, signals or {}, extrapolate)
    if not np.isfinite([low, high]).all():
        raise TrueloopError(
            Code.MCH_TRAVEL,
            f"{input_axis} travels from {low:g} to {high:g} mm: {count} entries have no places",
            hint=f"give [axes.{input_axis}] its travel_mm in the machine file and fit the model again",
            values={"axis": input_axis, "travel": [low, high], "unit": "mm"},
        )
    positions = np.linspace(low, high, count)
    dense = np.linspace(low, high, (count - 1) * CHECKS + 1)

    def error(at: Array, way: float, others: Mapping[str, float], ways: Mapping[str, float]) -> Array:
        placed = chain.positions({**others, input_axis: at})
        travel = np.array([{**ways, input_axis: way}.get(name, 0.0) for name in chain.order])
        state = State(placed, np.broadcast_to(travel, placed.shape), signals or {}, tool_mm)
        along: Array = model.error_mm(state)[:, "XYZ".index(output)]
        return along

    forward, reverse = error(positions, 1.0, base, {}), error(positions, -1.0, base, {})
    table = AxisTable(input_axis, output, positions, forward, reverse, 0.0, 0.0)

    def off(others: Mapping[str, float]) -> float:
        return max(
            float(np.abs(table.error_mm(dense, way) - error(dense, way, others, ways)).max())
            for way, ways in product((1.0, -1.0), _ways(model, input_axis))
        )

    here = off(base)
    return replace(table, deviation_mm=here, elsewhere_mm=max([here, *map(off, _corners(model, input_axis))]))


def _linear(axis: Axis, does: str) -> Axis:
    if axis.kind is not AxisKind.LINEAR:
        raise TrueloopError(
            Code.MCH_AXIS,
            f"the table {does} {axis.name}, which turns: 1 of X, Y, Z is wanted",
            hint="tables hold millimetres as a function of millimetres",
        )
    return axis


def _ways(model: MachineModel, input_axis: str) -> list[dict[str, float]]:
    """The ways of travel of the other axes, of those for which it matters."""
    both = {term.name.axis for term in model.terms if term.both_ways} - {input_axis}
    return [dict(zip(sorted(both), ways, strict=True)) for ways in product((1.0, -1.0), repeat=len(both))]


def _corners(model: MachineModel, input_axis: str) -> list[dict[str, float]]:
    """All ends of travel of the other axes together; axes without end stand at 0."""
    ends = {axis.name: axis.travel for axis in model.machine.chain.axes if np.isfinite(axis.travel).all()}
    ends = {name: ends[name] for name in model.machine.chain.order if name in ends and name != input_axis}
    return [dict(zip(ends, corner, strict=True)) for corner in product(*ends.values())]
