"""The adapter: agents connect by TCP, are told all there is and then what changes. One that does not read is let go."""

import asyncio
import socket
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

from trueloop.controllers.mtconnect.items import Condition, Value, lines
from trueloop.errors import Code, TrueloopError

PORT: Final = 7878
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
    """What was last said of each key, and those who are told. Nothing here ever waits for an agent."""

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
        raise TrueloopError(
            Code.MTC_ADDRESS,
            f"the adapter cannot listen at {host!r}, port {port}: {wrong.strerror or wrong}",
            hint="end what listens there, or choose another by --port or --host",
            values={"host": host, "port": float(port)},
        ) from wrong
    return made
