"""Attaching to a LinuxCNC that runs with the corrector: every servo period as it was, from HAL's `sampler`.

Pins that are read one by one from outside belong to different periods: what shall be judged to a nanometre is taken by
the servo thread itself. `sampled.py` has the pins and the lines of HAL.

The record of every servo period: the pins that HAL's `sampler` takes, and the lines that wire them to it.

A stream of LinuxCNC gives no number to a record that found no room, so every stream begins with the corrector's own
count of periods: records of several streams are joined by it, and lost ones are seen.
"""

import json
import re
import select
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.realtime.samples import Samples, signal_columns
from trueloop.units import UM_PER_MM

AXES: Final = "xyz"
MOST_PINS: Final = 20
"""Pins of one stream, the count of periods among them (HAL_STREAM_MAX_PINS is 21)."""
DEPTH: Final = 8000
"""Records that a stream holds: 8 s at 1 kHz, for a recorder that the disk holds up."""
PERIODS: Final = "rtec.periods"
"""How often `rtec.write` ran since it was loaded, u32."""


@dataclass(frozen=True)
class SampledPin:
    """A pin, and its type in sampler's letters: f, b, s or u."""

    name: str
    kind: str


def sampled_pins(joints: Mapping[int, int], signals: int) -> tuple[SampledPin, ...]:
    """Returns the pins to record but the count of periods. `joints`: their numbers by axis; `signals`: how many."""
    of_axes = [
        SampledPin(name.format(axis=axis, joint=joint), "f")
        for axis, joint in sorted(joints.items())
        for name in OF_AXIS
    ]
    states = (SampledPin(name, kind) for name, (kind, _) in STATES.items())
    return (*of_axes, *states, *(SampledPin(f"rtec.in-use-{k}", "f") for k in range(signals)))


OF_AXIS: Final = (
    "rtec.at-{axis}",
    "rtec.cmd-{axis}",
    "rtec.out-{axis}",
    "rtec.corr-{axis}",
    "rtec.model-{axis}",
    "rtec.table-{axis}",
    "rtec.tool-{axis}",
    "joint.{joint}.f-error",
)
STATES: Final = {
    "rtec.line": ("s", "line"),
    "rtec.program": ("s", "program"),
    "rtec.phase": ("s", "phase"),
    "rtec.waits-for": ("s", "waits_for"),
    "rtec.fault-code": ("s", "fault"),
    "rtec.signal-fault": ("s", "signal_fault"),
    "rtec.fault-signal": ("s", "fault_signal"),
    "rtec.on-path": ("b", "on_path"),
    "rtec.generation": ("u", "generation"),
    "rtec.oldest-age": ("f", "oldest_age_s"),
    "rtec.write.time": ("s", "write_ns"),
    "servo-thread.time": ("s", "thread_ns"),
}
"""Pins with their types, and the columns of samples that hold them."""


def streams(pins: Sequence[SampledPin]) -> list[tuple[SampledPin, ...]]:
    """Divides the pins into streams, each with the count of periods at its head."""
    room, head = MOST_PINS - 1, SampledPin(PERIODS, "u")
    return [(head, *pins[start : start + room]) for start in range(0, len(pins), room)]


def sampler_lines(pins: Sequence[SampledPin], linked: Mapping[str, str]) -> list[str]:
    """Lines of HAL, to stand after all others of the servo thread: `sampler` loaded, run after the corrector, wired.

    `linked`: signals that pins are on already, by pin: a pin joins one signal only.
    """
    by_stream = streams(pins)
    kinds = ",".join("".join(pin.kind for pin in stream) for stream in by_stream)
    depths = ",".join([str(DEPTH)] * len(by_stream))
    lines = [f"loadrt sampler depth={depths} cfg={kinds}"]
    lines += [f"addf sampler.{k} servo-thread" for k in range(len(by_stream))]
    for k, stream in enumerate(by_stream):
        for place, pin in enumerate(stream):
            signal = linked.get(pin.name) or f"watch-{pin.name.replace('.', '-')}"
            lines.append(f"net {signal} {pin.name} => sampler.{k}.pin.{place}")
    return lines


READER: Final = Path(__file__).with_name("read_streams.py")
PYTHON: Final = "/usr/bin/python3"
END_S: Final = 5.0
BYTES: Final = 1 << 20
WRAP: Final = 1 << 32
OF_AXES: Final = ("at", "cmd", "out", "corr", "model", "table", "tool")
LINES: Final = "`trueloop realtime hal --watch` prints the lines that wire a sampler to the corrector"


@dataclass(frozen=True)
class Layout:
    """Where in a row each pin stands; `period_s` of the servo thread; `axes` as "xz"; columns of the signals."""

    place: Mapping[str, int]
    width: int
    period_s: float
    mm_per_unit: float
    clocks_per_ns: float
    axes: str
    signals: tuple[str, ...]


class Watched:
    """A LinuxCNC that is attached to; `layout` says what is recorded."""

    def __init__(self, process: "subprocess.Popen[bytes]", layout: Layout) -> None:
        self._process, self.layout = process, layout
        self._rest = b""
        self._first: int | None = None

    def periods(self, wait_s: float) -> Samples | None:
        """Returns what came since the last call, after `wait_s` at most; maybe nothing. None: LinuxCNC has ended."""
        assert self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], wait_s)[0]:
            return self._samples(b"")
        came = self._process.stdout.read1(BYTES)  # type: ignore[attr-defined]
        return self._samples(came) if came else None

    def _samples(self, came: bytes) -> Samples:
        self._rest += came
        row = 8 * self.layout.width
        whole = len(self._rest) // row * row
        table = np.frombuffer(self._rest[:whole], np.float64).reshape(-1, self.layout.width)
        self._rest = self._rest[whole:]
        if self._first is None and len(table):
            self._first = int(table[0, self.layout.place[PERIODS]])
        return samples_of(table, self.layout, self._first or 0)


@contextmanager
def attached(named: Sequence[tuple[str, str]] | None = None) -> Iterator[Watched]:
    """Attaches to the LinuxCNC on this computer. `named`: name and unit of each signal, in the order of the image.

    Raises RTC-CONNECTION where none runs, none with a corrector, or none with a sampler that is wired to it.
    """
    try:
        process = subprocess.Popen(
            [PYTHON, str(READER)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
    except OSError as error:
        raise _no_linuxcnc(f"{PYTHON}: {error.strerror or error}") from error
    try:
        assert process.stdout is not None
        yield Watched(process, layout_of(process.stdout.readline(), named))
    finally:
        _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Closed stdin ends it; what it still has to say is not waited for."""
    assert process.stdin is not None and process.stdout is not None
    process.stdin.close()
    process.stdout.close()
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def layout_of(text: bytes, named: Sequence[tuple[str, str]] | None = None) -> Layout:
    """Determines the layout from the reader's first line. Raises RTC-CONNECTION."""
    if not text:
        raise _no_linuxcnc("its `hal` module for Python cannot be used")
    head: dict[str, Any] = json.loads(text)
    if "error" in head:
        raise _no_corrector(head)
    place: dict[str, int] = {}
    k = 0
    for stream in head["columns"]:
        for beside in stream:
            place |= {pin: k for pin in beside if pin not in place}
            k += 1
    axes = "".join(axis for n, axis in enumerate(AXES) if f"rtec.at-{n}" in place)
    count = head["signals"]
    _require_wired(place, axes, count, head["samplers"])
    if named is not None and len(named) != count:
        raise Code.RTC_CONNECTION.refusal(
            f"the image names {len(named)} signals, the one in force needs {count}",
            hint="name the image that the corrector has loaded: --image",
        )
    names = named if named is not None else [(f"signal_{n}", "") for n in range(count)]
    units = head["mm_per_unit"]
    return Layout(
        place=place,
        width=k,
        period_s=1e-9 * head["period_ns"],
        mm_per_unit=units,
        clocks_per_ns=head["clocks_per_ns"],
        axes=axes,
        signals=signal_columns(names),
    )


def _no_linuxcnc(why: str) -> TrueloopError:
    return Code.RTC_CONNECTION.refusal(
        f"0 LinuxCNC that can be reached on this computer: {why}",
        hint="install LinuxCNC 2.9, and start it before: it must be on the same computer, in the same container",
    )


def _no_corrector(head: Mapping[str, Any]) -> TrueloopError:
    found = head["found"]
    if head["error"] == "no thread":
        message, hint = (
            "0 threads run `rtec.write`",
            "`trueloop realtime hal` prints the lines that add it to the thread",
        )
    elif found:
        message = f"{len(found)} components run in HAL, and no `rtec` among them: {', '.join(found[:6])}"
        hint = "`trueloop realtime hal` prints the lines that load the corrector"
    else:
        message = "0 components run in HAL: no LinuxCNC runs on this computer"
        hint = "start LinuxCNC first; who watches must be on the same computer and, in a container, in the same one"
    return Code.RTC_CONNECTION.refusal(message, hint=hint)


def _require_wired(place: Mapping[str, int], axes: str, signals: int, samplers: int) -> None:
    needed = [PERIODS, *STATES, *(f"rtec.in-use-{k}" for k in range(signals))]
    needed += [f"rtec.{what}-{AXES.index(axis)}" for axis in axes or "x" for what in OF_AXES]
    missing = [pin for pin in needed if pin not in place]
    if missing:
        raise Code.RTC_CONNECTION.refusal(
            f"{len(missing)} pins of the corrector that a record needs are on none of {samplers} samplers: "
            f"{', '.join(missing[:4])}{' …' if len(missing) > 4 else ''}",
            hint=f"{LINES}; a stream's first pin has to be on {PERIODS}",
        )


def samples_of(table: Array, layout: Layout, first: int) -> Samples:
    """Rows (n, width) of pins as samples; `first`: the count of periods at which the record began."""

    def pin(name: str) -> Array:
        return np.array(table[:, layout.place[name]])

    mm = layout.mm_per_unit
    columns = {"time_s": ((pin(PERIODS) - first) % WRAP) * layout.period_s}
    for axis in layout.axes:
        n = AXES.index(axis)
        columns[f"command_{axis}_mm"] = mm * pin(f"rtec.at-{n}")
        columns[f"drive_{axis}_mm"] = mm * (pin(f"rtec.at-{n}") + (pin(f"rtec.out-{n}") - pin(f"rtec.cmd-{n}")))
        columns[f"tool_{axis}_mm"] = mm * pin(f"rtec.tool-{n}")
        for what, of in (("model", "model"), ("table", "table"), ("correction", "corr")):
            columns[f"{what}_{axis}_um"] = UM_PER_MM * pin(f"rtec.{of}-{n}")
        error = _following_error(layout, n)
        columns[f"following_error_{axis}_um"] = UM_PER_MM * mm * pin(error) if error else np.full(len(table), np.nan)
    columns |= {column: pin(name) for name, (_, column) in STATES.items()}
    for column in ("write_ns", "thread_ns"):
        columns[column] = np.round(columns[column] / layout.clocks_per_ns)
    columns |= {name: pin(f"rtec.in-use-{k}") for k, name in enumerate(layout.signals)}
    return Samples(layout.period_s, layout.axes, layout.signals, columns)


def _following_error(layout: Layout, axis: int) -> str | None:
    """Of the joint whose command the corrector is asked at."""
    at = layout.place[f"rtec.at-{axis}"]
    joints = [name.split(".")[1] for name, place in layout.place.items() if place == at and _COMMANDED.match(name)]
    wanted = [f"joint.{joint}.f-error" for joint in joints]
    return next((name for name in wanted if name in layout.place), None)


_COMMANDED: Final = re.compile(r"joint\.\d+\.pos-cmd$")
