"""Configuration, image and model combined: the reader of each signal, and its consequences."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Final

from trueloop.controllers.linuxcnc.realtime.signals import sources
from trueloop.controllers.linuxcnc.realtime.signals.past import Clock, ReplayedLogs, replayed
from trueloop.controllers.linuxcnc.realtime.signals.readings import Feed
from trueloop.controllers.linuxcnc.realtime.signals.sources import CONSTANT, SPINDLE
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.samples_csv import SignalLog
from trueloop.formats.realtime.signals_toml import SignalsFile, SignalTable
from trueloop.formats.toml_tables import Located
from trueloop.machine.model.history import Lag
from trueloop.realtime.bank import LagRules, LagState
from trueloop.realtime.image import Signal
from trueloop.units import SIGNALS

UNITS: Final = {"degC": "°C", "degF": "°C", "rpm": "rev/min"}
"""The unit in the model of what a source says in that unit."""

KEPT: Final = 8.0
"""Time constants that a log reaches back: what was before has died away to a three-thousandth."""


@dataclass(frozen=True)
class Setup:
    """All that is read and computed. `wanted` are the image's signals in its order, `sensors` what is read for them."""

    wanted: tuple[Signal, ...]
    sensors: tuple[str, ...]
    lags: tuple[Lag, ...]
    rules: LagRules
    clock: Clock
    feeds: Mapping[str, Feed]
    source_of: Mapping[str, str]
    scale: Mapping[str, Callable[[float], float]]
    states: Mapping[str, LagState | None]
    log: SignalLog | None
    spindle: tuple[str, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    cycle_s: float = 0.1
    every_s: float = 1.0
    stale_s: float = 10.0


def setup_of(
    file: Located[SignalsFile], wanted: tuple[Signal, ...], lags: tuple[Lag, ...], units: Mapping[str, str]
) -> Setup:
    """Makes the setup: `lags` of the model that the image was made from, `units` of its signals where they are known.

    Raises RTC-SOURCE for a signal without a source, for one that nothing needs, for what a source cannot give.
    """
    names = {signal.name for signal in wanted}
    lags = tuple(lag for lag in lags if lag.name in names)
    sensors = _sensors(file, wanted, lags)
    kinds = {name: sources.kind_of(file, name) for name in sensors}
    for name, kind in kinds.items():
        sources.check_keys(file, name, kind)
    clock = Clock(time.time(), time.monotonic())
    played = replayed(file, [name for name in sensors if kinds[name] == "replay"], lags, clock)
    _check_trials(file, kinds, played.speed)
    known = {**{s.name: s.unit for s in wanted if s.unit}, **units}
    said = {name: _unit(file, name, kinds[name], played, known.get(name)) for name in sensors}
    return Setup(
        wanted=wanted,
        sensors=sensors,
        lags=lags,
        rules=_rules(file, played.speed),
        clock=replace(clock, speed=played.speed),
        feeds=_feeds(file, kinds, played),
        source_of={name: file.model.signals[name].source for name in sensors},
        scale={name: _celsius for name in sensors if file.model.signals[name].unit == "degF"},
        states=played.states,
        log=_log(file, lags, {name: said[name] for name in sensors}),
        spindle=tuple(name for name, kind in kinds.items() if kind == SPINDLE),
        constants={name: file.model.signals[name].value or 0.0 for name, kind in kinds.items() if kind == CONSTANT},
        cycle_s=1 / file.model.cycle_hz,
        every_s=file.model.every_s,
        stale_s=file.model.stale_s,
    )


def _celsius(fahrenheit: float) -> float:
    return (fahrenheit - 32) / 1.8


def _sensors(file: Located[SignalsFile], wanted: tuple[Signal, ...], lags: tuple[Lag, ...]) -> tuple[str, ...]:
    """The signals to read: the image's, and those of its lags. Each has to have a source, and no other."""
    computed = {lag.name: lag for lag in lags}
    needed = tuple(dict.fromkeys([*(s.name for s in wanted if s.name not in computed), *(lag.of for lag in lags)]))
    for name in file.model.signals:
        if name not in needed:
            with file.at("signals", name):
                raise _not_needed(name, needed, computed.get(name))
    missing = [name for name in needed if name not in file.model.signals]
    if missing:
        with file.at("signals"):
            raise Code.RTC_SOURCE.refusal(
                f"{len(missing)} of {len(needed)} signals have no source: {', '.join(map(repr, missing))}",
                hint=f"write a table [signals.{missing[0]}] with its source; a lag needs `model`, the file that the "
                "image was made from",
            )
    return needed


def _not_needed(name: str, needed: tuple[str, ...], lag: Lag | None) -> TrueloopError:
    near = get_close_matches(name, needed, n=1)
    hint = f"did you mean {near[0]!r}?" if near else "leave it out"
    why = "the image does not need it"
    if lag is not None:
        why, hint = f"it is {lag.of!r} after a lag of {lag.constant_s:g} s and computed from that", "leave it out"
    return Code.RTC_SOURCE.refusal(
        f"signal {name!r}: {why}; sources are for {len(needed)}: {', '.join(needed)}", hint=hint
    )


def _check_trials(file: Located[SignalsFile], kinds: Mapping[str, str], speed: float) -> None:
    for name, kind in kinds.items():
        with file.at("signals", name, "source"):
            if kind == CONSTANT and not file.model.constants:
                raise Code.RTC_SOURCE.refusal(
                    f"signal {name!r} is a constant, {file.model.signals[name].value}: nobody measures it",
                    hint="give it a sensor; for a trial write `constants = true` at the top of the file",
                )
            if speed != 1 and kind not in ("replay", SPINDLE, CONSTANT):
                raise Code.RTC_SOURCE.refusal(
                    f"signal {name!r} is measured, while others are played again at {speed:g} times their pace",
                    hint="replay all of them, or at speed 1",
                )


def _unit(file: Located[SignalsFile], name: str, kind: str, played: ReplayedLogs, unit: str | None) -> str:
    """Raises RTC-SOURCE where source and model disagree."""
    by_itself = {SPINDLE: "rev/min", "one_wire": "°C", "replay": played.units.get(name, "")}
    given = file.model.signals[name].unit
    said = UNITS[given] if given else by_itself[kind]
    if unit and said != unit:
        with file.at("signals", name, "unit"):
            raise Code.RTC_SOURCE.refusal(
                f"signal {name!r} is in {said!r} here, in {unit!r} in the model",
                hint='units are "degC", "degF" (made °C) and "rpm"; is it the sensor that the model was made with?',
            )
    return said


def _rules(file: Located[SignalsFile], speed: float) -> LagRules:
    stated = file.model.equilibrium
    moment_s = math.nan if stated is None else stated.timestamp()
    if moment_s > time.time():
        with file.at("equilibrium"):
            raise Code.RTC_SOURCE.refusal(
                f"equilibrium = {stated} lies {moment_s - time.time():.0f} s in the future",
                hint="say when the machine was in equilibrium, having stood still as long as its slowest lag takes",
            )
    return LagRules(file.model.settle, file.model.gap, 3 * file.model.every_s * speed, moment_s)


def _feeds(file: Located[SignalsFile], kinds: Mapping[str, str], played: ReplayedLogs) -> dict[str, Feed]:
    """Makes the reader of each source that is used."""
    model, folder = file.model, file.path.parent
    by_source: dict[tuple[str, str], dict[str, SignalTable]] = {}
    for name, kind in kinds.items():
        signal = model.signals[name]
        by_source.setdefault((kind, signal.source), {})[name] = signal
    feeds: dict[str, Feed] = dict(played.feeds)
    for (kind, source), signals in by_source.items():
        if kind == "serial":
            feeds[source] = sources.serial_feed(file, model.serial[source], signals)
        elif kind == "one_wire":
            feeds[source] = sources.one_wire_feed(model.one_wire[source], signals, folder)
        elif kind == "mqtt":
            feeds[source] = sources.mqtt_feed(file, source, model.mqtt[source], signals, folder)
        elif kind == "mtconnect":
            feeds[source] = sources.mtconnect_feed(file, source, model.mtconnect[source], signals)
    return feeds


def _log(file: Located[SignalsFile], lags: tuple[Lag, ...], units: Mapping[str, str]) -> SignalLog | None:
    """The log, long enough for the slowest lag."""
    model = file.model
    if not model.log:
        return None
    ends = {unit: end for end, unit in SIGNALS.items()}
    keep_s = max((KEPT * lag.constant_s for lag in lags), default=0.0)
    most = max(model.log_rows, math.ceil(2 * keep_s / model.every_s))
    columns = tuple(f"{name}{ends[unit]}" for name, unit in units.items())
    return SignalLog(Path(file.path.parent, model.log), columns, keep_s, most)
