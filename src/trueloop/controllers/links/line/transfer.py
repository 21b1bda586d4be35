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
QUIET: Final = (0x00, 0x12, 0x92, 0x14, 0x94)
"""Leader and the device controls by which a control starts and stops a reader or a punch: they ask nothing of us."""
_TRAVEL: Final = 2
"""Characters that pass while an XOFF is on its way to us."""
_LOOK_S: Final = 0.05


@dataclass(frozen=True)
class Pace:
    """`character_s` a character takes on the line; `after_xoff` characters that the control takes after its XOFF;
    `silence_s` that it may hold us or say nothing.
    """

    flow: Flow
    character_s: float
    after_xoff: int = 10
    silence_s: float = 60.0

    @property
    def piece(self) -> int:
        """Characters written at once."""
        return max(1, self.after_xoff - _TRAVEL)


def send(port: Port, where: str, raw: bytes, pace: Pace) -> None:
    """All of it. Raises LNK-LINE where the control holds us too long, answers something else, or the port is gone."""
    sent, held = 0, False
    try:
        since = port.now()
        while sent < len(raw):
            held = _held(port, where, held, 0.0, sent, len(raw))
            if held or (pace.flow == "rts-cts" and not port.clear()):
                _require_time(port, where, since, pace, f"holds us after {sent} of {len(raw)} bytes")
                held = _held(port, where, held, _LOOK_S, sent, len(raw))
                continue
            piece = raw[sent : sent + pace.piece]
            port.write(piece)
            sent += len(piece)
            since = port.now()
            held = _carried(port, where, held, since + len(piece) * pace.character_s, sent, len(raw))
    except OSError as error:
        raise broken(where, f"the line broke after {sent} of {len(raw)} bytes: {error}", _PARTS) from error


def receive(port: Port, where: str, end: bytes, pace: Pace) -> bytes:
    """What the control sends, from its first `end` character to the next, both among it. Raises LNK-LINE.

    `end` is what begins and ends a program, `%`, as the line carries it. Of two programs sent on end the first comes.
    """
    came = bytearray()
    try:
        since = port.now()
        while not _complete(came, end):
            piece = port.read(_LOOK_S)
            if piece:
                came, since = came + piece, port.now()
            elif port.now() - since > pace.silence_s:
                raise broken(where, f"silent for {pace.silence_s:g} s after {len(came)} bytes, no end came", _PUT_OUT)
            if len(came) > LARGEST:
                raise broken(where, f"sent more than {LARGEST} bytes without an end", _PUT_OUT)
    except OSError as error:
        raise broken(where, f"the line broke after {len(came)} bytes: {error}", _PUT_OUT) from error
    first = came.index(end)
    return bytes(came[first : came.index(end, first + 1) + 1])


_PARTS: Final = "the control may hold a part of the program: delete it there, see to the cable, send it again"
_PUT_OUT: Final = "see to the cable, then have the control put the program out again"


def _complete(came: bytearray, end: bytes) -> bool:
    """Whether a program came whole: its end is not the first thing after its beginning."""
    first = came.find(end)
    return first >= 0 and came.find(end, first + 1) > 0


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


def _require_time(port: Port, where: str, since: float, pace: Pace, said: str) -> None:
    if port.now() - since > pace.silence_s:
        raise broken(where, f"{said}, for {pace.silence_s:g} s", _PARTS)
