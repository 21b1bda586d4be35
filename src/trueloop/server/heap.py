"""Memory that requests have freed goes back to the system.

glibc gives back only what lies at the end of a heap. What threads free between blocks still in use it keeps as holes,
and with many clients at once they grow for hours, though nothing is held: a day would look like a leak.
"""

import ctypes
from threading import Event, Thread
from typing import Final

_EVERY_S: Final = 30.0


def give_back() -> None:
    """Gives whole free pages of every heap back; does nothing with a C library that has no such call."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def start_giving_back(stopping: Event) -> None:
    """Does so again and again, as long as the service runs."""
    Thread(target=_give_back_often, args=(stopping,), name="heap", daemon=True).start()


def _give_back_often(stopping: Event) -> None:
    while not stopping.wait(_EVERY_S):
        give_back()
