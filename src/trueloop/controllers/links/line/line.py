"""A control at a serial line: programs go when its operator lets it read, and come when he has it put them out."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Final, Literal

from trueloop.controllers.links.line.codes import LineCode, decoded, encoded
from trueloop.controllers.links.line.port import Parity, Port, broken, open_port
from trueloop.controllers.links.line.transfer import Flow, Pace, receive, send
from trueloop.controllers.links.link import Listed

LINE_ENDS: Final = {"lf": b"\n", "cr-lf": b"\r\n", "lf-cr-cr": b"\n\r\r"}
LEADER: Final = bytes(50)
"""NULs before and after a program, as a tape had blank feed: a reader that has just started misses some bytes."""


@dataclass(frozen=True)
class Line:
    """`port` by its name (/dev/ttyUSB0, COM3). `tell` says to the person at the control what is to be done there."""

    port: str
    baud: int = 9600
    data_bits: Literal[7, 8] = 7
    parity: Parity = "even"
    stop_bits: Literal[1, 2] = 2
    flow: Flow = "xon-xoff"
    code: LineCode = "ascii"
    line_end: Literal["lf", "cr-lf", "lf-cr-cr"] = "cr-lf"
    after_xoff: int = 10
    silence_s: float = 60.0
    tell: Callable[[str], None] = print

    @property
    def where(self) -> str:
        """The port."""
        return self.port

    @property
    def note(self) -> str:
        """A line carries characters, not files."""
        return f"{self.port}: a serial line knows neither names nor what runs: look at the control"

    def listed(self) -> list[Listed]:
        """Raises LNK-LINE: a line has no list."""
        raise broken(self.port, "a serial line has no list of programs", "look at the control's own list")

    def running(self) -> str | None:
        """A line does not say."""
        return None

    def read(self, name: str) -> bytes:
        """The program that the control puts out, from `%` to `%`. Raises LNK-LINE, LNK-CODE."""
        with self._open() as port:  # first: opening a port drops what has come
            self.tell(f"have the control put {name} out now; it is waited for {self.silence_s:g} s")
            raw = receive(port, self.port, encoded(b"%", self.code), self._pace)
        return decoded(raw, self.code) + b"\n"

    def send(self, name: str, content: bytes) -> None:
        """Sends a program between two `%`. Raises LNK-LINE, LNK-CODE before the first byte."""
        raw = LEADER + encoded(framed(content), self.code, LINE_ENDS[self.line_end]) + LEADER
        with self._open() as port:
            self.tell(f"let the control read now: {name}, {len(raw)} bytes")
            send(port, self.port, raw, self._pace)

    @property
    def _pace(self) -> Pace:
        bits = 1 + self.data_bits + (self.parity != "none") + self.stop_bits
        return Pace(self.flow, bits / self.baud, self.after_xoff, self.silence_s)

    def _open(self) -> AbstractContextManager[Port]:
        return open_port(self.port, self.baud, self.data_bits, self.parity, self.stop_bits)


def framed(content: bytes) -> bytes:
    """A program between `%` and `%`, by which a control knows its beginning and its end."""
    lines = list(_lines(content))
    return b"\n".join([b"%", *lines, b"%", b""])


def _lines(content: bytes) -> Iterator[bytes]:
    """Its lines without the `%` around them."""
    lines = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").strip(b"\n").split(b"\n")
    first = 1 if lines[0].strip() == b"%" else 0
    last = len(lines) - 1 if len(lines) > first and lines[-1].strip() == b"%" else len(lines)
    yield from lines[first:last]
