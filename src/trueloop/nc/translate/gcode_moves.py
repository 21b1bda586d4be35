"""Moves in the words of G code: absolute positions, arcs by their centres from the start."""

import math
from dataclasses import replace
from typing import Final

from trueloop._core import nc_straights
from trueloop.errors import Severity
from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.program.tool_path import NO_COMPENSATION
from trueloop.nc.translate import arcs
from trueloop.nc.translate.in_force import InForce, Target, Writing, block, decimals, number, once, position, step_mm
from trueloop.nc.translate.statements import (
    Circle,
    Compensation,
    Home,
    Lost,
    Partial,
    Register,
    Straight,
    Straights,
    Thread,
)

AXES = "XYZ"
CENTRES = "IJK"
_FEED_DECIMALS: Final = 6


def register(target: Target, state: InForce, said: Register) -> Writing:
    """The position register set."""
    words, state = _positions(target, state, said.at_mm)
    yield block(target.control.register or "", *words)
    return state


def _positions(target: Target, state: InForce, at_mm: Partial) -> tuple[list[str], InForce]:
    words = []
    for axis, value_mm in enumerate(at_mm):
        if value_mm is not None:
            text, state = position(target, state, axis, value_mm)
            words.append(AXES[axis] + text)
    return words, state


def compensation_words(target: Target, compensation: Compensation | None) -> str:
    """G40 to G42, with the tool where it is named."""
    if compensation is None:
        return ""
    named = target.control.names_compensation and compensation.tool is not None and compensation.side != NO_COMPENSATION
    return block(f"G{compensation.side}", f"D{compensation.tool}" if named else "")


def _feed(state: InForce, feed: float | None) -> tuple[str, InForce]:
    if feed is None:
        return "", state
    word = f"F{number(feed / state.coordinates.unit_mm('F'), _FEED_DECIMALS)}"
    return state.unless("feed", word), state.now("feed", word)


def straight(target: Target, state: InForce, straight: Straight) -> Writing:
    """A rapid move or a line."""
    if straight.machine and target.control.machine is None:
        yield Lost(Severity.ERROR, f"{target.dialect.name} has no moves in machine coordinates")
        return state
    words, state = _positions(target, state, straight.end_mm)
    if not words and straight.compensation is None:
        return state
    feed, state = _feed(state, straight.feed)
    machine = (target.control.machine or "") if straight.machine else ""
    code = "G00" if straight.rapid else "G01"
    yield block(machine, code, compensation_words(target, straight.compensation), *words, feed)
    if straight.machine:
        return state.forget(*(axis for axis in range(3) if straight.end_mm[axis] is not None))
    return state


def straights(target: Target, state: InForce, said: Straights) -> Writing:
    """Rapid moves and lines, a block each."""
    unit_mm = state.coordinates.unit_mm
    units_mm = (unit_mm("X"), unit_mm("Y"), unit_mm("Z"))
    style = (["G00", "G01"], "", units_mm, unit_mm("F"), decimals(target, state), _FEED_DECIMALS, False)
    feed = state.words.get("feed", "")
    text, (at_mm, rounded_mm, _, feed) = nc_straights(
        (said.end_mm, said.rapid, said.feed), style, "", (state.at_mm, state.rounded_mm, feed, feed)
    )
    yield from text.splitlines()
    return replace(state, at_mm=at_mm, rounded_mm=rounded_mm).now("feed", feed)


def circle(target: Target, state: InForce, circle: Circle) -> Writing:
    """An arc, in pieces."""
    word = target.control.planes.get(circle.plane)
    if word is None:
        yield Lost(Severity.ERROR, f"an arc in the plane G{circle.plane}", refuses=True)
        return state
    state = yield from once(state, plane=word)
    for piece in arcs.pieces(circle, step_mm(target, state)):
        if isinstance(piece, Straight):
            state = yield from straight(target, state, piece)
        else:
            state = yield from _arc_block(target, state, piece)
    return state


def _arc_block(target: Target, state: InForce, circle: Circle) -> Writing:
    in_plane = sorted(PLANE_AXES[circle.plane])
    began = [circle.start_mm[k] if math.isnan(at) else at for k, at in enumerate(state.at_mm)]
    x, y, z = (circle.end_mm[k] if k in in_plane or circle.rises else None for k in range(3))
    words, state = _positions(target, state, (x, y, z))
    unit_mm, places = state.coordinates.unit_mm("I"), decimals(target, state)
    centres = [CENTRES[k] + number((circle.centre_mm[k] - began[k]) / unit_mm, places) for k in in_plane]
    feed, state = _feed(state, circle.feed)
    yield block("G02" if circle.sweep_rad > 0 else "G03", *words, *centres, feed)
    return state


def thread(target: Target, state: InForce, thread: Thread) -> Writing:
    """A pass of a thread."""
    if target.control.thread is None:
        yield Lost(Severity.ERROR, "a thread", refuses=True)
        return state
    words, state = _positions(target, state, thread.end_mm)
    letter = target.control.lead[thread.axis % len(target.control.lead)]
    lead = thread.lead * (thread.slant if target.dialect.lead_along_thread else 1.0)
    yield block(target.control.thread, *words, f"{letter}{number(lead, 6)}")
    return state.now("feed", "")


def home(target: Target, state: InForce, said: Home) -> Writing:
    """The way to the reference point."""
    axes = said.axes
    if target.control.home is None:
        yield Lost(Severity.ERROR, f"{target.dialect.name} has no words for the way to the reference point")
        return state.forget(*axes)
    code, back = target.control.home
    yield block(code, *(f"{target.control.home_letters[axis]}0" for axis in axes))
    if back:
        yield back
    return state.forget(*axes)
