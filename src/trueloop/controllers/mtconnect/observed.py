"""From what LinuxCNC said to what MTConnect calls it. What nobody said is UNAVAILABLE."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Final

from trueloop.controllers.mtconnect.items import AXES, LINEAR, Machine, items
from trueloop.controllers.mtconnect.shdr import NONE, UNAVAILABLE, Condition, Value, number

SIGNALS: Final = "rtec-signals."
HEARTBEAT: Final = f"{SIGNALS}heartbeat"
_MODES: Final = {"MANUAL": "MANUAL", "AUTO": "AUTOMATIC", "MDI": "MANUAL_DATA_INPUT"}


@dataclass(frozen=True)
class Limits:
    """Older than this a source counts as silent, s."""

    status_s: float = 2.0
    temperature_s: float = 60.0


@dataclass(frozen=True)
class Said:
    """LinuxCNC's status, None: it does not run; values of pins; whether the corrector's signals are alive; the part."""

    status: Mapping[str, Any] | None
    pins: Mapping[str, float | None]
    signals_alive: bool = True
    part: str = ""


def nothing(machine: Machine) -> dict[str, Value]:
    """All items while nobody says anything."""
    return {item.key: NONE if item.condition else UNAVAILABLE for item in items(machine)}


def pins_of(machine: Machine) -> list[str]:
    """All pins that are asked for. A signal of the corrector comes with its age and the heartbeat."""
    named = [*machine.temperatures.values(), *machine.corrections.values(), machine.part_count]
    ages = [age for pin in named if (age := _age(pin))]
    return list(dict.fromkeys([*filter(None, named), *ages, *([HEARTBEAT] if ages else [])]))


def observed(machine: Machine, said: Said, limits: Limits) -> dict[str, Value]:
    """Every item's value, in the order of the items."""
    found = nothing(machine)
    if said.status is not None:
        found.update(_of_status(machine, said.status))
        found.update(_of_pins(machine, said, limits))
        found["part_id"] = said.part or UNAVAILABLE
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


def _of_pins(machine: Machine, said: Said, limits: Limits) -> Iterator[tuple[str, Value]]:
    for name, pin in machine.temperatures.items():
        age = said.pins.get(_age(pin)) if _age(pin) else 0.0
        good = age is not None and age <= limits.temperature_s and (said.signals_alive or not _age(pin))
        yield f"temp_{name}", _number(said.pins.get(pin) if good else None, 3)
    for axis, pin in machine.corrections.items():
        yield f"{axis}corr", _number(said.pins.get(pin), 6 if axis in LINEAR else 4)
    yield "part_count", _number(said.pins.get(machine.part_count), 0)


def _age(pin: str) -> str:
    """The pin that says how old this one's value is; empty: none does."""
    return pin.replace(".signal-", ".age-") if pin.startswith(f"{SIGNALS}signal-") else ""


def _number(value: float | None, decimals: int) -> str:
    return UNAVAILABLE if value is None or math.isnan(value) else number(value, decimals)
