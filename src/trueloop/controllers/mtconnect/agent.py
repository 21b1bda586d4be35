"""Reads an agent over HTTP without a gap: `/probe`, `/current`, then `/sample` from number to number.

An agent that was started anew numbers from the beginning, and one that is asked too late no longer has what was missed:
both are told, and reading goes on with what is current.
"""

import math
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Final
from urllib.error import HTTPError

from trueloop.controllers.linuxcnc.realtime.signals.mtconnect import LARGEST, Current, fetched, is_address, read_current
from trueloop.controllers.linuxcnc.realtime.signals.readings import unix_s
from trueloop.controllers.mtconnect.items import (
    AXES,
    LINEAR,
    NONE,
    UNAVAILABLE,
    Condition,
    Machine,
    Value,
    items,
    number,
)
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.rows import number_of

SIGNALS: Final = "rtec-signals."
HEARTBEAT: Final = f"{SIGNALS}heartbeat"
_MODES: Final = {"MANUAL": "MANUAL", "AUTO": "AUTOMATIC", "MDI": "MANUAL_DATA_INPUT"}


@dataclass(frozen=True)
class Limits:
    """Older than this a source counts as silent, s."""

    status_s: float = 2.0
    temperature_s: float = 60.0


@dataclass(frozen=True)
class MachineReport:
    """LinuxCNC's status, None: it does not run; values of pins; whether the corrector's signals are alive; the part."""

    status: Mapping[str, Any] | None
    pins: Mapping[str, float | None]
    signals_alive: bool = True
    part: str = ""


def nothing(machine: Machine) -> dict[str, Value]:
    """Returns all items as they are while no state is known: unavailable."""
    return {item.key: NONE if item.condition else UNAVAILABLE for item in items(machine)}


def pins_of(machine: Machine) -> list[str]:
    """Returns all pins that are read. A signal of the corrector comes with its age and the heartbeat."""
    named = [*machine.temperatures.values(), *machine.corrections.values(), machine.part_count]
    ages = [age for pin in named if (age := _age(pin))]
    return list(dict.fromkeys([*filter(None, named), *ages, *([HEARTBEAT] if ages else [])]))


def observed(machine: Machine, report: MachineReport, limits: Limits) -> dict[str, Value]:
    """Returns every item's value, in the order of the items."""
    found = nothing(machine)
    if report.status is not None:
        found.update(_of_status(machine, report.status))
        found.update(_of_pins(machine, report, limits))
        found["part_id"] = report.part or UNAVAILABLE
    return found


def _of_status(machine: Machine, status: Mapping[str, Any]) -> Iterator[tuple[str, Value]]:
    yield "avail", "AVAILABLE"
    for axis in machine.axes:
        yield f"{axis}pos", number(status["positions"][AXES.index(axis)], 4)
    speed = status["spindle_rpm"]
    yield "S1speed", UNAVAILABLE if speed is None else number(speed, 2)
    yield "estop", "TRIGGERED" if status["estop"] else "ARMED"
    yield "system", _condition(status)
    yield "execution", _execution(status)
    yield "mode", _MODES.get(status["mode"], UNAVAILABLE)
    yield "program", PurePath(status["program"]).name
    yield "line", str(status["line"])
    yield "feed", number(status["velocity_mm_s"], 3)


def _execution(status: Mapping[str, Any]) -> str:
    if not status["on"]:
        return "STOPPED"
    if status["paused"] or status["interpreter"] == "PAUSED":
        return "INTERRUPTED"
    return "READY" if status["interpreter"] == "IDLE" else "ACTIVE"


def _condition(status: Mapping[str, Any]) -> Condition:
    if status["estop"]:
        return Condition("FAULT", "ESTOP", "emergency stop")
    for what, words in (("joint_faults", "following error or drive fault"), ("joints_at_limit", "at a limit switch")):
        if status[what]:
            joints = " ".join(map(str, status[what]))
            return Condition("FAULT", what.upper(), f"joint {joints}: {words}")
    return Condition()


def _of_pins(machine: Machine, report: MachineReport, limits: Limits) -> Iterator[tuple[str, Value]]:
    for name, pin in machine.temperatures.items():
        age = report.pins.get(_age(pin)) if _age(pin) else 0.0
        good = age is not None and age <= limits.temperature_s and (report.signals_alive or not _age(pin))
        yield f"temp_{name}", _number(report.pins.get(pin) if good else None, 3)
    for axis, pin in machine.corrections.items():
        yield f"{axis}corr", _number(report.pins.get(pin), 6 if axis in LINEAR else 4)
    yield "part_count", _number(report.pins.get(machine.part_count), 0)


def _age(pin: str) -> str:
    """The pin that says how old this one's value is; empty: none does."""
    return pin.replace(".signal-", ".age-") if pin.startswith(f"{SIGNALS}signal-") else ""


def _number(value: float | None, decimals: int) -> str:
    return UNAVAILABLE if value is None or math.isnan(value) else number(value, decimals)


AT_ONCE: Final = 500
EVERY_S: Final = 0.5
LEVELS: Final = ("Normal", "Warning", "Fault", "Unavailable")

Say = Callable[[str], None]


@dataclass(frozen=True)
class Item:
    """A data item as the device model has it; without one, by its observations."""

    id: str
    name: str = ""
    type: str = ""
    units: str = ""


@dataclass(frozen=True)
class ItemObservation:
    """An observation with its item. `value`: as the agent says it, of a condition its level."""

    item: Item
    stamp: str
    sequence: int
    value: str


def read(
    url: str, until: Callable[[], bool], say: Say, stop: threading.Event | None = None
) -> Iterator[ItemObservation]:
    """Yields what is current, then what comes, until `until`, called after each answer, is true. Raises MTC-AGENT."""
    if not is_address(url):
        raise _agent_refused(url, "not the address of an agent, such as http://10.0.0.7:5000/lathe")
    stop, url = stop or threading.Event(), url.rstrip("/")
    items = {mapping["id"]: _item(mapping) for mapping in _asked(f"{url}/probe").items}
    answer = _asked(f"{url}/current")
    while True:
        yield from _seen(answer, items)
        following, instance = _next(url, answer), answer.header.get("instanceId", "")
        if until() or stop.wait(0.0 if len(answer.all) >= AT_ONCE else EVERY_S):
            return
        answer = _asked(f"{url}/sample?from={following}&count={AT_ONCE}", may_refuse=True)
        if answer.errors or answer.header.get("instanceId", "") != instance:
            answer = _anew(url, following, instance, say)


def for_seconds(seconds: float) -> Callable[[], bool]:
    """Returns a function that is true once so long has passed since this call."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() >= end


def _anew(url: str, following: int, instance: str, say: Say) -> Current:
    """Begins again at what is current, and says what was missed."""
    answer = _asked(f"{url}/current")
    first = answer.header.get("firstSequence", "?")
    if answer.header.get("instanceId", "") != instance:
        say(f"{url}: the agent was started anew: its numbers begin again")
    else:
        say(f"{url}: from {following} on the agent no longer has all: it begins at {first}; what is current is taken")
    return answer


def _asked(url: str, *, may_refuse: bool = False) -> Current:
    try:
        try:
            document = fetched(url)
        except HTTPError as refusal:  # newer agents refuse with a status; what they say is in the body all the same
            with refusal:
                document = refusal.read(LARGEST)
            if not read_current(document).errors:
                raise
        answer = read_current(document)
    except OSError as error:
        raise _agent_refused(url, str(error)) from error
    if not answer.header:
        raise _agent_refused(url, "the answer has no Header: it is not from an agent")
    if answer.errors and not may_refuse:
        raise _agent_refused(url, "; ".join(f"{code} {text}".strip() for code, text in answer.errors))
    return answer


def _next(url: str, answer: Current) -> int:
    following = answer.header.get("nextSequence", "")
    if not following.isdecimal():
        raise _agent_refused(url, f"nextSequence is {following[:40]!r}, no number")
    return int(following)


def _seen(answer: Current, items: Mapping[str, Item]) -> Iterator[ItemObservation]:
    for observation in sorted(answer.all, key=lambda observation: observation.sequence):
        value = observation.kind.upper() if observation.kind in LEVELS else observation.text
        yield ItemObservation(
            items.get(observation.item) or Item(observation.item, observation.name, observation.kind),
            observation.stamp,
            observation.sequence,
            value,
        )


def _item(attributes: Mapping[str, str]) -> Item:
    return Item(attributes["id"], attributes.get("name", ""), attributes.get("type", ""), attributes.get("units", ""))


def _agent_refused(url: str, why: str) -> TrueloopError:
    return Code.MTC_AGENT.refusal(
        f"{url}: {why}", hint="open the address in a browser: an agent shows its devices there", values={"url": url}
    )


def temperature_log(url: str, observations: Sequence[ItemObservation]) -> str:
    """Returns CSV: `time_s` since 1970, NAME_degC; a value holds until the next. Raises MTC-AGENT: never all known."""
    temperatures = [observation.item for observation in observations if observation.item.type.upper() == "TEMPERATURE"]
    named = {item.id: re.sub(r"\W", "_", item.name or item.id) for item in temperatures}
    rows: dict[float, list[float]] = {}
    latest: dict[str, float] = {}
    for time_s, observation in sorted(
        ((_time_s(url, observation), observation) for observation in observations if observation.item.id in named),
        key=lambda row: row[0],
    ):
        latest[observation.item.id] = number_of(observation.value)
        values = [latest.get(item, math.nan) for item in named]
        if all(map(math.isfinite, values)):
            rows[time_s] = values
        else:
            rows.pop(time_s, None)
    if not rows:
        raise _refused(url, f"{len(named)} temperatures, and at no moment all of them were known")
    head = ",".join(["time_s", *(f"{name}_degC" for name in named.values())])
    return "\n".join([head, *(f"{t:.6f},{','.join(f'{v:g}' for v in row)}" for t, row in rows.items()), ""])


def _time_s(url: str, observation: ItemObservation) -> float:
    try:
        return unix_s(observation.stamp)
    except ValueError as error:
        raise _refused(url, f"{observation.item.id!r} at {observation.stamp[:40]!r}: {error}") from error


def _refused(url: str, why: str) -> TrueloopError:
    return Code.MTC_AGENT.refusal(
        f"{url}: {why}", hint="read for longer, or see which items are UNAVAILABLE", values={"url": url}
    )
