"""Requests that take a few milliseconds of one processor take turns, two at a time.

Python runs one thread at a time: eight that are let in at once spend as much again in handing its lock to each other,
and each of them waits for all. What takes long, and what waits for somebody else, does not queue here.
"""

import asyncio
from typing import Final
from weakref import WeakKeyDictionary

AT_ONCE: Final = 2
"""One that Python runs, and one that the database or the system works for."""
_OF_LOOP: Final[WeakKeyDictionary[asyncio.AbstractEventLoop, asyncio.Semaphore]] = WeakKeyDictionary()


def turn() -> asyncio.Semaphore:
    """Returns the semaphore of the loop that runs: to be held by `async with`."""
    return _OF_LOOP.setdefault(asyncio.get_running_loop(), asyncio.Semaphore(AT_ONCE))
