"""LinuxCNC headless with the corrector in its servo thread: steps are carried out, pins recorded period by period.

    driven = drive(
        Setup(image=..., record=("joint.0.pos-cmd", "rtec.out-0", "rtec.phase")),
        [on(), home(), put("rtec.enable", 1), wait("rtec.phase", 3), record(), run("part.ngc"), record(False)],
    )
    driven["rtec.out-0"]

The virtual lathe is the folder's `machine.ini`: joint 0 is X, joint 1 is Z, so that Z is `joint.1.pos-cmd` and
`rtec.at-2`; it homes in place, at X 300, Z 100. Commands in machine coordinates are `joint.N.pos-cmd`; where the drives
stand is `rtec.out-0` and `rtec.out-2` less `joint.N.motor-offset`, of the same row. Any pin can be recorded, whatever
its type, linked or not; values are doubles, not digits. One row a servo period of 1 ms; take columns by name.

Signals: without `rtec-signals` nobody changes `rtec.heartbeat`. With `QUIET` in `hal` values stand as steps set them,
from when `put("rtec.heartbeat", 1)` has shown once that somebody is there.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.controllers.linuxcnc.realtime.install import component
from trueloop.errors import Code
from trueloop_lab.linuxcnc.session import Progress, answer, configuration, play, recorder, source

WIRE: Final = "net x-drive rtec.out-0 => rtec.drive-fb-0\nnet z-drive rtec.out-2 => rtec.drive-fb-2\n"
"""Drives without following error."""

QUIET: Final = "setp rtec.watchdog 1e6\nsetp rtec.stale 1e6\n"
"""No heartbeat is waited for: signals are what a step sets."""

HEAD: Final = 2

Step = tuple[Any, ...]
"""Verb and arguments, see `run_steps.py`."""


@dataclass(frozen=True)
class Setup:
    """A machine with a corrector.

    `files`: beside the configuration, as programs; `image.rtec` is the image. `record`: pins, see above. `hal`: lines
    after all others. `drives`: what lies between `rtec.out-N` and `rtec.drive-fb-N`. `machine_hal`: in place of the
    wiring that comes with this file. `ini`: section, key, value of `machine.ini`, in place of a line there or added.
    `module`: further parameters of `loadrt rtec`. `modules`: further shared objects. `depth`: rows that fit.
    """

    image: bytes
    files: Mapping[str, bytes] = field(default_factory=dict)
    record: Sequence[str] = ()
    hal: str = ""
    drives: str = WIRE
    machine_hal: str | None = None
    ini: Sequence[tuple[str, str, str]] = ()
    module: str = ""
    modules: Mapping[str, bytes] = field(default_factory=dict)
    depth: int = 120_000


@dataclass(frozen=True)
class Driven:
    """The result of a session: rows (n, columns), values that steps asked for, what LinuxCNC said, its log."""

    columns: tuple[str, ...]
    samples: Array
    got: Mapping[str, Any]
    messages: tuple[str, ...]
    log: str

    def __getitem__(self, pin: str) -> Array:
        """One pin, period by period, (n,)."""
        return self.samples[:, self.columns.index(pin)]


def drive(setup: Setup, steps: Sequence[Step], progress: Progress | None = None) -> Driven:
    """Carries out the steps. Messages of LinuxCNC end nothing: they are reported.

    Raises CTL-LINUXCNC where LinuxCNC is missing, does not come up, or a step cannot be done, RTC-BUILD where the
    component cannot be compiled.
    """
    order = {"steps": steps, "record": list(setup.record), "depth": setup.depth}
    with configuration(_files(setup) | {"order.json": json.dumps(order).encode()}, _modules(setup)) as folder:
        play(folder, progress)
        left = answer(folder)
        log = (folder / "linuxcnc.log").read_text(errors="replace")
        if left["error"] is not None:
            raise Code.CTL_LINUXCNC.refusal(
                f"{left.get('step', 'LinuxCNC')}: {left['error']}",
                hint=f"LinuxCNC said: {' / '.join(left['messages']) or 'nothing'}",
            )
        rows = folder / "config" / "samples.bin"
        columns = tuple(left["columns"])
        return Driven(columns, _samples(rows.read_bytes() if columns else b"", columns), *_said(left), log)


def on() -> Step:
    """Makes the step out of the emergency stop, machine on."""
    return ("on",)


def home(joint: int = -1) -> Step:
    """Makes the step that homes a joint, or all, and waits until it is homed."""
    return ("home", joint)


def mdi(block: str) -> Step:
    """Makes the step that executes one block and waits until it is done."""
    return ("mdi", block)


def run(program: str, feed_override: float = 1.0) -> Step:
    """Makes the step that runs a program of `files` to its end or first error; `start` and `finish` take two steps."""
    return ("run_program", program, feed_override)


def put(name: str, to: float | str) -> Step:
    """Makes the step that sets a pin or parameter."""
    return ("set", name, to)


def get(name: str, *pins: str) -> Step:
    """Values for `Driven.got`, to the six digits of halcmd."""
    return ("get", name, *pins)


def wait(pin: str, value: float, timeout_s: float = 60.0) -> Step:
    """Makes the step that waits until a pin has a value."""
    return ("wait", pin, value, timeout_s)


def sleep(seconds: float) -> Step:
    """Makes the step that waits, for what has no pin to wait for."""
    return ("sleep", seconds)


def record(on: bool = True) -> Step:
    """Makes the step from which on rows are recorded, or are not."""
    return ("record", on)


def note(name: str) -> Step:
    """Makes the step that notes how many rows there are by then: a place in `Driven.samples`."""
    return ("note", name)


def _said(left: dict[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    return left["got"], tuple(left["messages"])


def _files(setup: Setup) -> dict[str, bytes]:
    texts = {
        "machine.ini": with_entries(source("machine.ini"), setup.ini),
        "machine.hal": setup.machine_hal or source("realtime/machine.hal"),
        "rtec.hal": f"loadrt rtec image=image.rtec {setup.module}\n",
        "drives.hal": setup.drives,
        "extra.hal": setup.hal,
        "run_steps.py": source("realtime/run_steps.py"),
        "display": "#!/bin/sh\nexec /usr/bin/python3 run_steps.py\n",
    }
    return {name: text.encode() for name, text in texts.items()} | {"image.rtec": setup.image} | dict(setup.files)


def _modules(setup: Setup) -> dict[str, bytes]:
    return {"rtec.so": component(), "recorder.so": recorder(), **setup.modules}


def with_entries(ini: str, entries: Sequence[tuple[str, str, str]]) -> str:
    """Sets keys in an INI file's text, section by section."""
    for section, key, value in entries:
        head, found, rest = ini.partition(f"[{section}]\n")
        body, following, after = rest.partition("\n[")
        kept = [line for line in body.splitlines() if line.partition("=")[0].strip() != key]
        written = "\n".join([found.strip() or f"\n[{section}]", *kept, f"{key} = {value}"])
        ini = head + written + (following or "\n") + after
    return ini


def _samples(content: bytes, columns: Sequence[str]) -> Array:
    """The recorder's file as rows."""
    words = np.frombuffer(content, dtype=np.float64)
    if not len(words):
        return np.empty((0, len(columns)))
    count, lost = int(words[0]), int(words[1])
    if lost:
        raise Code.CTL_LINUXCNC.refusal(
            f"{lost} servo periods found no room behind {count} recorded ones", hint="give the session a larger depth"
        )
    return words[HEAD : HEAD + count * len(columns)].reshape(count, len(columns)).copy()
