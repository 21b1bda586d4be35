"""A control at the other end of a serial line, in time of its own: buffer, flow control, memory, and what goes wrong.

Written from the tables of the standards, not from the code under test: EIA by its zones and digits, parity counted.
"""

import random
from collections import deque
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import Literal

from trueloop.controllers.links.line import Line, Port

Fault = Literal["none", "nul", "held for ever", "cut sending", "cut receiving", "answers", "noise", "edited"]
FAULTS: tuple[Fault, ...] = (
    *("none", "nul", "held for ever", "cut sending", "cut receiving", "answers", "noise", "edited"),
)
BUFFER = 256
RESUMES = 64
ZONES = {"ABCDEFGHI": (0x60, 1), "JKLMNOPQR": (0x40, 1), "STUVWXYZ": (0x20, 2), "123456789": (0x00, 1)}
SIGNS = {"0": 0x20, " ": 0x10, ".": 0x6B, "-": 0x40, "+": 0x70, "/": 0x31, "(": 0x1A, ")": 0x4A, "%": 0x0B, "\n": 0x80}


def eia(character: str) -> int:
    """A zone, a digit, and channel 5 for an odd number of holes."""
    for letters, (zone, first) in ZONES.items():
        if character in letters:
            byte = zone | (first + letters.index(character))
            return byte if bin(byte).count("1") % 2 else byte | 0x10
    return SIGNS[character]


def iso(character: str) -> int:
    """Seven bits and one that makes their number even."""
    return ord(character) | (0x80 if bin(ord(character)).count("1") % 2 else 0)


FROM_EIA = {eia(one): one for one in "".join(ZONES) + "".join(SIGNS)}


@dataclass
class SerialControl:
    """A control with a memory for one program, and the line to it. `after` counts what came after each XOFF, `early`
    what came before it began to read. It stops the reader (XOFF, RTS off) as soon as it has read the second %.
    """

    code: Literal["ascii", "iso", "eia"]
    flow: Literal["xon-xoff", "rts-cts"]
    character_s: float
    after_xoff: int
    seed: int
    fault: Fault = "none"
    memory: str | None = None
    lost: int = 0
    after: int = 0
    most_after: int = 0
    early: int = 0
    time: float = 0.0
    buffer: deque[int] = field(default_factory=deque)
    coming: deque[tuple[float, int]] = field(default_factory=deque)
    going: deque[tuple[float, int]] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self.drawn = random.Random(self.seed)
        self.holding, self.read_bytes, self.raw = True, 0, list[int]()
        self.reads_from, self.reading = float("inf"), False
        self.fault_at = self.drawn.randrange(60, 160)  # bytes: within any of the programs
        self.busy_until = 0.0

    # the port, as the computer sees it

    def now(self) -> float:
        """The line's time."""
        return self.time

    def write(self, piece: bytes) -> None:
        """Characters leave one after the other."""
        begin = max(self.time, self.coming[-1][0] if self.coming else self.time)
        self.coming.extend((begin + (k + 1) * self.character_s, byte) for k, byte in enumerate(piece))

    def read(self, wait_s: float) -> bytes:
        """Time passes until something has come."""
        until = self.time + wait_s
        while not (self.going and self.going[0][0] <= self.time) and self.time < until:
            self._pass(min(until, self.time + self.character_s))
        came = bytearray()
        while self.going and self.going[0][0] <= self.time:
            came.append(self.going.popleft()[1])
        return bytes(came)

    def clear(self) -> bool:
        """Its line RTS is our CTS."""
        return not self.holding

    # the control itself

    def let_read(self) -> None:
        """Its operator lets it read, after a while. What came before is lost."""
        self.reads_from = self.time + self.drawn.uniform(0.0, 5.0)

    def put_out(self) -> None:
        """Its operator has it put the program out."""
        until = self.time + 60.0
        while (self.coming or self.buffer) and self.time < until:  # he waits for what is still being read
            self._pass(self.time + 0.01)
        encode = {"eia": eia, "iso": iso, "ascii": ord}[self.code]
        text = self.memory if self.memory is not None else ""
        if self.fault == "edited":
            text = text.replace("X", "Z", 1)
        body = [encode(one) for one in text]
        if self.fault == "noise" and body:
            body[self.drawn.randrange(1, len(body) - 2)] ^= 1 << self.drawn.randrange(8)
        if self.fault == "cut receiving":
            body = body[: self.drawn.randrange(len(body))]
        nuls = [0] * (self.drawn.randrange(40) if self.fault == "nul" else 3)
        sent = [*nuls, 0x12, *body, *([] if self.fault == "cut receiving" else [0x14])] if body else []
        begin = self.time + self.drawn.uniform(0.1, 2.0)
        self.going.extend((begin + k * self.character_s, byte) for k, byte in enumerate(sent))

    def _pass(self, until: float) -> None:
        self.time = until
        if self.time >= self.reads_from:
            self.reading, self.reads_from = True, float("inf")
            self._hold(False)
        while self.coming and self.coming[0][0] <= self.time:
            self._take(self.coming.popleft()[1])
        self._work()

    def _take(self, byte: int) -> None:
        self.read_bytes += 1
        if not self.reading:
            self.early += not self.read_bytes
            return
        if self.fault == "cut sending" and self.read_bytes > self.fault_at:
            return
        if self.fault == "answers" and self.read_bytes == self.fault_at:
            self.going.append((self.time + self.character_s, 0x07))
        if len(self.buffer) >= BUFFER:
            self.lost += 1
            return
        self.buffer.append(byte)
        if self.holding:
            self.after += 1
            self.most_after = max(self.most_after, self.after)
        elif len(self.buffer) >= BUFFER - self.after_xoff or self._forever():
            self._hold(True)

    def _forever(self) -> bool:
        return self.fault == "held for ever" and self.read_bytes >= self.fault_at

    def _work(self) -> None:
        """Reads its buffer in bursts, and does something else between them."""
        if self.time >= self.busy_until and not self._forever():
            for _ in range(self.drawn.randrange(1, 120)):
                if self.buffer:
                    self._keep(self.buffer.popleft())
            self.busy_until = self.time + self.drawn.choice((0.0, 0.01, 0.2, 1.5))
        if self.reading and self.holding and len(self.buffer) <= RESUMES and not self._forever():
            self._hold(False)

    def _hold(self, holding: bool) -> None:
        self.holding, self.after = holding, 0
        if self.flow == "xon-xoff":
            sign = 0x13 if holding else 0x11
            self.going.append((self.time + self.character_s, iso(chr(sign)) if self.code == "iso" else sign))

    def _keep(self, byte: int) -> None:
        """A program is in its memory when its second % has come; before that there is none."""
        self.raw.append(byte)
        if byte not in (ord("%"), iso("%"), eia("%")):
            return
        text = "".join(FROM_EIA.get(one, "") if self.code == "eia" else chr(one & 0x7F) for one in self.raw)
        text = text.replace("\0", "").replace("\r", "")
        if text.count("%") == 2:
            self.memory = text[text.index("%") : text.rindex("%") + 1] + "\n"
            self.raw.clear()
            self.reading = False  # the reader is stopped at the end of the program
            self.buffer.clear()
            self._hold(True)


@dataclass(frozen=True)
class VirtualLine(Line):
    """The link under test with this control at its end."""

    control: SerialControl | None = None

    def _open(self) -> AbstractContextManager[Port]:
        assert self.control is not None
        return nullcontext(self.control)
