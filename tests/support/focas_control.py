"""The stand-in for a Fanuc control and its library (`focas_control.c`), compiled, and what a person sees at it."""

import ctypes
import subprocess
from pathlib import Path

SOURCE = Path(__file__).with_suffix(".c")


def compiled(folder: Path) -> Path:
    """The library."""
    library = folder / "libfwlib32.so"
    flags = ("-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror")
    subprocess.run(["gcc", *flags, str(SOURCE), "-o", str(library)], check=True)
    return library


class FocasControl:
    """The control. `room`: bytes of its memory."""

    def __init__(self, library: Path) -> None:
        self.library = library
        self._c = ctypes.CDLL(str(library))
        self._c.standin_text.restype = ctypes.c_char_p
        self._c.standin_offset_now.restype = ctypes.c_int32
        self.reset()

    def reset(self, room: int = 50_000) -> None:
        self._c.standin_reset(room)

    def fault(self, name: str, when: int = 1) -> None:
        self._c.standin_fault(name.encode(), when)

    def calls(self) -> int:
        return int(self._c.standin_calls())

    def type_in(self, number: int, text: str) -> None:
        assert self._c.standin_type(number, text.encode())

    def text(self, number: int) -> str | None:
        found: bytes | None = self._c.standin_text(number)
        return None if found is None else found.decode()

    def runs(self, main: int, sub: int = 0, state: int = 3) -> None:
        self._c.standin_runs(state, main, sub)

    def is_a_mill(self) -> None:
        self._c.standin_mill()

    def enter_offset(self, number: int, kind: int, counts: int) -> None:
        self._c.standin_offset(number, kind, counts)

    def offset(self, number: int, kind: int) -> int:
        return int(self._c.standin_offset_now(number, kind))
