"""Configuration, image and model combined: the reader of each signal, and its consequences."""

import math
import os
import re
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from trueloop.controllers.linuxcnc.realtime.signals.mqtt import Mqtt, Topic, paho
from trueloop.controllers.linuxcnc.realtime.signals.mtconnect import MtConnect, is_address
from trueloop.controllers.linuxcnc.realtime.signals.readings import Clock, Feed, Intake, ReplayedLogs, replayed, wait
from trueloop.controllers.linuxcnc.realtime.signals.serial_lines import LinePart, SerialLines, pyserial
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.samples_csv import SignalLog
from trueloop.formats.realtime.signals_toml import (
    MqttTable,
    MtConnectTable,
    OneWireTable,
    SerialTable,
    SignalsFile,
    SignalTable,
)
from trueloop.formats.toml_tables import Located
from trueloop.machine.model.history import Lag
from trueloop.realtime.image import LagRules, LagState, Signal
from trueloop.units import SIGNALS
from trueloop.wording import did_you_mean

FOLDER: Final = Path("/sys/bus/w1/devices")
POWER_ON_MILLI_DEGC: Final = 85000
"""The value of the sensor before its first conversion [DS18B20 data sheet]: refused, since a reset gives it too."""

SCRATCHPAD: Final = re.compile(r"(?P<bytes>(?:[0-9a-f]{2} ){9}): crc=[0-9a-f]{2} (?P<verdict>YES|NO)\b")
TEMPERATURE: Final = re.compile(r"\bt=(-?\d+)\b")


@dataclass(frozen=True)
class OneWire:
    """A bus. `devices` are the names of folders by signal, such as 28-00000a1b2c3d."""

    devices: Mapping[str, str]
    every_s: float = 1.0
    folder: Path = FOLDER

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads one after the other; a conversion takes up to 0.75 s."""
        while not stop.is_set():
            began_s = time.monotonic()
            for name, device in self.devices.items():
                read_s = time.monotonic()
                try:
                    intake.put(name, temperature_degC(self.folder / device), read_s)
                except (OSError, ValueError) as error:
                    intake.refuse(name, str(error))
            wait(stop, began_s, self.every_s)


def temperature_degC(device: Path) -> float:
    """Reads a sensor, °C. Raises `OSError` where it is not there, `ValueError` where it gives no reading."""
    slave = device / "w1_slave"
    text = (slave if slave.exists() else device / "temperature").read_text(encoding="ascii", errors="replace")
    milli = _from_scratchpad(text) if slave.exists() else int(text)
    if milli == POWER_ON_MILLI_DEGC:
        raise ValueError("85 °C is its value after power-on, before the first conversion")
    return milli / 1000


def _from_scratchpad(text: str) -> int:
    """Raises `ValueError`. Nine zeros have a right checksum: a line that is pulled down reads so."""
    found, value = SCRATCHPAD.search(text), TEMPERATURE.search(text)
    if found is None or value is None:
        raise ValueError(f"{text[:80]!r} is not the output of a 1-Wire thermometer")
    if found["verdict"] == "NO":
        raise ValueError("its checksum is wrong: crc NO")
    if set(found["bytes"].split()) == {"00"}:
        raise ValueError("all nine bytes are 0: the line is pulled down")
    return int(value[1])


SPINDLE: Final = "spindle"
CONSTANT: Final = "constant"
Signals = Mapping[str, SignalTable]


@dataclass(frozen=True)
class Keys:
    """Which keys a signal of one kind of source has to have, and which it may have besides."""

    kind: str
    needed: tuple[str, ...] = ()
    other: tuple[str, ...] = ()


KINDS: Final = {
    "serial": Keys("a serial port", ("unit",), ("pattern", "column")),
    "one_wire": Keys("a 1-Wire bus", ("device",)),
    "mqtt": Keys("an MQTT broker", ("unit", "topic"), ("path", "time_path", "qos")),
    "mtconnect": Keys("an MTConnect agent", ("unit", "item")),
    "replay": Keys("a log played again", (), ("recorded",)),
    SPINDLE: Keys("the spindle's pin"),
    CONSTANT: Keys("a constant", ("unit", "value")),
}


def kind_of(file: Located[SignalsFile], name: str) -> str:
    """Returns the kind of a signal's source. Raises RTC-SOURCE for a source that is not there, or there twice."""
    source = file.model.signals[name].source
    named = {kind: getattr(file.model, kind) for kind in KINDS if kind not in (SPINDLE, CONSTANT)}
    found = [kind for kind, tables in named.items() if source in tables]
    if source in (SPINDLE, CONSTANT):
        found.append(source)
    with file.at("signals", name, "source"):
        if len(found) == 1:
            return found[0]
        known = [*(table for tables in named.values() for table in tables), SPINDLE, CONSTANT]
        what = f"names {len(found)} sources" if found else "is no source"
        raise Code.RTC_SOURCE.refusal(
            f"signal {name!r}: {source!r} {what}; there are {len(known)}: {', '.join(known)}",
            hint=f"a source is a table such as [serial.{source}] or [mqtt.{source}], its name there once",
        )


def check_keys(file: Located[SignalsFile], name: str, kind: str) -> None:
    """Raises RTC-SOURCE for a key that a signal of this kind of source lacks, or that means nothing to it."""
    table, keys = file.model.signals[name], KINDS[kind]
    given = {key for key in table.model_fields_set if key != "source" and getattr(table, key) is not None}
    strange = sorted(given - {*keys.needed, *keys.other})
    missing = [key for key in keys.needed if key not in given]
    if kind == "serial" and not given & {"pattern", "column"}:
        missing.append("column")
    if not (strange or missing):
        return
    with file.at("signals", name, *strange[:1]):
        what = f"has no key {strange[0]!r}" if strange else f"needs the key {missing[0]!r}"
        allowed = ", ".join((*keys.needed, *keys.other)) or "source alone"
        raise Code.RTC_SOURCE.refusal(f"signal {name!r}: {keys.kind} {what}", hint=f"its keys are {allowed}: {HINT}")


HINT: Final = "docs/realtime-signals.md"


def serial_feed(file: Located[SignalsFile], table: SerialTable, signals: Signals) -> Feed:
    """Raises RTC-SOURCE for a pattern that is none, and where pyserial is not installed."""
    pyserial()
    parts = {name: _part(file, name, table, signal) for name, signal in signals.items()}
    return SerialLines(table.port, table.baud, parts, table.ask, table.every_s)


def _part(file: Located[SignalsFile], name: str, table: SerialTable, signal: SignalTable) -> LinePart:
    with file.at("signals", name, "pattern"):
        try:
            pattern = None if signal.pattern is None else re.compile(signal.pattern)
        except re.error as error:
            raise _wrong(name, f"the pattern {signal.pattern!r} is none: {error}") from error
        if pattern and not pattern.groups:
            raise _wrong(name, f"the pattern {signal.pattern!r} has no group: put the number in (…)")
    return LinePart(pattern, signal.column or 1, table.separator)


def _wrong(name: str, what: str) -> TrueloopError:
    return Code.RTC_SOURCE.refusal(f"signal {name!r}: {what}", hint=f"how it is written is in {HINT}")


def one_wire_feed(table: OneWireTable, signals: Signals, folder: Path) -> Feed:
    """Makes the feed of all sensors of the bus."""
    return OneWire({name: str(signal.device) for name, signal in signals.items()}, table.every_s, folder / table.folder)


def mqtt_feed(file: Located[SignalsFile], source: str, table: MqttTable, signals: Signals, folder: Path) -> Feed:
    """Raises RTC-SOURCE for a topic with wildcards, for an environment variable that is not set, without paho-mqtt."""
    paho()
    for name, signal in signals.items():
        if set(str(signal.topic)) & set("+#") or not signal.topic:
            with file.at("signals", name, "topic"):
                raise _wrong(name, f"the topic {signal.topic!r} names not one topic alone")
    topics = {
        name: Topic(str(signal.topic), signal.path or "", signal.time_path or "", signal.qos or 0)
        for name, signal in signals.items()
    }
    user, password = (_from_environment(file, source, key, getattr(table, key)) for key in ("user_env", "password_env"))
    port = table.port or (8883 if table.tls else 1883)
    authorities = str(folder / table.ca_file) if table.ca_file else ""
    return Mqtt(
        host=table.host,
        port=port,
        topics=topics,
        user=user,
        password=password,
        tls=table.tls,
        ca_file=authorities,
        skew_s=table.skew_s,
    )


def _from_environment(file: Located[SignalsFile], source: str, key: str, variable: str) -> str:
    if variable and variable not in os.environ:
        with file.at("mqtt", source, key):
            raise Code.RTC_SOURCE.refusal(
                f"the environment variable {variable!r} is not set",
                hint="set it where LinuxCNC is started: it is handed on to what that starts",
            )
    return os.environ.get(variable, "") if variable else ""


def mtconnect_feed(file: Located[SignalsFile], source: str, table: MtConnectTable, signals: Signals) -> Feed:
    """Raises RTC-SOURCE for an address that is none."""
    if not is_address(table.url):
        with file.at("mtconnect", source, "url"):
            raise Code.RTC_SOURCE.refusal(
                f"{table.url!r} does not address an agent", hint="such as http://10.0.0.7:5000/lathe"
            )
    items = {name: str(signal.item) for name, signal in signals.items()}
    return MtConnect(table.url, items, table.every_s, table.held, table.skew_s)


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
    kinds = {name: kind_of(file, name) for name in sensors}
    for name, kind in kinds.items():
        check_keys(file, name, kind)
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
    why, hint = "the image does not need it", did_you_mean(name, needed) or "leave it out"
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
            feeds[source] = serial_feed(file, model.serial[source], signals)
        elif kind == "one_wire":
            feeds[source] = one_wire_feed(model.one_wire[source], signals, folder)
        elif kind == "mqtt":
            feeds[source] = mqtt_feed(file, source, model.mqtt[source], signals, folder)
        elif kind == "mtconnect":
            feeds[source] = mtconnect_feed(file, source, model.mtconnect[source], signals)
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
