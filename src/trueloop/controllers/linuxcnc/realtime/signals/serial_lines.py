"""Sensors that send lines of text at a serial port, or answer a question with one."""

import re
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from trueloop.controllers.linuxcnc.realtime.signals.readings import Intake
from trueloop.errors import Code, TrueloopError
from trueloop.extras import install_command

LONGEST_LINE: Final = 4096
WAIT_S: Final = 0.5


@dataclass(frozen=True)
class LinePart:
    """Where in a line a signal's number is: the first group of a pattern, or column 1, 2, … between separators."""

    pattern: re.Pattern[str] | None = None
    column: int = 1
    separator: str = ","

    def value(self, line: str) -> float | None:
        """Returns the number; None where the line holds none there."""
        with suppress(ValueError, IndexError):
            return float(self._text(line).strip())
        return None

    def _text(self, line: str) -> str:
        if self.pattern is None:
            return line.split(self.separator)[self.column - 1]
        found = self.pattern.search(line)
        return found[1] or "" if found else ""


@dataclass(frozen=True)
class SerialLines:
    """One port. `ask` is sent every `every_s` where the device speaks only when asked."""

    port: str
    baud: int
    parts: Mapping[str, LinePart]
    ask: str = ""
    every_s: float = 1.0

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads until the end. Raises `OSError` where the port cannot be opened or goes away."""
        opened = pyserial().Serial(self.port, self.baud, timeout=WAIT_S, write_timeout=WAIT_S, exclusive=True)
        try:
            with opened as port:
                self._read(port, intake, stop)
        except _port_error() as error:
            raise OSError(f"{self.port} went away: {error}") from error

    def _read(self, port: Any, intake: Intake, stop: threading.Event) -> None:
        """The first line may have begun before the port was opened: half of a number is a number too."""
        held, skip, asked_s = b"", not self.ask, -self.every_s
        port.reset_input_buffer()
        while not stop.is_set():
            if self.ask and time.monotonic() - asked_s >= self.every_s:
                asked_s = time.monotonic()
                port.write(self.ask.encode())
            *lines, held = re.split(b"[\r\n]+", held + port.read(port.in_waiting or 1))
            for line in lines[1:] if skip else lines:
                self._take(line, intake)
            skip = skip and not lines
            if len(held) > LONGEST_LINE:
                held, skip = b"", True

    def _take(self, line: bytes, intake: Intake) -> None:
        text, now_s = line.decode("ascii", "replace"), time.monotonic()
        for name, part in self.parts.items():
            if (value := part.value(text)) is not None:
                intake.put(name, value, now_s)


def _port_error() -> type[Exception]:
    """Returns what a read raises where the device was unplugged; of termios it is not an OSError."""
    if sys.platform == "win32":
        return OSError
    import termios

    return termios.error


def pyserial() -> Any:
    """Imports the package. Raises RTC-SOURCE where it is not installed."""
    try:
        import serial
    except ImportError as missing:
        raise not_installed("a serial port", missing) from None
    return serial


def not_installed(what: str, missing: ImportError) -> TrueloopError:
    """Makes the refusal of a source whose package is not there."""
    return Code.RTC_SOURCE.refusal(
        f"{what} needs a package that cannot be loaded: {str(missing)!r}", hint=install_command("realtime")
    )
