"""A serial port: what a transfer asks of one, and the computer's own."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol

from trueloop.errors import Code, TrueloopError
from trueloop.extras import install_command

Parity = Literal["none", "even", "odd"]
WRITE_S: Final = 10.0
_LOOK_S: Final = 0.001


class Port(Protocol):
    """An open port. Its methods raise OSError where the port is gone."""

    def now(self) -> float:
        """Seconds; it never goes back."""

    def write(self, piece: bytes) -> None:
        """Hands bytes to the line."""

    def read(self, wait_s: float) -> bytes:
        """What has come; waits so long for a first byte, and not at all where there is one."""

    def clear(self) -> bool:
        """Whether the control's line CTS lets us send."""


@dataclass(frozen=True)
class SerialPort:
    """A port of this computer by pyserial."""

    device: Any

    def now(self) -> float:
        """The computer's steady clock."""
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
            time.sleep(_LOOK_S)

    def read(self, wait_s: float) -> bytes:
        """Whatever there is, else the first byte within the time."""
        self.device.timeout = wait_s
        first: bytes = self.device.read(1)
        return first + self.device.read(self.device.in_waiting) if first else b""

    def clear(self) -> bool:
        """CTS."""
        return bool(self.device.cts)


@contextmanager
def open_port(name: str, baud: int, data_bits: int, parity: Parity, stop_bits: int) -> Iterator[SerialPort]:
    """The port, for us alone, closed at the end; nothing of the system's own flow control is used. Raises LNK-LINE."""
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


def broken(where: str, said: str, hint: str) -> TrueloopError:
    """LNK-LINE."""
    return TrueloopError(Code.LNK_LINE, f"{where}: {said}", hint=hint, values={"where": where})


def _pyserial(name: str) -> Any:
    try:
        import serial
    except ImportError:
        raise broken(
            name, "serial lines need the package 'pyserial'", f"install it: {install_command('realtime')}"
        ) from None
    return serial
