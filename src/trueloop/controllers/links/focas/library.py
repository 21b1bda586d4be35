"""Fanuc's FOCAS library: loaded from where the user has it, a connection, and its answers in words.

A `long` of FOCAS has four bytes, also in the library for 64-bit Linux. Where one is passed by its address, eight bytes
are there: a library that writes eight does no harm.
"""

import ctypes
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.controllers.links.link import not_reached
from trueloop.errors import Code, TrueloopError

OK: Final = 0
BUSY: Final = -1
BUFFER: Final = 10
"""The control's buffer is full, or empty: the same call again."""
POLL_S: Final = 0.005
ANSWERS: Final = {
    -17: "protocol error", -16: "no connection to its address", -15: "the library for this series is missing",
    -11: "bus error", -10: "system error", -9: "HSSB error", -8: "the connection is lost",
    -7: "library and control differ", -6: "unexpected error", -5: "system error",
    -2: "reset or stopped at the control", -1: "busy", 1: "not prepared, or not known to this control",
    2: "wrong length of data", 3: "no such number", 4: "no such kind of data",
    5: "data refused: no such program, one that is there already, or text that it does not take",
    6: "the control has not this option", 7: "protected against writing", 8: "its memory is full",
    9: "a parameter of it is wrong", 10: "buffer full or empty", 11: "wrong path",
    12: "another mode has to be chosen at the control", 13: "refused now", 14: "data server error",
    15: "an alarm is on", 16: "it is stopped", 17: "protected data",
}  # fmt: skip
"""What EW codes mean, in short."""


def load(path: Path) -> ctypes.CDLL:
    """The library. Raises LNK-LIBRARY where it cannot be loaded."""
    kind: Callable[[str], ctypes.CDLL] = getattr(ctypes, "WinDLL") if sys.platform == "win32" else ctypes.CDLL  # noqa: B009
    try:
        return kind(str(path))
    except OSError as error:
        raise TrueloopError(
            Code.LNK_LIBRARY,
            f"the FOCAS library {str(path)!r} cannot be loaded: {error}",
            hint="it is Fanuc's, and not part of this: name yours as `library` in the settings of the link "
            "(libfwlib32.so, Fwlib32.dll, Fwlib64.dll), of as many bits as this Python",
            values={"where": str(path)},
        ) from error


@dataclass(frozen=True)
class Connection:
    """A control by its handle. Raises LNK-REACH, with what the library answered, for all but OK."""

    library: ctypes.CDLL
    handle: int
    where: str
    timeout_s: float

    def call(self, name: str, *given: Any) -> None:
        """A call that has to succeed; while the control is busy it is repeated, up to `timeout_s`."""
        until = time.monotonic() + self.timeout_s
        while (answer := self.answer(name, *given)) == BUSY and time.monotonic() < until:
            time.sleep(POLL_S)
        if answer != OK:
            raise self.refused(name, answer)

    def answer(self, name: str, *given: Any) -> int:
        """What a call answers."""
        return _function(self.library, name, self.where)(ctypes.c_ushort(self.handle), *given)

    def refused(self, name: str, answer: int) -> TrueloopError:
        """LNK-REACH."""
        return not_reached(self.where, f"{name} answered {answer}: {ANSWERS.get(answer, 'an unknown code')}")

    def moved(self, name: str, room: ctypes.c_int64, data: Any) -> int:
        """Bytes that a call of a transfer carried: `room` is how many there are, then how many were.

        Waits while the control's buffer is full or empty, up to `timeout_s` without a byte.
        """
        until, there = time.monotonic() + self.timeout_s, room.value
        while True:
            room.value = there
            answer = self.answer(name, ctypes.byref(room), data)
            carried = room.value & 0xFFFFFFFF
            if answer not in (OK, BUFFER):
                raise self.refused(name, answer)
            if answer == OK and 0 < carried <= there:
                return carried
            if time.monotonic() > until:
                raise not_reached(self.where, f"{name} carried nothing for {self.timeout_s:g} s")
            time.sleep(POLL_S)


@contextmanager
def connected(library: Path, host: str, port: int, timeout_s: float) -> Iterator[Connection]:
    """A connection for one piece of work, ended after it. Raises LNK-LIBRARY, LNK-REACH."""
    focas, where, handle = load(library), f"focas://{host}:{port}", ctypes.c_ushort()
    _started(focas, where)
    open_ = _function(focas, "cnc_allclibhndl3", where)
    answer = open_(host.encode(), ctypes.c_ushort(port), ctypes.c_int32(max(1, round(timeout_s))), ctypes.byref(handle))
    connection = Connection(focas, handle.value, where, timeout_s)
    if answer != OK:
        raise connection.refused("cnc_allclibhndl3", answer)
    try:
        yield connection
    finally:
        connection.answer("cnc_freelibhndl")


def _started(focas: ctypes.CDLL, where: str) -> None:
    """The library for Linux wants a file for its log before anything else."""
    if hasattr(focas, "cnc_startupprocess"):
        log = str(Path(tempfile.gettempdir()) / "focas.log").encode()
        answer = _function(focas, "cnc_startupprocess", where)(ctypes.c_int32(0), log)
        if answer != OK:
            raise not_reached(where, f"cnc_startupprocess answered {answer}")


def _function(library: ctypes.CDLL, name: str, where: str) -> Callable[..., int]:
    try:
        found = getattr(library, name)
    except AttributeError as error:
        raise TrueloopError(
            Code.LNK_LIBRARY,
            f"the library has no function {name}",
            hint="name Fanuc's FOCAS library as `library` in the settings of the link",
            values={"where": where},
        ) from error
    found.restype = ctypes.c_short
    return found  # type: ignore[no-any-return]
