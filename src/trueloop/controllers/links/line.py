"""Controls at a serial line: characters, the port, and programs over it."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol

from trueloop.controllers.links.folder import LARGEST, Busy, ListedProgram
from trueloop.errors import Code, TrueloopError
from trueloop.extras import install_command

LineCode = Literal["ascii", "iso", "eia"]
WireCode = Literal["ascii", "iso", "odd", "eia"]
"""How characters stand on the line; iso and odd: seven bits, and an eighth for an even or an odd number."""
EIA: Final[Mapping[str, int]] = {
    **dict(zip("1234567890", bytes.fromhex("01021304151607081920"), strict=True)),
    **dict(zip("ABCDEFGHI", bytes.fromhex("616273647576676879"), strict=True)),
    **dict(zip("JKLMNOPQR", bytes.fromhex("515243544546575849"), strict=True)),
    **dict(zip("STUVWXYZ", bytes.fromhex("3223342526373829"), strict=True)),
    **dict(zip(" .,/+-&()\t%\n", bytes.fromhex("106b3b3170400e1a4a3e0b80"), strict=True)),
}
"""By what it stands for; `%` is EIA's end of record, a line feed its end of block."""
_FROM_EIA: Final = {byte: character for character, byte in EIA.items()}
_SKIPPED: Final[Mapping[WireCode, bytes]] = {
    "ascii": b"\x00\x7f\x11\x12\x13\x14\r",
    "iso": b"\x00\xff\x11\x12\x93\x14\x8d",
    "odd": b"\x00\x80\x7f\x91\x92\x13\x94\r",
    "eia": b"\x00\x7f\x11\x12\x14",
}
"""Bytes without content: leader, rubbed-out characters, device controls, carriage returns."""


def encoded(text: bytes, code: WireCode, line_end: bytes = b"\r\n") -> bytes:
    """Encodes an ASCII program for the line. Raises LNK-CODE for a character that the code does not have."""
    line, column = 1, 0
    out = bytearray()
    for character in text.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n"):
        column += 1
        byte = _byte(character, code, line_end)
        if byte is None:
            raise wrong(f"{character!r} cannot be sent in {_NAMES[code]}", line, column)
        out += byte
        if character == "\n":
            line, column = line + 1, 0
    return bytes(out)


def decoded(raw: bytes, code: WireCode) -> bytes:
    """Decodes what came over the line to ASCII, line ends LF. Raises LNK-CODE for a byte that is not a character."""
    out = bytearray()
    for byte in raw:
        if byte in _SKIPPED[code]:
            continue
        character = _character(byte, code)
        if character is None:
            line, column = out.count(b"\n") + 1, len(out) - (out.rfind(b"\n") + 1) + 1
            raise wrong(f"the byte 0x{byte:02X} is no character of {_NAMES[code]}", line, column)
        out += character.encode("ascii")
    return bytes(out)


def blank(code: WireCode) -> bytes:
    """Returns the bytes that stand between two programs: leader, rubbed-out characters, device controls, line ends."""
    return _SKIPPED[code] + encoded(b"\n", code, b"\n")


def leader(code: WireCode, count: int) -> bytes:
    """Returns so many characters NUL, blank tape."""
    return bytes(count) if code != "odd" else b"\x80" * count


_NAMES: Final[Mapping[WireCode, str]] = {
    "ascii": "ASCII",
    "iso": "seven bits with even parity (ISO)",
    "odd": "seven bits with odd parity",
    "eia": "EIA code",
}


def _byte(character: str, code: WireCode, line_end: bytes) -> bytes | None:
    if code == "eia":
        byte = EIA.get(character.upper())
        return None if byte is None else bytes([byte])
    if not (character in "\t\n" or " " <= character <= "~"):
        return None
    plain = line_end if character == "\n" else character.encode("ascii")
    return plain if code == "ascii" else bytes(_with_parity(byte, code) for byte in plain)


def _character(byte: int, code: WireCode) -> str | None:
    if code == "eia":
        return _FROM_EIA.get(byte)
    if code != "ascii" and byte != _with_parity(byte & 0x7F, code):
        return None
    character = chr(byte if code == "ascii" else byte & 0x7F)
    return character if character in "\t\n" or " " <= character <= "~" else None


def _with_parity(byte: int, code: WireCode) -> int:
    return byte | 0x80 if byte.bit_count() % 2 == (code == "iso") else byte


def wrong(what: str, line: int, column: int) -> TrueloopError:
    """Returns the error LNK-CODE."""
    return Code.LNK_CODE.refusal(
        f"line {line}, column {column}: {what}",
        hint="compare `code`, `baud` and `parity` in the link's table [serial.NAME] with those of the control",
        values={"line": line, "column": column},
    )


def framed(content: bytes) -> bytes:
    """Frames a program between `%` and `%`, with line feeds."""
    lines = list(_lines(content))
    return b"\n".join([b"%", *lines, b"%", b""])


def require_no_end_within(text: bytes) -> None:
    """Raises LNK-CODE for a `%` of a framed text that is neither the first nor the last: it would end there."""
    for k, line in enumerate(text.split(b"\n")[1:-2], 1):
        if b"%" in line:
            raise wrong("'%' within a program ends it for the control", k, line.index(b"%") + 1)


def _lines(content: bytes) -> Iterator[bytes]:
    """Its lines without the `%` around them."""
    lines = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").strip(b"\n").split(b"\n")
    first = 1 if lines[0].strip() == b"%" else 0
    last = len(lines) - 1 if len(lines) > first and lines[-1].strip() == b"%" else len(lines)
    yield from lines[first:last]


Parity = Literal["none", "even", "odd"]
WRITE_S: Final = 10.0
_PORT_LOOK_S: Final = 0.001


class Port(Protocol):
    """An open port. Its methods raise OSError where the port is gone."""

    def now(self) -> float:
        """Seconds; it never goes back."""

    def write(self, piece: bytes) -> None:
        """Hands bytes to the line."""

    def read(self, wait_s: float) -> bytes:
        """Returns what has come; waits so long for a first byte, and not at all where there is one."""

    def clear(self) -> bool:
        """Returns whether the control's line CTS lets us send."""


@dataclass(frozen=True)
class SerialPort:
    """A port of this computer by pyserial."""

    device: Any

    def now(self) -> float:
        """Returns the time of the computer's steady clock, s."""
        return time.monotonic()

    def write(self, piece: bytes) -> None:
        """Returns when the computer's own buffer is empty: what is under way is in no queue of ours.

        Raises TimeoutError, an OSError, where the port does not take it. (`flush` would wait without end.)
        """
        self.device.write(piece)
        until = self.now() + WRITE_S
        while self.device.out_waiting:
            if self.now() > until:
                raise TimeoutError(f"the port has not taken {len(piece)} bytes in {WRITE_S:g} s")
            time.sleep(_PORT_LOOK_S)

    def read(self, wait_s: float) -> bytes:
        """Returns whatever there is, else the first byte within the time."""
        self.device.timeout = wait_s
        first: bytes = self.device.read(1)
        return first + self.device.read(self.device.in_waiting) if first else b""

    def clear(self) -> bool:
        """Returns whether CTS is set."""
        return bool(self.device.cts)


@contextmanager
def open_port(name: str, baud: int, data_bits: int, parity: Parity, stop_bits: int) -> Iterator[SerialPort]:
    """Opens the port exclusively and closes it at the end, without the system's own flow control. Raises LNK-LINE."""
    serial = _pyserial(name)
    letter = {"none": "N", "even": "E", "odd": "O"}[parity]
    try:
        device = serial.Serial(name, baud, data_bits, letter, stop_bits, write_timeout=WRITE_S, exclusive=True)
    except Exception as error:  # what the system says comes through by a type of its own
        raise broken(name, f"cannot be opened: {error}", "see that the cable is in and the name right") from error
    try:
        yield SerialPort(device)
    finally:
        device.close()


def broken(where: str, text: str, hint: str) -> TrueloopError:
    """Returns the error LNK-LINE."""
    return Code.LNK_LINE.refusal(f"{where}: {text}", hint=hint, values={"where": where})


def _pyserial(name: str) -> Any:
    try:
        import serial
    except ImportError:
        raise broken(
            name, "serial lines need the package 'pyserial'", f"install it: {install_command('realtime')}"
        ) from None
    return serial


Flow = Literal["xon-xoff", "rts-cts", "none"]
XON: Final = (0x11, 0x91)  # without and with the parity of the ISO code
XOFF: Final = (0x13, 0x93)
QUIET: Final = (0x00, 0x80, 0x12, 0x92, 0x14, 0x94)
"""Leader and the device controls by which a control starts and stops a reader or a punch: they ask nothing of us."""
_TRAVEL: Final = 2
"""Characters that pass while an XOFF is on its way to us."""
_LOOK_S: Final = 0.05


@dataclass(frozen=True)
class Pace:
    """`character_s` a character takes on the line; `after_xoff` characters that the control takes after its XOFF;
    `silence_s` that it may hold us or say nothing; `starts`: it says XON when it begins to read.
    """

    flow: Flow
    character_s: float
    after_xoff: int = 10
    silence_s: float = 60.0
    starts: bool = False

    @property
    def piece(self) -> int:
        """Characters written at once."""
        return max(1, self.after_xoff - _TRAVEL)


def send(port: Port, where: str, raw: bytes, pace: Pace, needed: int | None = None) -> None:
    """Sends all of it, once the control begins to read. What follows `needed` bytes is left out where the control holds
    us then: many say XOFF as soon as they have read the last `%`, and nothing more.

    Raises LNK-LINE where the control holds us too long, answers something else, or the port is gone.
    """
    sent, held, needed = 0, False, len(raw) if needed is None else needed
    try:
        if pace.starts:
            _started(port, where, pace, len(raw))
        since = port.now()
        while sent < len(raw):
            held = _held(port, where, held, 0.0, sent, len(raw))
            if held or (pace.flow == "rts-cts" and not port.clear()):
                if sent >= needed:
                    return
                _require_time(port, where, since, pace, f"holds us after {sent} of {len(raw)} bytes")
                held = _held(port, where, held, _LOOK_S, sent, len(raw))
                continue
            piece = raw[sent : min(sent + pace.piece, needed if sent < needed else len(raw))]
            port.write(piece)
            sent += len(piece)
            since = port.now()
            held = _carried(port, where, held, since + len(piece) * pace.character_s, sent, len(raw))
    except OSError as error:
        raise broken(where, f"the line broke after {sent} of {len(raw)} bytes: {error}", _PARTS) from error


def receive(port: Port, where: str, end: bytes, pace: Pace, blank: bytes = b"") -> bytes:
    """Receives from the control's first `end` character to the next, both included. Raises LNK-LINE.

    `end` is what begins and ends a program, `%`, as the line carries it. Of two programs sent on end the first comes
    that comes whole: between the end of one and the beginning of the next are only bytes of `blank`.
    """
    came = bytearray()
    try:
        since = port.now()
        while not (found := _program(came, end, blank)):
            piece = port.read(_LOOK_S)
            if piece:
                came, since = came + piece, port.now()
            elif port.now() - since > pace.silence_s:
                raise broken(where, f"silent for {pace.silence_s:g} s after {len(came)} bytes, no end came", _PUT_OUT)
            if len(came) > LARGEST:
                raise broken(where, f"sent more than {LARGEST} bytes without an end", _PUT_OUT)
    except OSError as error:
        raise broken(where, f"the line broke after {len(came)} bytes: {error}", _PUT_OUT) from error
    return found


_PARTS: Final = "the control may hold a part of the program: delete it there, see to the cable, send it again"
_NO_XON: Final = "let the control read after the command was given; does it never say XON: `await_xon = false`"
_PUT_OUT: Final = "see to the cable, then have the control put the program out again"


def _program(came: bytearray, end: bytes, blank: bytes) -> bytes:
    """The first program that came whole; empty: none yet. What has nothing in it was the gap between two programs."""
    first = came.find(end)
    while first >= 0 and (last := came.find(end, first + 1)) >= 0:
        if came[first + 1 : last].strip(blank):
            return bytes(came[first : last + 1])
        first = last
    return b""


def _started(port: Port, where: str, pace: Pace, of: int) -> None:
    """Waits for the control's XON: what is sent before it reads is lost, and it would begin in mid-program."""
    since = port.now()
    while not any(byte in XON for byte in port.read(_LOOK_S)):
        _require_time(port, where, since, pace, f"no XON came, none of {of} bytes was sent", _NO_XON)


def _carried(port: Port, where: str, held: bool, until: float, sent: int, of: int) -> bool:
    """Waits until the line has carried what was written; whether the control holds us then."""
    while (left := until - port.now()) > 0:
        held = _held(port, where, held, left, sent, of)
    return held


def _held(port: Port, where: str, held: bool, wait_s: float, sent: int, of: int) -> bool:
    for byte in port.read(wait_s):
        if byte in XOFF:
            held = True
        elif byte in XON:
            held = False
        elif byte not in QUIET:
            raise broken(where, f"answered 0x{byte:02X} after {sent} of {of} bytes, no flow control", _PARTS)
    return held


def _require_time(port: Port, where: str, since: float, pace: Pace, text: str, hint: str = _PARTS) -> None:
    if port.now() - since > pace.silence_s:
        raise broken(where, f"{text}, for {pace.silence_s:g} s", hint)


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
        """Returns the port."""
        return self.port

    @property
    def note(self) -> str:
        """Warns that a line carries characters, not files."""
        return f"{self.port}: a serial line knows neither names nor what runs: look at the control"

    def listed(self) -> list[ListedProgram]:
        """Raises LNK-LINE: a line has no list."""
        raise broken(self.port, "a serial line has no list of programs", "look at the control's own list")

    def busy(self) -> Busy | None:
        """Returns None: a line does not report what runs."""
        return None

    def read(self, name: str) -> bytes:
        """Reads the program that the control puts out, from `%` to `%`. Raises LNK-LINE, LNK-CODE."""
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
