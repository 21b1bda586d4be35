"""Sources of signals run in tests: one thread, the latest readings, and waits that end."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from trueloop.controllers.linuxcnc.realtime.signals.readings import Board, Feed, Reader, Reading, ended

LONGEST_S = 30.0


def until(condition: Callable[[], object], what: str = "") -> None:
    """Waits, not for ever."""
    last_s = time.monotonic() + LONGEST_S
    while not condition():
        assert time.monotonic() < last_s, f"not within {LONGEST_S} s: {what}"
        time.sleep(0.01)


@dataclass
class Running:
    """A source that is being read. `said`: lines of its log."""

    reader: Reader
    board: Board
    said: list[str] = field(default_factory=list)

    def wait_for(self, name: str, accept: Callable[[Reading], bool] = lambda _: True) -> Reading:
        """The first reading of that signal that is accepted."""
        until(lambda: name in (now := self.board.readings()) and accept(now[name]), f"{name}; said: {self.said}")
        return self.board.readings()[name]


@contextmanager
def reading(feed: Feed) -> Iterator[Running]:
    """Reads a source until the block ends."""
    said, board, stop = list[str](), Board(), threading.Event()
    reader = Reader("source", feed, board, stop, said.append)
    reader.start()
    try:
        yield Running(reader, board, said)
    finally:
        ended([reader], stop)
    assert not reader.is_alive(), "the end of a source is waited for"


@dataclass
class Kept:
    """An intake that keeps all it is given."""

    given: list[tuple[str, float, float]] = field(default_factory=list)
    refused: dict[str, str] = field(default_factory=dict)

    def put(self, name: str, value: float, time_s: float) -> None:
        self.given.append((name, value, time_s))

    def refuse(self, name: str, why: str) -> None:
        self.refused[name] = why
