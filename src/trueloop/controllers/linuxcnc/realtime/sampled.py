"""The record of every servo period: the pins that HAL's `sampler` takes, and the lines that wire them to it.

A stream of LinuxCNC gives no number to a record that found no room, so every stream begins with the corrector's own
count of periods: records of several streams are joined by it, and lost ones are seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

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
    """Returns all pins to record, without the count of periods.

    `joints`: by axis (0, 1, 2 for X, Y, Z) its joint's number. `signals`: how many the image needs.
    """
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
