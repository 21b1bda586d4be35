"""The virtual lathe with LinuxCNC as its controller, on and homed until it is switched off: `RunningLathe`."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

from trueloop.controllers.linuxcnc.cell.linuxcnc import Task
from trueloop_lab.linuxcnc.session import configuration, started

LONGEST_S: Final = 60.0
_DISPLAY: Final = """#!/bin/sh
exec /usr/bin/python3 switch_on.py
"""
_SWITCH_ON: Final = """
import time
from pathlib import Path
import linuxcnc
from run_program import Operator

operator = Operator()
operator.switch_on()
Path("on.txt").write_text("on")
while True:
    time.sleep(1)
"""


class RunningLathe:
    """One lathe; `on` and `killed` as often as one likes. Its files stay."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.config = folder, folder / "config"
        self.ini = self.config / "machine.ini"
        self._session: ExitStack | None = None

    def on(self) -> None:
        """Switches it on, and waits until it is homed. Raises TimeoutError where it does not come up."""
        (self.config / "on.txt").unlink(missing_ok=True)
        self._session = ExitStack()
        process = self._session.enter_context(started(self.folder))
        until = time.monotonic() + LONGEST_S
        while not (self.config / "on.txt").exists():
            if process.poll() is not None or time.monotonic() > until:
                said = (self.folder / "linuxcnc.log").read_text(errors="replace")[-2000:]
                raise TimeoutError(f"LinuxCNC is not on within {LONGEST_S:g} s:\n{said}")
            time.sleep(0.02)

    def killed(self) -> None:
        """Everything of it is gone at once, as when the power goes."""
        if self._session is not None:
            self._session.close()
            self._session = None

    def beside(self, *command: str) -> Sequence[str]:
        """A command that sees this LinuxCNC: it shares its memory, and this computer's network."""
        pid = Task(self.ini, "milltask").pid()
        assert pid is not None, "LinuxCNC does not run"
        user = [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        return ["nsenter", f"--target={pid}", "--ipc", *user, *command]

    def python(self, *words: str, **given: object) -> "subprocess.Popen[str]":
        """Python itself, beside it, as the user who runs it."""
        command = self.beside(sys.executable, *words)
        return subprocess.Popen(command, text=True, **{"env": self.environment, **given})  # type: ignore[call-overload,no-any-return]

    @property
    def environment(self) -> dict[str, str]:
        """Of what works with it: LinuxCNC keeps a file of its tools at home, and a socket for its components."""
        home = self.folder / "home"
        own = {"HOME": str(home), "RTAPI_UID": "65534", "RTAPI_FIFO_PATH": str(home / "rtapi_fifo")}
        return dict(os.environ) | own


@contextmanager
def running_lathe(files: Mapping[str, bytes], modules: Mapping[str, bytes] | None = None) -> Iterator[RunningLathe]:
    """A lathe that is on. `files` are laid into its configuration, `modules` over LinuxCNC's own."""
    own = {"display": _DISPLAY.encode(), "switch_on.py": _SWITCH_ON.encode()}
    with configuration(own | dict(files), modules) as folder:
        lathe = RunningLathe(folder)
        try:
            lathe.on()
            yield lathe
        finally:
            lathe.killed()
