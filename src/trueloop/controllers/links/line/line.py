"""A control at a serial line: programs go when its operator lets it read, and come when he has it put them out."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Final, Literal

from trueloop.controllers.links.line.codes import LineCode, WireCode, blank, decoded, encoded, leader
from trueloop.controllers.links.line.framing import framed, require_no_end_within
from trueloop.controllers.links.line.port import Parity, Port, broken, open_port
from trueloop.controllers.links.line.transfer import Flow, Pace, receive, send
from trueloop.controllers.links.link import Busy, Listed

LINE_ENDS: Final = {"lf": b"\n", "cr-lf": b"\r\n", "lf-cr-cr": b"\n\r\r"}
LEADER: Final = 50
"""NULs before a program, as a tape had blank feed: a reader that has just started misses some bytes."""


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
    await_xon: bool = True
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

    def busy(self) -> Busy | None:
        """A line does not say."""
        return None

    def read(self, name: str) -> bytes:
        """The program that the control puts out, from `%` to `%`. Raises LNK-LINE, LNK-CODE."""
        with self._open() as port:  # first: opening a port drops what has come
            self.tell(f"have the control put {name} out now; it is waited for {self.silence_s:g} s")
            raw = receive(port, self.port, encoded(b"%", self._wire), self._pace, blank(self._wire))
        return decoded(raw, self._wire) + b"\n"

    def send(self, name: str, content: bytes) -> None:
        """Sends a program between two `%`. Raises LNK-LINE, LNK-CODE before the first byte."""
        text = framed(content)
        require_no_end_within(text)
        raw = leader(self._wire, LEADER) + encoded(text, self._wire, LINE_ENDS[self.line_end])
        with self._open() as port:
            self.tell(f"let the control read now: {name}, {len(raw)} bytes")
            send(port, self.port, raw, self._pace, raw.rindex(encoded(b"%", self._wire)) + 1)

    def feed(self, name: str, content: bytes) -> None:
        """Sends a program that is cut as it comes: from its beginning only. Raises LNK-LINE, LNK-CODE as `send` does.

        What is sent before the control reads is lost, and it would cut from the middle of the program on.
        """
        if self.flow == "none" or (self.flow == "xon-xoff" and not self.await_xon):
            what = f"nothing says when the control begins to read {name!r}: it could begin in mid-program"
            raise broken(self.port, what, 'feed it with `flow = "rts-cts"`, or with "xon-xoff" and `await_xon = true`')
        self.send(name, content)

    @property
    def _wire(self) -> WireCode:
        """Seven bits and their parity are eight bits to the port: we compute and check the eighth."""
        if self.code == "ascii" and self.data_bits == 7 and self.parity != "none":
            return "iso" if self.parity == "even" else "odd"
        return self.code

    @property
    def _bits(self) -> tuple[Literal[7, 8], Parity]:
        """Data bits and parity of the port."""
        return (self.data_bits, self.parity) if self._wire == "ascii" else (8, "none")

    @property
    def _pace(self) -> Pace:
        data_bits, parity = self._bits
        bits = 1 + data_bits + (parity != "none") + self.stop_bits
        starts = self.flow == "xon-xoff" and self.await_xon
        return Pace(self.flow, bits / self.baud, self.after_xoff, self.silence_s, starts)

    def _open(self) -> AbstractContextManager[Port]:
        return open_port(self.port, self.baud, *self._bits, self.stop_bits)
