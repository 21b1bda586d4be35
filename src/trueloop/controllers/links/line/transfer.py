"""Bytes to and from a control at a serial line, within what it takes; every wait ends in an error that says how far.

While the control holds us (XOFF, or CTS off) nothing is written. A piece is at most as long as what the control still
takes after its XOFF, and the next one is written only when the line has had the time to carry it: no more is under way.
"""

from dataclasses import dataclass
from typing import Final, Literal

from trueloop.controllers.links.line.port import Port, broken
from trueloop.controllers.links.link import LARGEST

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
    """All of it, once the control begins to read. What comes after `needed` bytes is left out where the control holds
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
    """What the control sends, from its first `end` character to the next, both among it. Raises LNK-LINE.

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


def _require_time(port: Port, where: str, since: float, pace: Pace, said: str, hint: str = _PARTS) -> None:
    if port.now() - since > pace.silence_s:
        raise broken(where, f"{said}, for {pace.silence_s:g} s", hint)
