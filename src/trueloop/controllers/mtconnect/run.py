"""The adapter beside a LinuxCNC: its status is read by a child process, which may hang or end; agents go on."""

import asyncio
import json
import signal
import socket
import time
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib import resources
from pathlib import Path
from typing import Any, Final

from trueloop.controllers.mtconnect.agent import HEARTBEAT, Limits, MachineReport, nothing, observed, pins_of
from trueloop.controllers.mtconnect.items import Condition, Machine, Value, lines
from trueloop.errors import Code

PING_MS: Final = 10_000
"""An agent asks so often whether the adapter lives."""
BACKLOG: Final = 1_000_000
"""Bytes that wait for an agent; more, and it is let go."""
LONGEST_LINE: Final = 1024
MOST: Final = 16

Say = Callable[[str], None]


@dataclass(frozen=True)
class Agent:
    """One that is connected."""

    writer: asyncio.StreamWriter
    name: str

    def behind(self) -> int:
        """Bytes that it has not taken."""
        return self.writer.transport.get_write_buffer_size()


class Adapter:
    """The latest observation of each key, and its subscribers. No method waits for an agent."""

    def __init__(self, values: Mapping[str, Value], say: Say, backlog: int = BACKLOG) -> None:
        self._values, self._say, self._backlog = dict(values), say, backlog
        self._since = datetime.now(UTC)
        self.agents: list[Agent] = []

    def tell(self, values: Mapping[str, Value]) -> None:
        """Takes over what is observed now and sends agents what of it is new."""
        new = {key: value for key, value in values.items() if self._values.get(key) != value}
        if not new:
            return
        now = datetime.now(UTC)
        cleared = {key: Condition() for key in new if self._was_fault(key)}
        self._values.update(new)
        self._since = now
        text = "".join([*lines(cleared, now), *lines(new, now)])  # a fault stands until it is cleared
        for agent in list(self.agents):
            self._send(agent, text)

    def _was_fault(self, key: str) -> bool:
        before = self._values.get(key)
        return isinstance(before, Condition) and before.level == "FAULT"

    def _send(self, agent: Agent, text: str) -> None:
        if agent.behind() > self._backlog:
            self._say(f"agent {agent.name} did not read {agent.behind()} bytes and is let go")
            self._leave(agent)
            agent.writer.transport.abort()
        else:
            agent.writer.write(text.encode())

    def _leave(self, agent: Agent) -> None:
        with suppress(ValueError):
            self.agents.remove(agent)

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serves one agent, until it goes."""
        address = writer.get_extra_info("peername")
        agent = Agent(writer, f"{address[0]}:{address[1]}" if address else "?")
        if len(self.agents) >= MOST:
            self._say(f"agent {agent.name} is sent away: {MOST} are connected")
            writer.close()
            return
        self.agents.append(agent)
        self._say(f"agent {agent.name} is connected")
        self._send(agent, "".join(lines(self._values, self._since)))
        try:
            while line := await reader.readline():
                if line.split() == [b"*", b"PING"]:
                    self._send(agent, f"* PONG {PING_MS}\n")
        except (OSError, ValueError) as error:  # the second: a line without end
            self._say(f"agent {agent.name}: {type(error).__name__}: {error}")
        finally:
            self._leave(agent)
            writer.transport.abort()
            self._say(f"agent {agent.name} is gone")


def listening(host: str, port: int) -> socket.socket:
    """Opens a socket that listens. Raises MTC-ADDRESS."""
    made = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((host, port))
        made.listen(MOST)
    except OSError as wrong:
        made.close()
        raise Code.MTC_ADDRESS.refusal(
            f"the adapter cannot listen at {host!r}, port {port}: {wrong.strerror or wrong}",
            hint="end what listens there, or choose another by --port or --host",
            values={"host": host, "port": float(port)},
        ) from wrong
    return made


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
    """Watches that a counter goes on counting."""

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
            seen = MachineReport(said["status"], pins, alive(pins.get(HEARTBEAT)), _part(source.part_file))
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
