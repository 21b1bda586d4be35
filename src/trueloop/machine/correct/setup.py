"""A machine as a program sees it: where its zero lies, how long its tools are, and COMP_MTG at the program's points."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import AxisKind, Vector
from trueloop.machine.model.compiled import CompiledModel, compile_model
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import check_state
from trueloop.nc.field.field import DisplaceInMachine, Field, machine_field
from trueloop.nc.field.machine_frame import looked_up, require_offsets
from trueloop.nc.program.cutter_tool import CutterTool

AXES: Final = "XYZ"
ANY_TOOL: Final = -1
HINT: Final = (
    "the model lives in machine coordinates: give --work-zero 1=X,Y,Z for G54, --tool T=X,Y,Z, or a file of --offsets"
)


@dataclass(frozen=True)
class Setup:
    """What a program does not say: where its zero lies, how long its tools are, how warm the machine is.

    `work_zero_mm`: machine coordinates of the program's zero by number of the work offset (1 is G54), for a tool of
    no length. `tool_mm`: tool point from the frame of the last axis, by T number; under −1 for every other tool.
    `fixed`: where rotary axes stand, which the program has to leave alone, rad; 0 for those not named. `table`: the
    control's tool table, where it is given: a tool that is not in `tool_mm` has its point at minus the offset that the
    program brings into force, because machine = program + work zero + offset. `zero_signals` are those of the moment
    when the work zero was set, where what had drifted by then lies in it.

    >>> setup = trueloop.Setup({1: (250.0, 0.0, -150.0)}, signals={"T1": 25.0})
    >>> setup.tool_mm[-1]  # every tool: its point is at the frame of the last axis
    (0.0, 0.0, 0.0)
    """

    work_zero_mm: Mapping[int, Vector]
    tool_mm: Mapping[int, Vector] = field(default_factory=lambda: {ANY_TOOL: (0.0, 0.0, 0.0)})
    signals: Signals = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    table: Sequence[CutterTool] | None = None
    zero_signals: Signals | None = None


def compensation_field(
    model: MachineModel, setup: Setup, identity: dict[str, object], extrapolate: Collection[str] = ()
) -> Field:
    """COMP_MTG = −E at every point of a program, along the program's X, Y, Z, for `map_program`.

    An axis that the machine does not have is not displaced. Raises MCH-FRAME for a turned head; asked for a point it
    raises MCH-FRAME (an unknown work offset or tool), MCH-TRAVEL and MCH-RANGE.
    """
    _check_head_upright(model, setup)
    rotary = frozenset(axis.name for axis in model.machine.chain.axes if axis.kind is AxisKind.ROTARY)
    backlash = any(term.both_ways for term in model.terms)
    return machine_field(
        _displacement(model, setup, extrapolate),
        identity,
        knows_travel=backlash,
        still=rotary,
        tools=setup.table,
        work_mm=setup.work_zero_mm,
    )


def state_at(
    model: MachineModel,
    setup: Setup,
    points_mm: Array,
    work: Integers,
    tool: Integers,
    travel: Array,
    offset_mm: Array | None = None,
) -> State:
    """Axis positions at program points (n, 3): point + work zero − tool vector; travel (n, 3) along X, Y, Z.

    `offset_mm` (n, 3) are the tool offsets in force, none unless given. Raises MCH-FRAME for what is not known.
    """
    offset_mm = np.zeros((len(points_mm), 3)) if offset_mm is None else offset_mm
    return _state(model, setup, points_mm, work, travel, _tool_points_mm(setup, tool, offset_mm))


def _state(model: MachineModel, setup: Setup, points_mm: Array, work: Integers, travel: Array, tool_mm: Array) -> State:
    chain = model.machine.chain
    axes = points_mm + looked_up(work, setup.work_zero_mm, "work offset", HINT) - tool_mm
    given: dict[str, Array | float] = dict(setup.fixed)
    given |= {name: axes[:, k] for k, name in enumerate(AXES) if name in chain.order}
    ways = [travel[:, AXES.index(name)] if name in AXES else np.zeros(len(axes)) for name in chain.order]
    return State(chain.positions(given), np.stack(ways, axis=-1), setup.signals, tool_mm)


def _displacement(model: MachineModel, setup: Setup, extrapolate: Collection[str]) -> DisplaceInMachine:
    """−E along the machine's own axes, which are the program's: a turned table carries no coordinates with it."""
    there = np.array([name in model.machine.chain.order for name in AXES])

    @cache
    def compiled(tool_mm: Vector) -> CompiledModel:
        return compile_model(model, setup.signals, tool_mm, setup.fixed)

    def displace(points_mm: Array, work: Integers, tool: Integers, travel: Array, offset_mm: Array) -> Array:
        tool_mm = _tool_points_mm(setup, tool, offset_mm)
        check_state(model, _state(model, setup, points_mm, work, travel, tool_mm), extrapolate)
        axes = points_mm + looked_up(work, setup.work_zero_mm, "work offset", HINT) - tool_mm
        compensation = np.empty_like(points_mm)
        for x, y, z in np.unique(tool_mm, axis=0).tolist():
            own = (tool_mm == (x, y, z)).all(axis=1)
            error_mm = compiled((x, y, z)).bed_error_mm(axes[own], travel[own])
            compensation[own] = np.where(there, -error_mm, 0.0)
        return compensation

    return displace


def _tool_points_mm(setup: Setup, tool: Integers, offset_mm: Array) -> Array:
    """Tool points (n, 3) from the frame of the last axis. Raises MCH-FRAME for a tool of which none is known."""
    named = np.isin(tool, list(setup.tool_mm))
    if setup.table is None:
        return looked_up(np.where(named, tool, ANY_TOOL), setup.tool_mm, "tool", HINT)
    require_offsets(tool[~named], offset_mm[~named], HINT)
    points = -offset_mm
    points[named] = looked_up(tool[named], setup.tool_mm, "tool", HINT)
    return points


def _check_head_upright(model: MachineModel, setup: Setup) -> None:
    """With a head turned, tool vectors would no longer be what work offsets are taken off."""
    for axis in model.machine.chain.tool:
        if setup.fixed.get(axis.name, 0.0) != 0.0:
            raise TrueloopError(
                Code.MCH_FRAME,
                f"{axis.name} turns the tool by {setup.fixed[axis.name]:g} rad: the place of its tip is not given",
                hint="only rotary axes that carry the work may stand away from 0",
            )
