"""The heap of the service: what requests have freed is used again, or goes back to the system.

glibc gives each thread a heap of its own, and gives back by itself only what lies at the end of one. Holes between
blocks still in use stay, and with many clients at once they grow for hours, though nothing is held.
"""

import ctypes
import sys
from threading import Event, Thread
from typing import Final

_EVERY_S: Final = 30.0
_M_ARENA_MAX: Final = -8
"""As <malloc.h> numbers it."""


def share_one() -> None:
    """Threads that begin from now on share one heap: under Python's lock they hardly ever wait for each other."""
    _call("mallopt", _M_ARENA_MAX, 1)


def give_back() -> None:
    """Gives whole free pages of every heap back to the system."""
    _call("malloc_trim", 0)


def start_giving_back(stopping: Event) -> None:
    """Does so again and again, as long as the service runs."""
    Thread(target=_give_back_often, args=(stopping,), name="heap", daemon=True).start()


def _give_back_often(stopping: Event) -> None:
    while not stopping.wait(_EVERY_S):
        give_back()


def _call(name: str, *values: int) -> None:
    """Nothing with a C library that has no such call. On Windows a library has a name: none is looked into."""
    if sys.platform == "win32":
        return
    call = getattr(ctypes.CDLL(None), name, None)
    if call is not None:
        call(*values)
