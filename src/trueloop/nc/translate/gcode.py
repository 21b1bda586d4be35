"""Writes statements in the words of G code."""

from collections.abc import Callable, Mapping
from typing import Final

from trueloop.errors import Severity
from trueloop.nc.program.tool_path import CoordinateState
from trueloop.nc.translate import gcode_moves as moves
from trueloop.nc.translate.in_force import InForce, Target, Writing, block, number, once
from trueloop.nc.translate.statements import (
    Circle,
    Compensation,
    Dwell,
    End,
    Home,
    LengthOffset,
    Lost,
    Modes,
    Register,
    Remark,
    SpeedLimit,
    Spindle,
    Statement,
    Straight,
    Straights,
    Switch,
    Thread,
    ToolChange,
    Verbatim,
    WorkOffset,
)
from trueloop.nc.translate.tool_rows import edge, two_digits


def write(target: Target, state: InForce, statement: Statement) -> Writing:
    """The blocks of one statement."""
    return WRITERS[type(statement)](target, state, statement)


def remark(target: Target, state: InForce, said: Remark) -> Writing:
    """A comment."""
    yield target.dialect.comment(said.text)
    return state


def verbatim(_: Target, state: InForce, said: Verbatim) -> Writing:
    """A word as it stands."""
    yield said.text
    return state


def function(_: Target, state: InForce, said: Switch | End) -> Writing:
    """An M code."""
    yield f"M{said.code:02d}"
    return state


def _dwell(target: Target, state: InForce, said: Dwell) -> Writing:
    yield target.control.dwell.format(number(said.seconds, 3))
    return state


def _modes(target: Target, state: InForce, modes: Modes) -> Writing:
    control = target.control
    diameter = modes.diameter if modes.diameter in control.diameter else not modes.diameter
    unit = control.inch[modes.inch]
    if state.unless("unit", unit):
        state = state.now("feed", "")
    state = yield from once(state, unit=unit, diameter=control.diameter[diameter], absolute=control.absolute)
    state = InForce(state.at_mm, CoordinateState(modes.inch, diameter), state.words, state.rounded_mm)
    feed = control.feeds[modes.per_revolution]
    if state.unless("feed mode", feed):
        state = state.now("feed", "")
    return (yield from once(state, plane=control.planes.get(modes.plane, ""), **{"feed mode": feed}))


def _work_offset(target: Target, state: InForce, offset: WorkOffset) -> Writing:
    word = target.control.offsets.get(offset.number)
    if word is None:
        yield Lost(Severity.ERROR, f"{target.dialect.name} has no such work offset")
        return state
    return (yield from once(state.forget(0, 1, 2), **{"work offset": word}))


def _spindle(_: Target, state: InForce, spindle: Spindle) -> Writing:
    mode = "G96" if spindle.surface_speed else "G97"
    if state.unless("spindle", mode):
        state = state.now("speed", "")
    return (yield from once(state, spindle=mode, speed=f"S{spindle.speed:.10g}"))


def _speed_limit(target: Target, state: InForce, limit: SpeedLimit) -> Writing:
    if target.control.speed_limit is None:
        yield Lost(Severity.WARNING, f"the spindle's speed is not bounded to {limit.per_minute:g} 1/min")
    else:
        yield target.control.speed_limit.format(f"{limit.per_minute:.10g}")
    return state


def _tool(target: Target, state: InForce, tool: ToolChange) -> Writing:
    """T and what brings its offset into force."""
    state = state.now("tool", str(tool.number))
    if target.control.tool_offset == "T":
        row = tool.number if tool.offset is None else tool.offset
        yield from two_digits(tool.number, row)
        if tool.offset is None:
            yield Lost(Severity.WARNING, f"row {row} of the offset table comes into force with the tool")
        return state.now("tool offset", str(row))
    if target.control.tool_offset == "D":
        state = state.now("tool offset", "")  # a new tool comes with an edge of its own
    by_m6 = target.control.tool_offset == "G43" or tool.by_m6
    yield block(f"T{tool.number}", "M06" if by_m6 else "")
    if tool.offset is None:
        return state
    return (yield from _length_offset(target, state, LengthOffset(tool.offset, tool.offset != 0)))


def _length_offset(target: Target, state: InForce, offset: LengthOffset) -> Writing:
    """The row of the offset table, in the way of the control."""
    tool = int(state.words.get("tool", "0"))
    row = 0 if not offset.on else tool if offset.number is None else offset.number
    if not state.unless("tool offset", str(row)):
        return state
    match target.control.tool_offset:
        case "T":
            yield from two_digits(tool, row)
        case "D":
            yield from edge(target.rows.get(tool, ()), tool, row)
        case _:
            yield block("G43", f"H{row}" if row else "") if offset.on else "G49"
    return state.now("tool offset", str(row))


def _compensation(target: Target, state: InForce, compensation: Compensation) -> Writing:
    yield moves.compensation_words(target, compensation)
    return state


WRITERS: Final[Mapping[type, Callable[..., Writing]]] = {
    Remark: remark,
    Verbatim: verbatim,
    Switch: function,
    End: function,
    Dwell: _dwell,
    Modes: _modes,
    WorkOffset: _work_offset,
    Spindle: _spindle,
    SpeedLimit: _speed_limit,
    ToolChange: _tool,
    LengthOffset: _length_offset,
    Compensation: _compensation,
    Register: moves.register,
    Straight: moves.straight,
    Straights: moves.straights,
    Circle: moves.circle,
    Thread: moves.thread,
    Home: moves.home,
}
