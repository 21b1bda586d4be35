"""HAL alone, without a control: the corrector and a sampler on a servo thread, in namespaces of its own.

Two generators move the axes, so that there is something to correct.
"""

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from trueloop.controllers.linuxcnc.realtime.install import component
from trueloop.controllers.linuxcnc.realtime.watch import sampled_pins, sampler_lines

UP_S = 30.0
UNSHARE = ("unshare", "--ipc", "--pid", "--fork", "--mount", "--mount-proc", "--kill-child")

STARTED = """\
set -eu
mount -t overlay overlay -o lowerdir="$1/modules":/usr/lib/linuxcnc/modules /usr/lib/linuxcnc/modules
cd "$1"
halcmd start
halcmd -f "$1/all.hal"
halcmd start
echo up > "$1/up"
exec sleep 600
"""

MOVING = """\
loadrt threads name1=servo-thread period1=1000000
loadrt siggen num_chan=2
loadrt rtec image=image.rtec
addf siggen.0.update servo-thread
addf siggen.1.update servo-thread
addf rtec.read servo-thread
addf rtec.write servo-thread
setp siggen.0.frequency 0.5
setp siggen.0.amplitude 40
setp siggen.0.offset 100
setp siggen.1.frequency 0.31
setp siggen.1.amplitude 100
setp siggen.1.offset -150
net x siggen.0.sine => rtec.at-0 rtec.cmd-0
net z siggen.1.sine => rtec.at-2 rtec.cmd-2
setp rtec.signal-0 25
setp rtec.watchdog 1e6
setp rtec.stale 1e6
setp rtec.homed 1
setp rtec.machine-on 1
"""
LINKED = {"rtec.at-0": "x", "rtec.cmd-0": "x", "rtec.at-2": "z", "rtec.cmd-2": "z"}
SAMPLER = "\n".join(
    line
    for line in sampler_lines(sampled_pins({0: 0, 2: 1}, 1), LINKED)
    if "f-error" not in line  # of a control's joints
)


@dataclass(frozen=True)
class Hal:
    """A running HAL; `pid`: the first process of its namespaces."""

    pid: int

    def run(self, *command: str, check: bool = True) -> "subprocess.CompletedProcess[str]":
        """A command in it."""
        return subprocess.run(self._inside(command), capture_output=True, text=True, check=check, timeout=60)

    def start(self, *command: str) -> "subprocess.Popen[bytes]":
        """A command in it that goes on."""
        return subprocess.Popen(self._inside(command), stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def _inside(self, command: Sequence[str]) -> list[str]:
        user = [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        return ["nsenter", "-t", str(self.pid), "--ipc", "--pid", "--mount", *user, *command]


@contextmanager
def hal_session(image: bytes, *, hal: str = MOVING, sampler: str = SAMPLER) -> Iterator[Hal]:
    """HAL with these lines."""
    mapped = [] if os.geteuid() == 0 else ["--user", "--map-current-user", "--keep-caps"]
    with tempfile.TemporaryDirectory(prefix="trueloop-hal-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        folder.chmod(0o1777)  # real-time HAL runs as another user
        (folder / "modules").mkdir()
        (folder / "modules" / "rtec.so").write_bytes(component())
        (folder / "image.rtec").write_bytes(image)
        (folder / "all.hal").write_text(f"{hal}\n{sampler}\n")
        (folder / "start.sh").write_text(STARTED)
        environment = os.environ | {"RTAPI_UID": "65534", "RTAPI_FIFO_PATH": f"{name}/fifo", "HOME": name}
        with (folder / "log").open("wb") as log:
            process = subprocess.Popen(
                [*UNSHARE, *mapped, "bash", f"{name}/start.sh", name],
                env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
            )  # fmt: skip
            try:
                yield Hal(_first(process, folder))
            finally:
                _end(process)


def _first(process: "subprocess.Popen[bytes]", folder: Path) -> int:
    """The first process of the namespaces, once HAL runs."""
    until = time.monotonic() + UP_S
    while not (folder / "up").exists():
        if process.poll() is not None or time.monotonic() > until:
            raise RuntimeError((folder / "log").read_text(errors="replace"))
        time.sleep(0.02)
    return _children(process)[0]


def send(process: "subprocess.Popen[bytes]", number: int) -> None:
    """A signal to a command that `Hal.start` started: its parent, which entered the namespaces, passes none on."""
    for child in _children(process):
        os.kill(child, number)


def _children(process: "subprocess.Popen[bytes]") -> list[int]:
    file = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return [int(child) for child in file.read_text().split()] if file.exists() else []


def _end(process: "subprocess.Popen[bytes]") -> None:
    """All in the namespaces die with their first process."""
    send(process, signal.SIGKILL)
    process.kill()
    process.wait()
