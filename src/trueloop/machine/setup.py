"""A machine as a program sees it: where its zero lies, how long its tools are, and COMP_MTG at the program's points."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.chain import AxisKind, Vector
from trueloop.machine.compiled import CompiledModel, compile_model
from trueloop.machine.model import MachineModel, State
from trueloop.machine.term import Signals
from trueloop.machine.validity import check_state
from trueloop.nc.field import DisplaceInMachine, Field, machine_field
from trueloop.nc.tool_path import Integers

AXES: Final = "XYZ"
ANY_TOOL: Final = -1


@dataclass(frozen=True)
class Setup:
    """What a program does not say: where its zero lies, how long its tools are, how warm the machine is.

    `work_zero_mm`: machine coordinates of the program's zero by number of the work offset (1 is G54), for a tool of
    no length. `tool_mm`: tool point from the frame of the last axis, by T number; under −1 for every other tool.
    `fixed`: where rotary axes stand, which the program has to leave alone, rad; 0 for those not named.
    """

    work_zero_mm: Mapping[int, Vector]
    tool_mm: Mapping[int, Vector] = field(default_factory=lambda: {ANY_TOOL: (0.0, 0.0, 0.0)})
    signals: Signals = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)


def compensation_field(
    model: MachineModel, setup: Setup, told: dict[str, object], extrapolate: Collection[str] = ()
) -> Field:
    """COMP_MTG = −E at every point of a program, along the program's X, Y, Z, for `map_program`.

    An axis that the machine does not have is not displaced. Raises MCH-FRAME for a turned head; asked for a point it
    raises MCH-FRAME (an unknown work offset or tool), MCH-TRAVEL and MCH-RANGE.
    """
    _check_head_upright(model, setup)
    rotary = frozenset(axis.name for axis in model.machine.chain.axes if axis.kind is AxisKind.ROTARY)
    backlash = any(term.both_ways for term in model.terms)
    return machine_field(_displacement(model, setup, extrapolate), told, knows_travel=backlash, still=rotary)


def state_at(
    model: MachineModel, setup: Setup, points_mm: Array, work: Integers, tool: Integers, travel: Array
) -> State:
    """Axis positions at program points (n, 3): point + work zero − tool vector; travel (n, 3) along X, Y, Z."""
    chain = model.machine.chain
    tool_mm = _looked_up(_known_tools(setup, tool), setup.tool_mm, "tool")
    axes = points_mm + _looked_up(work, setup.work_zero_mm, "work offset") - tool_mm
    given: dict[str, Array | float] = dict(setup.fixed)
    given |= {name: axes[:, k] for k, name in enumerate(AXES) if name in chain.order}
    ways = [travel[:, AXES.index(name)] if name in AXES else np.zeros(len(axes)) for name in chain.order]
    return State(chain.positions(given), np.stack(ways, axis=-1), setup.signals, tool_mm)


def _displacement(model: MachineModel, setup: Setup, extrapolate: Collection[str]) -> DisplaceInMachine:
    """−E along the machine's own axes, which are the program's: a turned table carries no coordinates with it."""
    there = np.array([name in model.machine.chain.order for name in AXES])

    @cache
    def compiled(tool: int) -> CompiledModel:
        return compile_model(model, setup.signals, setup.tool_mm[tool], setup.fixed)

    def displace(points_mm: Array, work: Integers, tool: Integers, travel: Array) -> Array:
        check_state(model, state_at(model, setup, points_mm, work, tool, travel), extrapolate)
        zero_mm = _looked_up(work, setup.work_zero_mm, "work offset")
        compensation = np.empty_like(points_mm)
        known = _known_tools(setup, tool)
        for number in np.unique(known):
            own = known == number
            axes = points_mm[own] + zero_mm[own] - np.array(setup.tool_mm[int(number)])
            compensation[own] = np.where(there, -compiled(int(number)).bed_error_mm(axes, travel[own]), 0.0)
        return compensation

    return displace


def _known_tools(setup: Setup, tool: Integers) -> Integers:
    """T words with a length of their own, −1 for the others. Raises MCH-FRAME where that is not given either."""
    known = np.where(np.isin(tool, list(setup.tool_mm)), tool, ANY_TOOL)
    _looked_up(known, setup.tool_mm, "tool")
    return known


def _check_head_upright(model: MachineModel, setup: Setup) -> None:
    """With a head turned, tool vectors would no longer be what work offsets are taken off."""
    for axis in model.machine.chain.tool:
        if setup.fixed.get(axis.name, 0.0) != 0.0:
            raise TrueloopError(
                Code.MCH_FRAME,
                f"{axis.name} turns the tool by {setup.fixed[axis.name]:g} rad: where its tip lies is not told",
                hint="only rotary axes that carry the work may stand away from 0",
            )


def _looked_up(numbers: Integers, table: Mapping[int, Vector], what: str) -> Array:
    vectors = np.zeros((len(numbers), 3))
    for number in np.unique(numbers):
        if int(number) not in table:
            given = ", ".join(str(n) for n in table) or "none"
            raise TrueloopError(
                Code.MCH_FRAME,
                f"{what} {int(number)} is used, but only {given} is known in machine coordinates",
                hint="the model lives in machine coordinates: give --work-zero 1=X,Y,Z for G54, --tool T=X,Y,Z",
            )
        vectors[numbers == number] = table[int(number)]
    return vectors
