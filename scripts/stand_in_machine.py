"""A machine that stands in for LinuxCNC: it executes programs line by line; an operator presses buttons at will.

It knows LOGAPPEND, LOG, PROBEOPEN, ABORT under an `if EXISTS`, and parameters, in a process of its own.
"""

import json
import os
import random
import re
import signal
import threading
import time
from contextlib import AbstractContextManager, suppress
from hashlib import sha256
from multiprocessing.connection import Client as Connect
from multiprocessing.connection import Listener
from pathlib import Path
from typing import Any, Final

from trueloop.controllers.linuxcnc.cell.client import Client, Pace, Service
from trueloop.controllers.linuxcnc.cell.decide import ControlNow, Doing, Patience
from trueloop.controllers.linuxcnc.cell.journal import Journal
from trueloop.domain.factory import BlockKind
from trueloop.errors import Code
from trueloop.nc.witness import LOG_FILE

EMPTY: Final = "nothing.ngc"
WITHIN_S: Final = 0.6
PACE: Final = Pace(0.004, 0.01, 0.1, 0.05, Patience(0.05, 0.15, 0.3))


class StandIn:
    """The machine: what is loaded, whether it runs, and which parameters are set."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.program, self.running, self.stopped = folder, "", False, False
        self.set: set[bytes] = set()
        self.lock, self.stood = threading.Lock(), time.monotonic()

    def ask(self, what: str, name: str) -> Any:
        """One command of the panel."""
        with self.lock:
            if what == "open" and not self.running:
                self.program = name
            elif what == "start" and not self.running and self.program:
                text = self._file().read_bytes() if self._file().exists() else b""
                self.running, self.stopped = True, False
                threading.Thread(target=self._run, args=(text, self.program), daemon=True).start()
            elif what == "stop":
                self.stopped = True
            elif what == "clear" and not self.running and self.program == name:
                self.program = EMPTY
        return self.program, self.running, time.monotonic() - self.stood

    def _file(self) -> Path:
        return self.folder / self.program

    def _run(self, text: bytes, program: str) -> None:
        try:
            whole, touches = self._execute(text)
            if whole is not None and program != EMPTY:
                said = {
                    "whole": whole,
                    "key": program.removesuffix(".ngc"),
                    "text": text.decode("latin-1"),
                    "touches": touches,
                }
                with (self.folder / "executed.jsonl").open("a") as file:
                    file.write(json.dumps(said) + "\n")
        finally:
            with self.lock:
                self.running, self.stood = False, time.monotonic()

    def _execute(self, text: bytes) -> tuple[bool | None, str]:
        """Whether it came to its end, None: it did not begin; and the touches that it wrote."""
        touches, log = "", None
        for line in map(bytes.strip, text.splitlines()):
            if found := re.fullmatch(rb"o<\S+> if .*EXISTS\[(#<\w+>)\]\]", line):
                if found[1] in self.set:
                    return None, ""
            elif found := re.fullmatch(rb"(#<\w+>) = 1", line):
                self.set.add(found[1])
            elif found := re.fullmatch(rb"\(LOGAPPEND,(.*)\)", line):
                log = self.folder / found[1].decode()
            elif (found := re.fullmatch(rb"\(LOG,(.*)\)", line)) and log:
                with log.open("ab") as file:
                    file.write(found[1] + b"\n")
            elif found := re.fullmatch(rb"\(PROBEOPEN (.*)\)", line):
                touches = sha256(os.urandom(8)).hexdigest()
                (self.folder / found[1].decode()).write_text(touches)
            elif line.startswith(b"G"):
                time.sleep(random.uniform(0, 0.02))
                if self.stopped:
                    return False, touches
            elif line in (b"M2", b"M30"):
                return True, touches
        return bool(text) or None, touches


def serve_machine(folder: Path) -> int:
    """Starts the machine; its process number."""
    child = os.fork()
    if child:
        while not (folder / "panel").exists():
            time.sleep(0.01)
        return child
    machine = StandIn(folder)
    listener = Listener(str(folder / "panel"))
    threading.Thread(target=_operator, args=(machine,), daemon=True).start()
    while True:
        with suppress(OSError, EOFError):
            threading.Thread(target=_answer, args=(machine, listener.accept()), daemon=True).start()


def _answer(machine: StandIn, connection: Any) -> None:
    with suppress(OSError, EOFError), connection:
        while True:
            connection.send(machine.ask(*connection.recv()))


def _operator(machine: StandIn) -> None:
    while True:
        time.sleep(random.uniform(0, 0.3))
        machine.ask("start", "")
        if random.random() < 0.05:
            machine.ask("stop", "")
        if random.random() < 0.3:  # and once more
            time.sleep(random.uniform(0, 0.1))
            machine.ask("start", "")


class Remote:
    """The panel of the machine, as a client's control."""

    def __init__(self, folder: Path) -> None:
        self.folder, self._line = folder, Connect(str(folder / "panel"))
        self._since = time.monotonic()

    def _ask(self, what: str, name: str = "") -> Any:
        self._line.send((what, name))
        return self._line.recv()

    def now(self) -> ControlNow:
        """What the panel shows."""
        program, running, stood_s = self._ask("look")
        still_s = 0.0 if running else min(stood_s, time.monotonic() - self._since)
        return ControlNow(Doing.RUNNING if running else Doing.IDLE, program, still_s)

    def witness(self) -> str:
        """The log of the programs."""
        file = self.folder / LOG_FILE
        return file.read_text() if file.exists() else ""

    def write(self, name: str, text: bytes) -> None:
        """Into the folder."""
        (self.folder / name).write_bytes(text)

    def read_back(self, name: str) -> bytes | None:
        """From the folder."""
        file = self.folder / name
        return file.read_bytes() if file.exists() else None

    def open(self, name: str) -> None:
        """Loads it. Raises CTL-LINUXCNC where a program runs at that moment, as the control does."""
        if self._ask("open", name)[0] != name:
            raise Code.CTL_LINUXCNC.refusal(f"{name!r} is not loaded: a program runs", hint="wait until it has ended")

    def clear(self, name: str) -> None:
        """Unloads it and takes it away."""
        program, running, _ = self._ask("clear", name)
        if not (running and program == name):
            (self.folder / name).unlink(missing_ok=True)

    def cycle_start(self) -> None:
        """The button."""
        self._since = time.monotonic()
        self._ask("start")

    def touches(self, name: str) -> bytes | None:
        """The file that a program wrote."""
        return self.read_back(name)

    def discard_touches(self, name: str) -> None:
        """Takes it away."""
        (self.folder / name).unlink(missing_ok=True)


class StandInMachine(AbstractContextManager["StandInMachine"]):
    """The stand-in as `cell_kills` uses it; clients are forks of this process, with a pace of milliseconds."""

    texts: Final = {
        BlockKind.SEMIFINISH: b"%\n(first cut, no M2 here)\nG21 G90 G94 F100\nG1 X1\nG1 X2\nM30\n%\n",
        BlockKind.PROBE: b"(PROBEOPEN touches.txt)\nG38.2 X0 F60\nG0 X1\n(PROBECLOSE)\nM2\n",
        BlockKind.FINISH: b"G1 X0.99\r\nG1 X1.99 ; to the shoulder\r\nM5\r\nM30\r\n",
    }
    longest_s: Final = 240.0

    def __init__(self, folder: Path) -> None:
        self.beside, self.folder, self._pid = folder, folder / "machine", 0
        self.folder.mkdir()

    def __enter__(self) -> "StandInMachine":
        self.on()
        return self

    def __exit__(self, *_: object) -> None:
        self.killed()

    def on(self) -> None:
        """Begins its process."""
        self._pid = serve_machine(self.folder)

    def killed(self) -> None:
        """Ends it."""
        os.kill(self._pid, signal.SIGKILL)
        os.waitpid(self._pid, 0)

    def shown(self) -> ControlNow:
        """The panel."""
        return Remote(self.folder).now()

    def journal(self) -> Path:
        """The client's."""
        return self.beside / "cell.journal"

    def cell_killed(self, key: str, address: str, drawn: random.Random) -> None:
        """A client in a process of its own."""
        child = os.fork()
        if child == 0:
            try:
                self._work(key, address, 60.0)
            except BaseException as wrong:  # a fault shows in the tally: nothing more is recorded
                (self.beside / "fault.txt").write_text(repr(wrong))
            os._exit(1)
        time.sleep(drawn.uniform(0, WITHIN_S))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)

    def settled(self, key: str, address: str) -> None:
        """A last client, which goes on until nothing that it noted is left to deliver."""
        self._work(key, address, 1.0, deliver_within_s=60.0)

    def _work(self, key: str, address: str, for_s: float, deliver_within_s: float = 0.0) -> None:
        journal = Journal(self.journal())
        try:
            client = Client("lathe", Remote(self.folder), Service(address, key), journal, PACE)
            end = time.monotonic() + for_s
            while time.monotonic() < end or (client.known.waiting and time.monotonic() < end + deliver_within_s):
                if not client.step():
                    time.sleep(PACE.look_s)
        finally:
            journal.close()
