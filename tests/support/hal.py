"""LinuxCNC's hardware layer alone, in namespaces of its own: no motion, no real-time thread."""

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tests.support.signals import until
from trueloop.controllers.linuxcnc.realtime.install import require_linuxcnc
from trueloop_lab.linuxcnc.session import _namespaces

SPEED = """
import hal, time
component = hal.component("spindle-encoder")
component.newpin("speed", hal.HAL_FLOAT, hal.HAL_OUT)
component["speed"] = -12.5
component.ready()
time.sleep(600)
"""
"""A component that gives a speed, rev/s."""


@dataclass
class Hal:
    """The hardware layer of one namespace."""

    first: str
    environment: dict[str, str]
    started: "list[subprocess.Popen[bytes]]" = field(default_factory=list)

    def start(self, *command: object, log: Path) -> "subprocess.Popen[bytes]":
        """A process in there."""
        enter = ["nsenter", "--target", self.first, "--net", "--ipc", "--pid", "--mount"]
        enter += [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        with log.open("ab") as said:
            process = subprocess.Popen(
                [*enter, *map(str, command)], env=self.environment, stdin=subprocess.DEVNULL, stdout=said, stderr=said
            )
        self.started.append(process)
        return process

    def ask(self, *words: object) -> str:
        """What halcmd answers."""
        enter = ["nsenter", "--target", self.first, "--net", "--ipc", "--pid", "--mount"]
        enter += [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        done = subprocess.run(
            [*enter, "halcmd", "-s", *map(str, words)],
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=30,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    def value(self, pin: str) -> float:
        """Of a pin."""
        told = self.ask("getp", pin)
        return float(int(told, 0)) if told.startswith("0x") else float(told)


@contextmanager
def hardware_layer(folder: Path) -> Iterator[Hal]:
    """Until the block ends; with it ends every process in there."""
    require_linuxcnc()
    environment = os.environ | {"HOME": str(folder), "RTAPI_FIFO_PATH": str(folder / "rtapi_fifo")}
    process = subprocess.Popen([*_namespaces(), "sleep", "300"], stdin=subprocess.DEVNULL)
    try:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        until(lambda: children.read_text().split(), "the namespaces")
        hal = Hal(children.read_text().split()[0], environment)
        try:
            yield hal
        finally:
            os.kill(int(hal.first), signal.SIGKILL)
            for started in hal.started:
                started.wait(20)
    finally:
        process.kill()
        process.wait()
