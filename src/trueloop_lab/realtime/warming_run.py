"""A program run by LinuxCNC on a lathe that warms up: sensors follow a stream of one row a servo period.

HAL's `streamer` plays what the sensors say, with the machine's own clock beside it, so that every recorded period knows
how warm the lathe was in it. `rtec-signals` is not used: the lag is in the stream.

The part of the demo, and its program for LinuxCNC: two cuts from opposite sides, the lathe warmer at the second.

The dome and the cylinder behind it are cut from the free end towards the chuck, collar and cone from the chuck
outwards: where the cuts meet, the part shows what the drives lose when they turn round, and what the machine has grown
in between.
"""

import ctypes
import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.controllers.linuxcnc.realtime.watch import STATES
from trueloop.errors import Code
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.realtime.image import Image, Signal
from trueloop.realtime.judge import DrivenRun
from trueloop.realtime.samples import COUNTS, Samples, column_names, signal_columns
from trueloop_lab.linuxcnc.realtime.session import (
    QUIET,
    Driven,
    Setup,
    Step,
    drive,
    get,
    home,
    on,
    put,
    record,
    run,
    wait,
)
from trueloop_lab.linuxcnc.session import TOO_BUSY

NOSE_RADIUS_MM: Final = 0.8
WORK_ZERO_Z_MM: Final = -90.0
"""Z of the part's free end in the machine's coordinates: G54."""

TOOL_OFFSET_MM: Final = (12.0, 30.0)
"""The offset of the nose's centre, X a radius: the axes stand that much farther than the nose."""

SET_AT_MM: Final = (25.0, -30.0)
"""The point where the tool was set, part coordinates: the machine cold, coming towards the axis and the chuck."""

FEED_MM_PER_MIN, RAPID_BETWEEN_MM = 300.0, 8.0
CHUCK_SIDE: Final = 3
"""Features cut from the chuck outwards; the others towards it."""


@dataclass(frozen=True)
class DemoProgram:
    """The text, and on which lines each of the cuts is, first to last, counted from 1."""

    text: str
    cuts: tuple[tuple[int, int], ...]


def demo_profile() -> Profile:
    """Returns collar, step, cone, cylinder and dome; mm, radii, the free end at z = 0."""
    return checked_profile(
        [
            Line("collar", (36.0, -66.0), (36.0, -56.0)),
            Line("step", (36.0, -56.0), (30.0, -56.0)),
            Line("cone", (30.0, -56.0), (24.0, -40.0)),
            Line("cylinder", (24.0, -40.0), (24.0, -24.0)),
            Arc("dome", (24.0, -24.0), (0.0, 0.0), (0.0, -24.0), math.pi / 2),
        ]
    )


def demo_program(profile: Profile, dwell_s: float = 10.0) -> DemoProgram:
    """Returns the program of both cuts at one feed; between them the tool rounds the part and waits while it grows."""
    centre = nose_centre_path(profile, NOSE_RADIUS_MM).features
    inwards = [feature.reversed() for feature in reversed(centre[CHUCK_SIDE:])]
    outwards = list(centre[:CHUCK_SIDE])
    far_mm = outwards[0].start_mm[0] + RAPID_BETWEEN_MM
    lines = [
        "G18 G21 G8 G90 G94 G40 G64 P0.0001 Q0",
        f"G10 L2 P1 X0 Z{WORK_ZERO_Z_MM:.3f}",
        "G54",
        f"G43.1 X{TOOL_OFFSET_MM[0]:.3f} Z{TOOL_OFFSET_MM[1]:.3f}",
        "G97 S2400 M3",
        *_approach(inwards[0], far_mm, 0.0, 1.5),
    ]
    first = len(lines) + 1
    lines += [f"F{FEED_MM_PER_MIN:.0f}", *_moves(inwards)]
    cuts = [(first, len(lines))]
    lines += [f"G0 X{far_mm:.3f}", f"G4 P{dwell_s:g}", *_approach(outwards[0], far_mm, 1.5, -2.0)]
    first = len(lines) + 1
    lines += [f"F{FEED_MM_PER_MIN:.0f}", *_moves(outwards)]
    cuts.append((first, len(lines)))
    lines += [f"G0 X{far_mm:.3f}", "G49", "M5", "M2", ""]
    return DemoProgram("\n".join(lines), tuple(cuts))


def _approach(first: Feature, far_mm: float, off_x_mm: float, off_z_mm: float) -> list[str]:
    """Returns the blocks to beside the first feature, and on to its start in the direction in which it is cut."""
    x, z = first.start_mm
    return [
        f"G0 X{far_mm:.3f}",
        f"G0 Z{z + off_z_mm:.6f}",
        f"G0 X{x + off_x_mm:.6f}",
        f"G1 X{x:.6f} Z{z:.6f} F{FEED_MM_PER_MIN:.0f}",
    ]


def _moves(features: Sequence[Feature]) -> list[str]:
    """Returns feed moves along lines and arcs, X a radius, centres from the starts."""
    found = []
    for feature in features:
        end = f"X{feature.end_mm[0]:.6f} Z{feature.end_mm[1]:.6f}"
        if isinstance(feature, Line):
            found.append(f"G1 {end}")
            continue
        assert isinstance(feature, Arc)
        (x, z), (centre_x, centre_z) = feature.start_mm, feature.centre_mm
        found.append(f"{'G2' if feature.sweep_rad > 0 else 'G3'} {end} I{centre_x - x:.6f} K{centre_z - z:.6f}")
    return found


PERIOD_S: Final = 1e-3
RAMPING, IN_FORCE = 2, 3
DEPTH: Final = 4000
ATTEMPTS: Final = 2
MOVES: Final = re.compile(r"^(?!.*\bG10\b|.*\bG43).*[XZ][-+.\d]", re.IGNORECASE)
"""A block that moves an axis."""

PROGRAM: Final = "part.ngc"
STREAM: Final = "sensors.txt"
AXES: Final = "xz"
OF_AXES: Final = {"x": (0, 0), "z": (1, 2)}
"""Joint, and number of the component's pins."""

COUNTED: Final = {column: pin.removeprefix("rtec.") for pin, (_, column) in STATES.items() if column in COUNTS}
"""Pins of the component by column of a record."""


@by_content
@dataclass(frozen=True)
class Sensors:
    """Sensor readings, one row per servo period: `time_s` (n,) of the machine's clock, values (n,) by signal."""

    time_s: Array
    values: Mapping[str, Array]


@by_content
@dataclass(frozen=True)
class WarmingRun:
    """A whole run: `clock_s` (n,) of the machine, and all that was recorded, for a judge and for `samples.csv`."""

    clock_s: Array
    driven: DrivenRun
    samples: Samples

    @property
    def in_force(self) -> Flags:
        """Periods with the correction in force, or on its way."""
        return self.driven.in_force


def warming_run(
    image: Image, program: str, sensors: Sensors, *, corrected: bool, tell: Callable[[str], None] = lambda doing: None
) -> WarmingRun:
    """Runs the program from a cold start, the corrector in force all along or off.

    A run that the computer interrupted is made once more, and `tell` is called with the reason. Raises CTL-LINUXCNC
    where that one is interrupted too, and as `session.drive`.
    """
    signals = image.bank.signals if image.bank else ()
    files = {PROGRAM: program.encode(), STREAM: _stream(sensors, signals)}
    setup = Setup(image_to_bytes(image), files, _pins(len(signals)), hal=_hal(len(signals)), depth=len(sensors.time_s))
    steps = [*_steps(image, corrected=corrected), get("underruns", "streamer.0.underruns")]
    for _ in range(ATTEMPTS):
        driven = drive(setup, steps)
        reason = interruption(driven, program)
        if not reason:
            return _run(driven, image, corrected=corrected)
        tell(f"the run was interrupted: {reason}")
    raise Code.CTL_LINUXCNC.refusal(
        f"{ATTEMPTS} of {ATTEMPTS} runs were interrupted, the last one: {reason}",
        hint="the computer is too busy: run it again with less beside it",
    )


def interruption(driven: Driven, program: str) -> str:
    """Returns why a run is not the whole program in consecutive servo periods; "" where it is."""
    if TOO_BUSY in driven.log:
        return f"LinuxCNC ended the program because its motion did not answer for a second: {TOO_BUSY!r}"
    if driven.messages:
        return f"LinuxCNC stopped the program: {driven.messages[0]!r}"
    last = max(number for number, block in enumerate(program.splitlines(), 1) if MOVES.search(block))
    reached = int(driven["rtec.line"].max(initial=0))
    if reached < last:
        return f"{len(driven.samples)} periods end in line {reached} of the program, which moves up to line {last}"
    late, steps = int(driven.got["underruns"]), np.diff(driven["streamer.0.pin.0"])
    if late or np.abs(steps - PERIOD_S).max(initial=0.0) > PERIOD_S / 2:
        return f"the sensors' stream ran empty {late} times, the longest step of its clock is {steps.max():g} s"
    return ""


def _steps(image: Image, *, corrected: bool) -> list[Step]:
    enabled = [put("rtec.enable", 1), wait("rtec.phase", IN_FORCE)] if corrected else []
    started = [put("streamer.0.enable", 1), put("rtec.heartbeat", 1), put("rtec.program", int(bool(image.blocks)))]
    return [on(), home(), *started, *enabled, record(), run(PROGRAM), record(on=False)]


def _hal(signals: int) -> str:
    """The stream, slower than its component by nothing: a row a period, from when it is enabled."""
    lines = [
        QUIET,
        f"loadrt streamer depth={DEPTH} cfg={'f' * (signals + 1)}",
        "addf streamer.0 servo-thread",
        "setp streamer.0.enable 0",
        *(f"net sensor-{k} streamer.0.pin.{k + 1} => rtec.signal-{k}" for k in range(signals)),
        f"loadusr halstreamer {STREAM}",
        "",
    ]
    return "\n".join(lines)


def _stream(sensors: Sensors, signals: Sequence[Signal]) -> bytes:
    table = np.column_stack([sensors.time_s, *(sensors.values[signal.name] for signal in signals)])
    line = " ".join(["%.4f", *["%.6f"] * len(signals)]) + "\n"
    return (line * len(table) % tuple(table.ravel().tolist())).encode()


def _pins(signals: int) -> tuple[str, ...]:
    of_axes = [
        pin
        for joint, number in OF_AXES.values()
        for pin in (
            *(f"joint.{joint}.{name}" for name in ("pos-cmd", "motor-offset", "f-error")),
            *(f"rtec.{name}-{number}" for name in ("out", "corr", "model", "table", "tool")),
        )
    ]
    in_use = [f"rtec.in-use-{k}" for k in range(signals)]
    times = ("rtec.oldest-age", "rtec.write.time", "servo-thread.time", "streamer.0.pin.0")
    return (*of_axes, *in_use, *(f"rtec.{name}" for name in COUNTED.values()), *times)


def _run(driven: Driven, image: Image, *, corrected: bool) -> WarmingRun:
    signals, tool = (image.bank.signals, image.bank.tool_mm) if image.bank else ((), (0.0, 0.0, 0.0))
    samples = _samples(driven, signals)
    in_force = np.isin(samples.count("phase"), (RAMPING, IN_FORCE))
    if not corrected:
        in_force[:] = False
    run_of = DrivenRun(
        PERIOD_S,
        samples.mm("command"),
        samples.mm("drive"),
        {signal.name: driven[f"rtec.in-use-{k}"] for k, signal in enumerate(signals)},
        driven["rtec.line"].astype(np.intp),
        in_force,
        np.asarray(tool) - samples.mm("tool"),
    )
    return WarmingRun(driven["streamer.0.pin.0"], run_of, samples)


def _samples(driven: Driven, signals: Sequence[Signal]) -> Samples:
    """As `trueloop realtime watch` records them."""
    named = signal_columns([(signal.name, signal.unit) for signal in signals])
    columns = {"time_s": PERIOD_S * np.arange(len(driven.samples), dtype=np.float64)}
    for axis, (joint, number) in OF_AXES.items():
        columns[f"command_{axis}_mm"] = driven[f"joint.{joint}.pos-cmd"]
        columns[f"drive_{axis}_mm"] = driven[f"rtec.out-{number}"] - driven[f"joint.{joint}.motor-offset"]
        columns[f"tool_{axis}_mm"] = driven[f"rtec.tool-{number}"]
        for name, pin in (("model", "model"), ("table", "table"), ("correction", "corr")):
            columns[f"{name}_{axis}_um"] = 1e3 * driven[f"rtec.{pin}-{number}"]
        columns[f"following_error_{axis}_um"] = 1e3 * driven[f"joint.{joint}.f-error"]
    columns |= {name: driven[f"rtec.in-use-{k}"] for k, name in enumerate(named)}
    columns |= {name: driven[f"rtec.{pin}"] for name, pin in COUNTED.items()}
    columns["oldest_age_s"] = driven["rtec.oldest-age"]
    per_ns = _clocks_per_ns()
    for name, pin in (("write_ns", "rtec.write.time"), ("thread_ns", "servo-thread.time")):
        columns[name] = np.asarray(np.round(driven[pin] / per_ns), dtype=np.float64)
    return Samples(PERIOD_S, AXES, named, {name: columns[name] for name in column_names(AXES, named)})


def _clocks_per_ns() -> float:
    """Of the counts in which LinuxCNC gives times; 1 where its library is not there, which then gives nanoseconds."""
    try:
        library = ctypes.CDLL("liblinuxcnchal.so.0")
        clocks = library.rtapi_get_clocks
    except (OSError, AttributeError):
        return 1.0
    clocks.restype = ctypes.c_longlong
    from_ns, from_clocks = time.perf_counter_ns(), clocks()
    time.sleep(0.1)
    return float((clocks() - from_clocks) / (time.perf_counter_ns() - from_ns))
