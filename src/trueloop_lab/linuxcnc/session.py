"""One program on one LinuxCNC: started headless in namespaces of its own, run, stopped.

The files of the virtual lathe, and its components, built for LinuxCNC's hardware layer.
"""

import json
import os
import re
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from trueloop.arrays import Array
from trueloop.controllers.linuxcnc.realtime.install import compiled, require_linuxcnc
from trueloop.errors import Code, Place, TrueloopError


def source(name: str) -> str:
    """Returns the text of a file that comes with this package."""
    return (resources.files("trueloop_lab.linuxcnc") / name).read_text()


@cache
def virtual_part() -> bytes:
    """Compiles the virtual part to a shared object, once a run. Raises CTL-LINUXCNC with the compiler's words."""
    return compiled("virtual_part", {"virtual_part.comp": source("virtual_part.comp").encode()})


@cache
def recorder() -> bytes:
    """Compiles recorder.so, for sessions that are judged. Raises RTC-BUILD, CTL-LINUXCNC."""
    return compiled("recorder", {"recorder.comp": source("realtime/recorder.comp").encode()}, code=Code.RTC_BUILD)


TIMEOUT_S: Final = 600.0
POLL_S: Final = 0.1
TOO_BUSY: Final = "USRMOT: ERROR: command timeout"
"""LinuxCNC prints this where its motion lacked processor time to take a command. It ends the program without a message,
or sends the command again: a compensation table then seems to hold a place twice.
"""

NO_COMMAND: Final = "LinuxCNC carried out no command"
"""Message of the operator where a command that takes a moment was not carried out after a minute."""

QUEUE_LATE: Final = "Queue is not empty after probing"
"""Error of the interpreter where the task continues after a probing move before motion has reported an empty queue."""

ATTEMPTS: Final = 3
"""Runs of one program at most, where the computer interrupts each."""

PARAMETERS: Final = [*range(5161, 5170), *range(5181, 5190), *range(5210, 5391)]

T = TypeVar("T")
Progress = Callable[[int, float, float], None]
"""Called with line, x and z while a program runs."""


@dataclass(frozen=True)
class ProbedPart:
    """The probed part: its surface (n, 2) and the probe's own errors; mm and rad."""

    surface_mm: Array
    ball_radius_mm: float
    pre_travel_mm: float = 0.0
    lobing_mm: float = 0.0
    lobes: int = 3
    lobing_phase_rad: float = 0.0

    def to_bytes(self) -> bytes:
        """Returns the bytes that the component reads."""
        head = [len(self.surface_mm), self.ball_radius_mm, self.pre_travel_mm, self.lobing_mm, self.lobes]
        return np.concatenate([[*head, self.lobing_phase_rad], np.ravel(self.surface_mm)]).astype(np.float64).tobytes()


def cut(program: bytes, feed_override: float = 1.0, progress: Progress | None = None) -> Array:
    """Returns where the axes were in every servo period of a program, (n, 2), x a radius, mm.

    A run that the computer interrupted is made again, up to `ATTEMPTS` times. Raises CTL-LINUXCNC where LinuxCNC is
    missing or each run is interrupted, CTL-PROGRAM where it stops the program with an error.
    """

    def run() -> Array:
        with _session(program, feed_override, source("sample.hal"), sample=True) as folder:
            _run(folder, progress)
            return np.loadtxt(folder / "config" / "positions.txt", ndmin=2)

    return _uninterrupted(run)


def probe(program: bytes, part: ProbedPart, log_name: str, progress: Progress | None = None) -> str:
    """Returns what a probing program wrote to `log_name`, run against a part. Repeats and raises as `cut` does."""

    def run() -> str:
        with _session(program, 1.0, source("probe.hal"), sample=False) as folder:
            (folder / "config" / "surface.bin").write_bytes(part.to_bytes())
            (folder / "modules" / "virtual_part.so").write_bytes(virtual_part())
            _run(folder, progress)
            log = folder / "config" / log_name
            return log.read_text() if log.exists() else ""

    return _uninterrupted(run)


class _InterruptedError(TrueloopError):
    """A run that ended early, or has gaps, for want of processor time: nothing in the program is the cause."""


def _uninterrupted(run: Callable[[], T]) -> T:
    """Returns the result of the first run that the computer does not interrupt; each starts LinuxCNC anew."""
    for _ in range(ATTEMPTS - 1):
        with suppress(_InterruptedError):
            return run()
    return run()


@contextmanager
def configuration(files: Mapping[str, bytes], modules: Mapping[str, bytes] | None = None) -> Iterator[Path]:
    """Makes a folder with the virtual lathe's configuration, with files added or in place of its own.

    `files` lie in its `config`, `order.json` being the operator's; `modules` are laid over LinuxCNC's own.
    """
    require_linuxcnc()
    own = {file: source(file).encode() for file in ("machine.ini", "machine.hal", "run_program.py")}
    own["display"] = b"#!/bin/sh\nexec /usr/bin/python3 run_program.py\n"
    own["extra.hal"] = b""
    own["tool.tbl"] = "".join(f"T{k} P{k} X0 Z0\n" for k in range(1, 33)).encode()
    own["machine.var"] = "".join(f"{k}\t{float(k == 5220):.6f}\n" for k in PARAMETERS).encode()
    with tempfile.TemporaryDirectory(prefix="trueloop-linuxcnc-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        folder.chmod(0o755)
        for made in ("config", "modules", "home"):
            (folder / made).mkdir()
        (folder / "home").chmod(0o1777)
        for file, content in (own | dict(files)).items():
            (folder / "config" / file).write_bytes(content)
        for file, content in (modules or {}).items():
            (folder / "modules" / file).write_bytes(content)
        (folder / "config" / "display").chmod(0o755)
        yield folder


@contextmanager
def _session(program: bytes, feed_override: float, extra_hal: str, *, sample: bool) -> Iterator[Path]:
    """A configuration whose operator runs one program."""
    order = {"program": "program.ngc", "feed_override": feed_override, "sample": sample, "timeout_s": TIMEOUT_S}
    files = {"program.ngc": program, "extra.hal": extra_hal.encode(), "order.json": json.dumps(order).encode()}
    with configuration(files) as folder:
        yield folder


def _run(folder: Path, progress: Progress | None) -> None:
    """Plays the order. Raises CTL-LINUXCNC, CTL-PROGRAM."""
    play(folder, progress)
    _require_success(folder)


def play(folder: Path, progress: Progress | None = None) -> None:
    """Starts LinuxCNC and waits for its end."""
    with started(folder) as process:
        _wait(process, folder / "config" / "progress.txt", progress)


@contextmanager
def started(folder: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Starts LinuxCNC in namespaces of its own; ends it with everything it started when this is left."""
    environment = os.environ | {"RTAPI_UID": "65534"}
    environment.pop("DISPLAY", None)
    (folder / "session.sh").write_text(source("session.sh"))
    with (folder / "linuxcnc.log").open("ab") as log:
        process = subprocess.Popen(
            [*_namespaces(), "bash", str(folder / "session.sh"), str(folder)],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )
        try:
            yield process
        finally:
            _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Ends the namespace of processes and waits until the last of them is gone.

    The first process of the namespace is the one to kill: the kernel lets it be waited for only when all others have
    died. Were `unshare` killed instead, some would still write into the folder while it is removed.
    """
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    with suppress(FileNotFoundError, ProcessLookupError):
        for first in children.read_text().split():
            os.kill(int(first), signal.SIGKILL)
            process.wait()
    process.kill()
    process.wait()


def _namespaces() -> Sequence[str]:
    mapped = [] if os.geteuid() == 0 else ["--user", "--map-current-user", "--keep-caps"]
    return [*("unshare", "--net", "--ipc", "--pid", "--fork", "--mount", "--mount-proc", "--kill-child"), *mapped]


def _wait(process: "subprocess.Popen[bytes]", file: Path, progress: Progress | None) -> None:
    while True:
        try:
            process.wait(POLL_S)
            return
        except subprocess.TimeoutExpired:
            if progress is not None and file.exists():
                _report(file, progress)


def _report(file: Path, progress: Progress) -> None:
    lines = file.read_text().splitlines()
    words = lines[-1].split() if lines else []
    if len(words) == 3:
        progress(int(words[0]), float(words[1]), float(words[2]))


def answer(folder: Path) -> dict[str, Any]:
    """Returns what the operator left behind. Raises CTL-LINUXCNC with LinuxCNC's words where it left nothing."""
    answer_file = folder / "config" / "answer.json"
    if not answer_file.exists():
        said = (folder / "linuxcnc.log").read_text(errors="replace").strip().splitlines()
        telling = [line for line in said if re.search("error|fail|denied|not permitted", line, re.IGNORECASE)]
        raise Code.CTL_LINUXCNC.refusal(
            f"LinuxCNC did not come up; it said: {' / '.join((telling or said)[:3])!r}",
            hint="it needs the right to make namespaces and to mount: run as root, or allow it to a container",
        )
    left: dict[str, Any] = json.loads(answer_file.read_text())
    return left


def _require_success(folder: Path) -> None:
    left = answer(folder)
    if left["error"] is not None:
        raise _stopped(folder, left)
    if left.get("overruns"):
        raise _InterruptedError(
            Code.CTL_LINUXCNC,
            f"{left['overruns']} servo periods were not recorded",
            hint="the computer is too busy: run it again with less beside it",
        )


def _stopped(folder: Path, answer: dict[str, Any]) -> TrueloopError:
    """LinuxCNC's own message, and the block it means."""
    said, why = str(answer["error"]).strip(), ""
    if TOO_BUSY in (folder / "linuxcnc.log").read_text(errors="replace"):
        why = f"LinuxCNC ended the program because its motion did not answer for a second: {TOO_BUSY!r}, {said!r}"
    elif said.startswith(QUEUE_LATE):
        why = f"LinuxCNC's interpreter read a probe result before its motion had reported the end of the move: {said!r}"
    elif said.startswith(NO_COMMAND):
        why = said
    if why:
        hint = "the computer is too busy: run it again with less beside it"
        return _InterruptedError(Code.CTL_LINUXCNC, why, hint=hint)
    lines = (folder / "config" / "program.ngc").read_text(errors="replace").splitlines()
    line = _line_meant(folder, said, lines, answer["line"] or 1)
    return Code.CTL_PROGRAM.refusal(
        f"LinuxCNC stopped: {said!r}, at block {lines[line - 1].strip()!r}",
        hint="the block is that of the program that was sent; `trueloop nc check` looks at it without running it",
        place=Place(line=line),
        values={"said": said, "block": lines[line - 1].strip()},
    )


def _line_meant(folder: Path, said: str, lines: Sequence[str], moving: int) -> int:
    """The line an error is about. The interpreter reads ahead of the line that moves, and does not say where it is.

    Some messages name the line or the code; what the interpreter objects to it objects to again, alone, and then shows
    the block.
    """
    named = re.search(r"on line (\d+)", said)
    if named:
        return min(int(named[1]), len(lines))
    moving = min(moving, len(lines))
    code = re.match(r"G38\.\d", said)
    if code:  # the line reported may be the one after the probing move
        return max((k + 1 for k, text in enumerate(lines[:moving]) if code[0] in text), default=moving)
    command = ["rs274", "-g", "-n", "2", "-t", "tool.tbl", "-v", "machine.var", "program.ngc"]
    alone = subprocess.run(
        command,
        cwd=folder / "config",
        env=os.environ | {"HOME": str(folder / "home")},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    *_, message, block = ["", "", *alone.stderr.strip().splitlines()]
    behind = [k + 1 for k, text in enumerate(lines) if text.strip() == block.strip()] if message.strip() == said else []
    return min(behind, key=lambda line: (line < moving, line), default=moving)
