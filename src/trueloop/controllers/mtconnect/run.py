"""The adapter beside a LinuxCNC: its status is read by a child process, which may hang or end; agents go on."""

import asyncio
import json
import signal
import socket
import time
from asyncio.subprocess import DEVNULL, PIPE, Process
from contextlib import suppress
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any, Final

from trueloop.controllers.mtconnect.adapter import LONGEST_LINE, Adapter, Say
from trueloop.controllers.mtconnect.agent import HEARTBEAT, Limits, Said, nothing, observed, pins_of
from trueloop.controllers.mtconnect.items import Machine

EVERY_S: Final = 0.1
AGAIN_S: Final = 1.0
START_S: Final = 20.0
"""Until a child says its first: Python has to start."""
LONGEST_STATUS: Final = 65536
LONGEST_PART: Final = 200


@dataclass(frozen=True)
class Source:
    """Where the values come from. `part_file`: its first line names the part in the machine."""

    machine: Machine
    limits: Limits = field(default_factory=Limits)
    python: Path = Path("/usr/bin/python3")
    part_file: Path | None = None


class _Alive:
    """Whether a counter goes on counting."""

    def __init__(self, limit_s: float) -> None:
        self._limit_s, self._seen, self._since = limit_s, float("nan"), float("-inf")

    def __call__(self, count: float | None) -> bool:
        now = time.monotonic()
        if count is not None and count != self._seen:
            self._seen, self._since = count, now
        return now - self._since <= self._limit_s


def run(source: Source, socket_: socket.socket, say: Say) -> None:
    """Runs until SIGINT or SIGTERM."""
    asyncio.run(_run(source, socket_, say))


async def _run(source: Source, socket_: socket.socket, say: Say) -> None:
    adapter, ended = Adapter(nothing(source.machine), say), asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    server = await asyncio.start_server(adapter.serve, sock=socket_, limit=LONGEST_LINE)
    reading = asyncio.create_task(_read(source, adapter, say))
    until = asyncio.create_task(ended.wait())
    await asyncio.wait((until, reading), return_when=asyncio.FIRST_COMPLETED)
    server.close()
    for agent in list(adapter.agents):
        agent.writer.transport.abort()
    until.cancel()
    reading.cancel()
    with suppress(asyncio.CancelledError):
        await reading  # raises what ended it, where that is a fault of ours


async def _read(source: Source, adapter: Adapter, say: Say) -> None:
    """Child after child: one that is silent or gone leaves all UNAVAILABLE, and is begun anew."""
    last = ""
    while True:
        try:
            why = await _read_child(source, adapter)
        except OSError as error:
            why = f"{source.python}: {error.strerror or error}"
        adapter.tell(nothing(source.machine))
        if why != last:
            say(f"LinuxCNC's status is not read: {why}; tried again until it is")
        last = why
        await asyncio.sleep(AGAIN_S)


async def _read_child(source: Source, adapter: Adapter) -> str:
    """Tells what one child says; why that ended. Raises OSError where it cannot be begun."""
    script = resources.files("trueloop.controllers.mtconnect") / "read_status.py"
    command = (str(source.python), str(script), str(EVERY_S), *pins_of(source.machine))
    child = await asyncio.create_subprocess_exec(
        *command, stdin=DEVNULL, stdout=PIPE, stderr=PIPE, limit=LONGEST_STATUS
    )
    alive, patience_s = _Alive(source.limits.status_s), START_S
    try:
        assert child.stdout is not None
        while line := await asyncio.wait_for(child.stdout.readline(), patience_s):
            patience_s = source.limits.status_s
            said: dict[str, Any] = json.loads(line)
            pins = said["pins"]
            seen = Said(said["status"], pins, alive(pins.get(HEARTBEAT)), _part(source.part_file))
            adapter.tell(observed(source.machine, seen, source.limits))
    except TimeoutError:
        return f"it said nothing for {patience_s:g} s"
    except ValueError as error:
        return f"it said what is no status: {error}"
    finally:
        await _end(child)
    errors = (await child.stderr.read()).decode(errors="replace").strip() if child.stderr else ""
    return errors.splitlines()[-1] if errors else "LinuxCNC has ended"


async def _end(child: Process) -> None:
    with suppress(ProcessLookupError):
        child.terminate()
    try:
        await asyncio.wait_for(child.wait(), AGAIN_S)
    except TimeoutError:
        with suppress(ProcessLookupError):
            child.kill()
        await child.wait()


def _part(file: Path | None) -> str:
    if file is None:
        return ""
    try:
        with file.open(encoding="utf-8", errors="replace") as opened:
            return opened.readline(LONGEST_PART).strip()
    except OSError:
        return ""
