"""Writes statements in Klartext: L, CC with C or CP, TOOL CALL; millimetres always, feed a minute."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from trueloop._core import nc_straights
from trueloop.errors import Severity
from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.translate import arcs, gcode
from trueloop.nc.translate.in_force import InForce, Target, Writing, block, decimals, number, position, step_mm
from trueloop.nc.translate.statements import (
    Circle,
    Compensation,
    Dwell,
    End,
    Home,
    LengthOffset,
    Lost,
    Modes,
    Remark,
    SpeedLimit,
    Spindle,
    Statement,
    Straight,
    Straights,
    Switch,
    Thread,
    ToolChange,
    Vector,
    Verbatim,
    WorkOffset,
)

AXES = "XYZ"
SIDES = {40: "R0", 41: "RL", 42: "RR"}
_FEED_DECIMALS = 3
_ANGLE_DECIMALS = 2
"""More than of lengths: at 500 mm from the pole that is a twentieth of a step."""


def write(target: Target, state: InForce, statement: Statement) -> Writing:
    """The blocks of one statement, without their numbers."""
    return WRITERS[type(statement)](target, state, statement)


def numbered(lines: Sequence[str], name: str) -> list[str]:
    """The blocks of a program of that name, with their numbers from 0."""
    framed = [f"BEGIN PGM {name} MM", *lines, f"END PGM {name} MM"]
    return [f"{number} {line}" for number, line in enumerate(framed)]


def _function(_: Target, state: InForce, said: Switch | End) -> Writing:
    yield f"M{said.code}"
    return state


def _dwell(_: Target, state: InForce, said: Dwell) -> Writing:
    yield "CYCL DEF 9.0 DWELL TIME"
    yield f"CYCL DEF 9.1 DWELL {number(said.seconds, 3)}"
    return state


def _modes(_: Target, state: InForce, modes: Modes) -> Writing:
    yield ""
    return state.now("feed mode", "revolution" if modes.per_revolution else "minute")


def _work_offset(target: Target, state: InForce, offset: WorkOffset) -> Writing:
    if offset.number not in target.control.offsets:
        yield Lost(Severity.ERROR, f"{target.dialect.name} has no such work offset")
    else:
        yield Lost(Severity.NOTE, "the preset in force at the control is taken")
    return state.forget(0, 1, 2)


def _speed_limit(_: Target, state: InForce, limit: SpeedLimit) -> Writing:
    yield Lost(Severity.WARNING, f"the spindle's speed is not bounded to {limit.per_minute:g} 1/min")
    return state


def _tool(_: Target, state: InForce, tool: ToolChange) -> Writing:
    yield block(f"TOOL CALL {tool.number} Z", state.words.get("speed", ""))
    return state.now("tool", str(tool.number))


def _length_offset(target: Target, state: InForce, offset: LengthOffset) -> Writing:
    tool = int(state.words.get("tool", "0"))
    if offset.on and offset.number not in (None, tool):
        one_of_several = len(target.rows.get(tool, ())) > 1
        severity = Severity.ERROR if one_of_several else Severity.WARNING
        yield Lost(severity, f"row {offset.number} of the offset table: TOOL CALL takes the length of tool {tool}")
    elif offset.on:
        yield Lost(Severity.NOTE, "TOOL CALL takes the tool's length")
    elif state.words.get("tool"):
        yield Lost(Severity.WARNING, "the tool's length stays in force: TOOL CALL has taken it")
    return state


def _compensation(_: Target, state: InForce, compensation: Compensation) -> Writing:
    yield ""
    return state.now("wanted side", SIDES[compensation.side])


def _thread(_: Target, state: InForce, __: Thread) -> Writing:
    yield Lost(Severity.ERROR, "a thread", refuses=True)
    return state


def _home(target: Target, state: InForce, home: Home) -> Writing:
    yield Lost(Severity.ERROR, f"{target.dialect.name} has no words for the way to the reference point")
    return state.forget(*home.axes)


def _spindle(_: Target, state: InForce, spindle: Spindle) -> Writing:
    if spindle.surface_speed:
        yield Lost(Severity.ERROR, f"the constant surface speed {spindle.speed:g} is not kept")
        return state.now("speed", "")
    speed = f"S{spindle.speed:.10g}"
    if state.unless("speed", speed):
        yield block("TOOL CALL", state.words.get("tool", ""), "Z", speed)
    return state.now("speed", speed)


def _signed(text: str) -> str:
    """As the control writes numbers: with their sign, whole ones without a point."""
    plain = text.removesuffix(".0")
    return plain if plain.startswith("-") else f"+{plain}"


def _feed(state: InForce, feed: float | None) -> Writing:
    """The F word in force afterwards, in mm/min; it is written where it is new."""
    if feed is None:
        return state
    speed = state.words.get("speed", "")
    if state.words.get("feed mode") == "revolution":
        if not speed:
            yield Lost(Severity.ERROR, f"the feed of {feed:g} mm/rev, without the spindle's speed")
            return state
        feed *= float(speed[1:])
    return state.now("wanted feed", f"F{number(feed, _FEED_DECIMALS).removesuffix('.0')}")


def _words(target: Target, state: InForce, straight: Straight) -> tuple[list[str], InForce]:
    words = []
    for axis, value_mm in enumerate(straight.end_mm):
        if value_mm is not None:
            text, state = position(target, state, axis, value_mm)
            words.append(AXES[axis] + _signed(text))
    return words, state


def _straight(target: Target, state: InForce, straight: Straight) -> Writing:
    words, state = _words(target, state, straight)
    if not words and straight.compensation is None:
        return state
    side = SIDES[straight.compensation.side] if straight.compensation else state.words.get("wanted side", "R0")
    state = yield from _feed(state, straight.feed)
    wanted = state.words.get("wanted feed", "")
    feed = "FMAX" if straight.rapid else state.unless("feed", wanted)
    yield block("L", *words, state.unless("side", side), feed, "M91" if straight.machine else "")
    state = state.now("side", side).now("wanted side", side)
    if straight.machine:
        return state.forget(*(axis for axis in range(3) if straight.end_mm[axis] is not None))
    return state if straight.rapid else state.now("feed", wanted)


def _straights(target: Target, state: InForce, said: Straights) -> Writing:
    """Lines, a block each, with the side of the cutter in the first where it is new."""
    side = state.words.get("wanted side", "R0")
    style = (["L", "L"], "FMAX", (1.0, 1.0, 1.0), 1.0, decimals(target, state), _FEED_DECIMALS, True)
    feeds = state.words.get("wanted feed", ""), state.words.get("feed", "")
    text, (at_mm, rounded_mm, wanted, feed) = nc_straights(
        (said.end_mm, said.rapid, said.feed), style, state.unless("side", side), (state.at_mm, state.rounded_mm, *feeds)
    )
    if not text:
        return state
    yield from text.splitlines()
    words = {"side": side, "wanted side": side, "wanted feed": wanted, "feed": feed}
    return replace(state, at_mm=at_mm, rounded_mm=rounded_mm, words={**state.words, **words})


def _circle(target: Target, state: InForce, circle: Circle) -> Writing:
    if state.words.get("wanted side", "R0") != state.words.get("side", "R0"):
        yield Lost(Severity.ERROR, "compensation that begins or ends with an arc", refuses=True)
    if circle.plane != 17:
        yield Lost(Severity.WARNING, f"an arc in the plane G{circle.plane}: see on air that it turns the right way")
    rise = _rise(target, state, circle)
    if float(rise):  # no helix where the third axis is only named: what CP leads to is not where the next block begins
        return (yield from _helix(target, state, circle, rise))
    for piece in arcs.pieces(circle, step_mm(target, state)):
        if isinstance(piece, Straight):
            state = yield from _straight(target, state, piece)
        else:
            state = yield from _arc(target, state, piece)
    return state


def _pole(target: Target, state: InForce, circle: Circle) -> tuple[str, Vector]:
    """The block of the pole, and the pole as it is written."""
    plane = sorted(PLANE_AXES[circle.plane])
    texts = {axis: position(target, state, axis, circle.centre_mm[axis])[0] for axis in plane}
    x, y, z = (float(texts.get(axis, circle.start_mm[axis])) for axis in range(3))
    return block("CC", *(AXES[axis] + _signed(texts[axis]) for axis in plane)), (x, y, z)


def _arc(target: Target, state: InForce, circle: Circle) -> Writing:
    yield _pole(target, state, circle)[0]
    state = yield from _feed(state, circle.feed)
    x, y, z = (circle.end_mm[k] if k in PLANE_AXES[circle.plane] else None for k in range(3))
    words, state = _words(target, state, Straight(False, (x, y, z)))
    wanted = state.words.get("wanted feed", "")
    yield block("C", *words, "DR-" if circle.sweep_rad > 0 else "DR+", state.unless("feed", wanted))
    return state.now("feed", wanted)


def _rise(target: Target, state: InForce, circle: Circle) -> str:
    third = 3 - sum(PLANE_AXES[circle.plane])
    began_mm = _known(state.at_mm, circle.start_mm)
    return position(target, state, third, circle.end_mm[third] - began_mm[third])[0]


def _helix(target: Target, state: InForce, circle: Circle, rise: str) -> Writing:
    """By increments of angle and height about the pole: C has no third axis. The end is where these lead."""
    third = 3 - sum(PLANE_AXES[circle.plane])
    pole, pole_mm = _pole(target, state, circle)
    yield pole
    state = yield from _feed(state, circle.feed)
    angle = number(-math.degrees(circle.sweep_rad), decimals(target, state) + _ANGLE_DECIMALS)
    began_mm = _known(state.at_mm, circle.start_mm)
    wanted = state.words.get("wanted feed", "")
    way = "DR-" if circle.sweep_rad > 0 else "DR+"
    yield block(f"CP IPA{_signed(angle)} I{AXES[third]}{_signed(rise)}", way, state.unless("feed", wanted))
    end_mm = _turned(began_mm, pole_mm, math.radians(float(angle)), circle.plane, float(rise))
    off_mm = max(abs(at - true) for at, true in zip(end_mm, circle.end_mm, strict=True))
    state = replace(state, at_mm=end_mm, rounded_mm=max(state.rounded_mm, off_mm))
    return state.now("feed", wanted)


def _known(at_mm: Vector, otherwise_mm: Vector) -> Vector:
    x, y, z = (other if math.isnan(at) else at for at, other in zip(at_mm, otherwise_mm, strict=True))
    return x, y, z


def _turned(start_mm: Vector, pole_mm: Vector, angle_rad: float, plane: int, rise_mm: float) -> Vector:
    """The start turned about the pole from the plane's first axis to its second, and moved along the third."""
    first, second = PLANE_AXES[plane]
    u, v = start_mm[first] - pole_mm[first], start_mm[second] - pole_mm[second]
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    ends = {first: pole_mm[first] + cos * u - sin * v, second: pole_mm[second] + sin * u + cos * v}
    x, y, z = (ends.get(axis, start_mm[axis] + rise_mm) for axis in range(3))
    return x, y, z


WRITERS: Final[Mapping[type, Callable[..., Writing]]] = {
    Remark: gcode.remark,
    Verbatim: gcode.verbatim,
    Switch: _function,
    End: _function,
    Dwell: _dwell,
    Modes: _modes,
    WorkOffset: _work_offset,
    Spindle: _spindle,
    SpeedLimit: _speed_limit,
    ToolChange: _tool,
    LengthOffset: _length_offset,
    Compensation: _compensation,
    Straight: _straight,
    Straights: _straights,
    Circle: _circle,
    Thread: _thread,
    Home: _home,
}
