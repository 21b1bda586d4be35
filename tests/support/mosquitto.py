"""A real MQTT broker, Debian's mosquitto, on the loopback."""

import getpass
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.support.signals import until

INSTALL = "apt-get install -y --no-install-recommends mosquitto"
PROGRAM = "/usr/sbin/mosquitto"


@dataclass
class Broker:
    """A broker that can be stopped and started again at the same port."""

    folder: Path
    port: int
    lines: tuple[str, ...] = ()
    process: "subprocess.Popen[bytes] | None" = None

    def start(self) -> None:
        """Waits until it answers."""
        program = shutil.which("mosquitto") or PROGRAM
        assert Path(program).exists(), f"mosquitto is not installed; run as root:  {INSTALL}"
        config = self.folder / "mosquitto.conf"
        lines = self.lines or ("allow_anonymous true",)
        own = f"user {getpass.getuser()}"  # started by root it becomes another user, who may not read the files
        config.write_text("\n".join([own, f"listener {self.port} 127.0.0.1", *lines, ""]))
        with (self.folder / "mosquitto.log").open("ab") as log:
            self.process = subprocess.Popen([program, "-c", config], stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        until(self._answers, "mosquitto to answer")

    def _answers(self) -> bool:
        assert self.process is not None
        assert self.process.poll() is None, (self.folder / "mosquitto.log").read_text()
        try:
            socket.create_connection(("127.0.0.1", self.port), 1).close()
        except OSError:
            return False
        return True

    def stop(self) -> None:
        """Ends it and waits for that."""
        if self.process is not None:
            self.process.terminate()
            self.process.wait(10)
            self.process = None


@contextmanager
def broker(folder: Path, *lines: str) -> Iterator[Broker]:
    """A broker with these lines of configuration."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    running = Broker(folder, port, lines)
    try:
        running.start()
        yield running
    finally:
        running.stop()
