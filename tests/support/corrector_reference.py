"""The corrector a second time, written from docs/realtime-states.md: slow, a period a call, in that page's words."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trueloop.arrays import Array

OFF, WAITING, RAMPING, IN_FORCE, FROZEN, LEAVING, FAULTED = range(7)
LIMIT, NO_NUMBER, TRAVEL, STALE, RANGE, JUMP, WATCHDOG, PROGRAM, OFF_PATH, SETTINGS = range(1, 11)
FOLLOWING = (RAMPING, IN_FORCE, FROZEN, LEAVING)
MODEL, TABLE = 1, 2

Period = Mapping[str, Any]
Wanted = Callable[[Array, Array, Array, int | None], tuple[Array, Array, bool, bool]]
"""Of position, travel, signals and line: model, table, whether the line is listed, whether it is on its path."""


@dataclass(frozen=True)
class Ranges:
    """What an image allows; one row a signal: low, high, largest step."""

    signals: Array
    limit_mm: float
    travel_mm: Array
    has_table: bool


@dataclass
class Memory:
    """What goes from one period to the next."""

    phase: int = OFF
    fault: int = 0
    fault_signal: int = -1
    correction: Array = field(default_factory=lambda: np.zeros(3))
    target: Array = field(default_factory=lambda: np.zeros(3))
    slew: float = 0.0
    reached: bool = False
    pause: bool = False
    in_phase_s: float = 0.0
    off_path_s: float = 0.0
    touch: bool = False
    sent: Array | None = None
    latch: Array = field(default_factory=lambda: np.zeros(3))
    heartbeat: int | None = None
    heard: bool = False
    silent_s: float = 0.0
    readings: dict[int, tuple[float, float]] = field(default_factory=dict)
    commands: list[Array] = field(default_factory=list)
    travel: Array = field(default_factory=lambda: np.zeros(3))
    seen_at: Array = field(default_factory=lambda: np.zeros(3))
    acceleration: Array = field(default_factory=lambda: np.zeros(3))


def step(memory: Memory, now: Period, settings: Mapping[str, float], ranges: Ranges, wanted: Wanted) -> dict[str, Any]:
    """One period; what the pins show."""
    watch_commands(memory, now)
    if now["touch"] and not memory.touch and memory.sent is not None:
        memory.latch = memory.sent
    memory.touch = now["touch"]
    if 0 < settings["slew_mm_per_s"] < math.inf:
        memory.slew = settings["slew_mm_per_s"]
    bad = read_signals(memory, now, settings, ranges)
    model, table, listed, on_path = ask(memory, now, settings, ranges, wanted)
    parts = int(settings["parts"])
    asked = model * bool(parts & MODEL) + table * bool(parts & TABLE)

    change_phase(memory, now, settings, ranges, bad)
    strays = listed and not on_path and memory.phase in FOLLOWING
    memory.off_path_s = memory.off_path_s + now["period_s"] if strays else 0.0
    add(memory, now, settings, ranges, asked)
    memory.sent = now["position"] + memory.correction - model if np.all(np.isfinite(now["position"])) else None
    first = bad or (0, -1)
    return {
        "correction": memory.correction,
        "model": model * bool(parts & MODEL),
        "table": table * bool(parts & TABLE),
        "latch": memory.latch,
        "oldest_age_s": max((age for _, age in memory.readings.values()), default=0.0),
        "phase": memory.phase,
        "fault": memory.fault,
        "fault_signal": memory.fault_signal if memory.fault else first[1],
        "signal_fault": first[0],
        "waits_for": (hindrance(now, settings) or 4) if memory.phase == WAITING else 0,
        "enabled": memory.reached and memory.phase in (RAMPING, IN_FORCE, FROZEN),
        "active": bool(np.any(memory.correction != 0)),
        "on_path": on_path,
        "pause": memory.pause and bool(settings["pause_program"]),
    }


def watch_commands(memory: Memory, now: Period) -> None:
    """Direction of travel, and how hard the axes accelerate: from commands while drives are on and homed."""
    if not now["homed"]:
        memory.travel = np.zeros(3)
    if not (now["homed"] and now["machine_on"] and np.all(np.isfinite(now["position"]))):
        memory.commands = []
        return
    memory.commands = [*memory.commands, np.array(now["position"])][-3:]
    if len(memory.commands) == 1:
        memory.seen_at = memory.commands[0]
    speeds = np.diff(memory.commands, axis=0) / now["period_s"]
    moved = memory.commands[-1] - memory.seen_at
    moves = np.abs(moved) > 1e-9
    memory.travel = np.where(moves, np.sign(moved), memory.travel)
    memory.seen_at = np.where(moves, memory.commands[-1], memory.seen_at)
    if len(speeds) == 2:
        memory.acceleration = np.maximum(memory.acceleration, np.abs(speeds[1] - speeds[0]) / now["period_s"])


def speed(memory: Memory, now: Period) -> Array:
    """That of the last period, mm/s."""
    if len(memory.commands) < 2:
        return np.zeros(3)
    period_s: float = now["period_s"]
    return (memory.commands[-1] - memory.commands[-2]) / period_s


def read_signals(memory: Memory, now: Period, settings: Mapping[str, float], ranges: Ranges) -> tuple[int, int] | None:
    """Takes what is in order; fault and number of the first that is not."""
    beats = memory.heartbeat is not None and now["heartbeat"] != memory.heartbeat
    memory.heard |= beats
    memory.silent_s = 0.0 if beats else memory.silent_s + now["period_s"]
    memory.heartbeat = now["heartbeat"]
    silent = not memory.heard or memory.silent_s > settings["watchdog_s"]
    found = []
    for k, (low, high, most_step) in enumerate(ranges.signals):
        value, age = now["signal"][k], now["age_s"][k] + memory.silent_s
        last = memory.readings.get(k)
        if not low <= value <= high:
            fault = RANGE
        elif not 0 <= age <= settings["stale_s"]:
            fault = STALE
        elif now["enable"] and last is not None and abs(value - last[0]) > most_step:
            fault = JUMP
        else:
            fault = 0
        if silent:
            found.append((WATCHDOG, -1))
        elif fault:
            found.append((fault, k))
        if not silent and not fault:
            memory.readings[k] = (value, age)
        elif last is not None:
            memory.readings[k] = (last[0], last[1] + now["period_s"])
    return found[0] if found else None


def probes(now: Period) -> bool:
    return bool(now["probing"]) or now["motion_type"] == 5


def hindrance(now: Period, settings: Mapping[str, float]) -> int:
    """1 homing, 2 drives, 3 probing; 0 none."""
    if not now["homed"]:
        return 1
    if not now["machine_on"]:
        return 2
    return 3 if probes(now) and not settings["probe_corrected"] else 0


def ask(
    memory: Memory, now: Period, settings: Mapping[str, float], ranges: Ranges, wanted: Wanted
) -> tuple[Array, Array, bool, bool]:
    """What should be added here; nothing while a signal was never read, or a number is none."""
    finite = np.all(np.isfinite(now["position"])) and np.all(np.isfinite(now["tool_offset"]))
    if not finite or len(memory.readings) < len(ranges.signals):
        return np.zeros(3), np.zeros(3), False, False
    signals = np.array([memory.readings[k][0] for k in range(len(ranges.signals))])
    cuts = now["program"] == 1 and int(settings["parts"]) & TABLE and not probes(now)
    return wanted(now["position"], memory.travel, signals, now["line"] if cuts else None)


def at_once(now: Period, settings: Mapping[str, float], ranges: Ranges) -> int:
    """A fault that needs no look at what is wanted."""
    named = [value for name, value in settings.items() if name.endswith(("_s", "_mm"))]
    sensible = all(0 <= value < math.inf for value in named) and 0 < settings["slew_mm_per_s"] < math.inf
    if not sensible or settings["parts"] > MODEL + TABLE:
        return SETTINGS
    if not np.all(np.isfinite([*now["position"], *now["tool_offset"]])):
        return NO_NUMBER
    tabled = ranges.has_table and int(settings["parts"]) & TABLE
    return PROGRAM if tabled and now["program"] == 2 else 0


def change_phase(
    memory: Memory, now: Period, settings: Mapping[str, float], ranges: Ranges, bad: tuple[int, int] | None
) -> None:
    """As the table of phases says."""
    before, freeze, leave = memory.phase, settings["freeze_s"], settings["leave_s"]
    if not now["enable"]:
        memory.fault, memory.pause = 0, False
        go(memory, OFF)
    elif before == FAULTED:
        pass
    elif fault := at_once(now, settings, ranges):
        fail(memory, fault, -1)
    elif before == LEAVING:
        memory.in_phase_s += now["period_s"]
        if hindrance(now, settings) or memory.in_phase_s >= leave:
            go(memory, FAULTED)
    elif hindrance(now, settings):
        go(memory, WAITING)
        memory.in_phase_s = 0.0
    elif bad is None:
        go(memory, IN_FORCE if before == IN_FORCE else RAMPING)
    elif before in FOLLOWING:
        go(memory, FROZEN)
        memory.in_phase_s += now["period_s"] if before == FROZEN else 0.0
        if memory.in_phase_s > freeze:
            memory.fault, memory.fault_signal = bad
            go(memory, LEAVING)
    else:
        go(memory, WAITING)
        memory.in_phase_s += now["period_s"] if before == WAITING else 0.0
        if memory.in_phase_s > freeze + leave:
            fail(memory, *bad)


def go(memory: Memory, phase: int) -> None:
    memory.in_phase_s = memory.in_phase_s if memory.phase == phase else 0.0
    memory.phase = phase
    if phase in (OFF, WAITING):
        memory.reached = False


def fail(memory: Memory, fault: int, signal: int) -> None:
    if not memory.fault:
        memory.fault, memory.fault_signal = fault, signal
    go(memory, FAULTED)


def add(memory: Memory, now: Period, settings: Mapping[str, float], ranges: Ranges, asked: Array) -> None:
    """Moves the correction, unless what is wanted has to be refused."""
    most = memory.slew * now["period_s"]
    share = 0.0
    if memory.phase in FOLLOWING:
        fades = memory.phase == LEAVING and settings["leave_s"] > 0
        share = max(0.0, 1 - memory.in_phase_s / settings["leave_s"]) if fades else float(memory.phase != LEAVING)
    target = asked * share if share else np.zeros(3)
    memory.target = stepped(target, memory.target, settings["resolution_mm"])
    if memory.phase in FOLLOWING:
        limit = min(settings["limit_mm"], ranges.limit_mm)
        tried = towards(memory.correction, memory.target, most)
        if not np.all(np.isfinite(asked)):
            fail(memory, NO_NUMBER, -1)
        elif np.any(np.abs(asked) > limit) or np.any(np.abs(memory.target) > limit):
            fail(memory, LIMIT, -1)
        elif memory.off_path_s > settings["off_path_s"]:
            fail(memory, OFF_PATH, -1)
        elif not all(inside(memory, now, ranges, tried, axis) for axis in range(3)):
            fail(memory, TRAVEL, -1)
        if memory.phase == FAULTED:
            memory.target = np.zeros(3)
    memory.correction = towards(memory.correction, memory.target, most)
    there = bool(np.all(memory.correction == memory.target))
    if memory.phase in FOLLOWING:
        memory.reached |= there
    if memory.phase in (RAMPING, IN_FORCE):
        memory.phase = IN_FORCE if there else RAMPING
    felt = memory.reached or bool(np.any(memory.correction != 0))
    memory.pause |= memory.phase in (LEAVING, FAULTED) and (now["program"] != 0 or felt)


def towards(start: Array, end: Array, most: float) -> Array:
    way = end - start
    return np.where(np.abs(way) <= most * (1 + 1e-9), end, start + np.clip(way, -most, most))


def stepped(wanted: Array, held: Array, resolution: float) -> Array:
    """Rounded to whole steps; a step is left where what is wanted is more than 0.6 of it away."""
    if not resolution > 0 or math.isinf(resolution):
        return wanted
    whole = np.where(wanted < 0, -1, 1) * np.floor(np.abs(wanted / resolution) + 0.5) * resolution
    was_whole = np.where(held < 0, -1, 1) * np.floor(np.abs(held / resolution) + 0.5) * resolution == held
    return np.where(was_whole & (np.abs(wanted - held) <= 0.6 * resolution), held, whole)


def inside(memory: Memory, now: Period, ranges: Ranges, correction: Array, axis: int) -> bool:
    """Whether the drive is inside and stays so if the ramp has to begin now, whatever the command does.

    The quickest command to the end is followed in time; room and correction are compared where they can come nearest.
    An end is met 0.1 µm beyond it.
    """
    q, c = now["position"][axis], correction[axis]
    low, high = ranges.travel_mm[axis] + np.array([-1e-4, 1e-4])
    if not low <= q <= high:
        return False
    if c == 0:
        return True
    room, way = (high - q, 1) if c > 0 else (q - low, -1)
    c = abs(c)
    if c > room:
        return False
    hard = min(max(memory.acceleration[axis], 1000.0), 20_000.0)
    v = max(0.0, way * speed(memory, now)[axis] + hard * now["period_s"] / 2)
    hard = max(hard, v * v / (2 * room))
    peak = math.sqrt(hard * room + v * v / 2)
    if peak <= memory.slew:
        return True
    turns, ends = (peak - v) / hard, (2 * peak - v) / hard
    nearest = ends - memory.slew / hard
    return bool(c - memory.slew * nearest <= hard * (ends - nearest) ** 2 / 2) if nearest >= turns else True
