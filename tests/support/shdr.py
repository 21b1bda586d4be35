"""An agent's side of SHDR, written from its description: connects, asks PING, takes lines apart, keeps the latest.

`time|key|value[|key|value…]`; a condition has six fields behind its time: key, level, native code, severity, qualifier,
text. A field that begins with a quote ends with one, and in it `\\|` is a bar. Which keys are conditions an agent knows
from the device model.
"""

import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from xml.etree import ElementTree

from tests.support.signals import until

STAMP = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?Z")


def fields(line: str) -> list[str]:
    """Character by character."""
    found, current, quoted, k = list[str](), "", False, 0
    while k < len(line):
        if quoted and line.startswith("\\|", k):
            current, k = current + "|", k + 1
        elif line[k] == '"' and (quoted or not current):
            quoted = not quoted
        elif line[k] == "|" and not quoted:
            found.append(current)
            current = ""
        else:
            current += line[k]
        k += 1
    assert not quoted, f"a quote is left open: {line!r}"
    return [*found, current]


def model(devices: bytes) -> dict[str, str]:
    """Category by id of all data items of a device model."""
    root = ElementTree.fromstring(devices)
    items = [one.attrib for one in root.iter() if one.tag.rpartition("}")[2] == "DataItem"]
    ids = [one.attrib["id"] for one in root.iter() if "id" in one.attrib]
    assert len(ids) == len(set(ids)), "ids in XML are each there once"
    return {one["id"]: one["category"] for one in items}


@dataclass
class ShdrAgent:
    """One connection."""

    categories: dict[str, str]
    connection: socket.socket
    seen: list[tuple[str, str, str]] = field(default_factory=list)
    """Time, key, value; of a condition `LEVEL code text`."""
    pongs: list[int] = field(default_factory=list)
    ended: bool = False

    def listen(self) -> None:
        """Until the adapter closes."""
        with self.connection.makefile("r", encoding="utf-8", newline="\n") as lines:
            try:
                for line in lines:
                    self.take(line.removesuffix("\n"))
            except OSError:
                pass
        self.ended = True

    def take(self, line: str) -> None:
        if line.startswith("* PONG "):
            self.pongs.append(int(line.split()[2]))
            return
        stamp, *rest = fields(line)
        assert STAMP.fullmatch(stamp), line
        if self.categories[rest[0]] == "CONDITION":
            assert len(rest) == 6, line
            self.seen.append((stamp, rest[0], " ".join(filter(None, (rest[1], rest[2], rest[5])))))
            return
        assert len(rest) % 2 == 0, line
        for key, value in zip(rest[::2], rest[1::2], strict=True):
            assert self.categories[key] in ("EVENT", "SAMPLE"), line
            self.seen.append((stamp, key, value))

    def latest(self) -> dict[str, str]:
        return {key: value for _, key, value in list(self.seen)}

    def wait_for(self, key: str, value: str) -> None:
        until(lambda: self.latest().get(key) == value)

    def ping(self) -> None:
        before = len(self.pongs)
        self.connection.sendall(b"* PING\n")
        until(lambda: len(self.pongs) > before)


@contextmanager
def connected(port: int, devices: bytes) -> Iterator[ShdrAgent]:
    with socket.create_connection(("127.0.0.1", port), timeout=60) as connection:
        agent = ShdrAgent(model(devices), connection)
        thread = threading.Thread(target=agent.listen, daemon=True)
        thread.start()
        yield agent
        connection.shutdown(socket.SHUT_RDWR)
        thread.join(10)
