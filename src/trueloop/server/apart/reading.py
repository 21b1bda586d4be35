"""A file that was handed over, read in a process apart with limits of time and memory: `read_apart`.

A reader has decades of formats to know, and some file will make one loop or take all memory. That ends the process that
reads it, and is an answer; the service goes on. A process that has done well reads the next file.
"""

import asyncio
import atexit
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from threading import Event, Lock, Timer
from typing import Any, Final, TypeVar, cast
from weakref import WeakKeyDictionary

from anyio import CapacityLimiter
from anyio.to_thread import run_sync

from trueloop.described import filled_from
from trueloop.domain.codec import Codec
from trueloop.errors import Code, Place, TrueloopError
from trueloop.jobs.factory.imports import CODEC as READ
from trueloop.jobs.factory.uploads import HandedFile, ReadingOptions, Upload, handed
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.server.guarded import Service
from trueloop.server.settings import Limits
from trueloop.wording import Signed, Um, Worded, wording

AT_ONCE: Final = 2
"""Files that are read at once: others wait, and hold no thread that answers requests."""
WAITING: Final = 32
"""Files that wait; one more is refused."""
START_S: Final = 60.0
"""For a process to begin, s."""
END_S: Final = 5.0
"""For one that ends by itself to end, s."""
KEPT_BYTES: Final = 512 << 20
"""A process that has taken more than this reads no other file: what it holds is given back by its end."""
_PASSED_ON: Final = ("PATH", "PYTHON", "LANG", "LC_", "LD_LIBRARY_PATH", "HOME", "VIRTUAL_ENV")
"""Beginnings of the names of what the process gets of the service's environment: no password of a database."""

T = TypeVar("T")


@dataclass(frozen=True)
class Question:
    """How a file is to be read, by the name of the way, in what time and with how much more memory than at first."""

    reading: str
    handed: HandedFile
    seconds: float
    memory_bytes: int


@dataclass(frozen=True)
class Refusal:
    """A `TrueloopError`."""

    code: Code
    message: str | Worded
    hint: str | Worded
    place: Place
    override: str | None
    values: Mapping[str, Any]

    @classmethod
    def of(cls, error: TrueloopError) -> "Refusal":
        """Makes a refusal from an error."""
        return filled_from(cls, error, message=Worded.of(error.message), hint=Worded.of(error.hint))

    def error(self) -> TrueloopError:
        """Makes the error from the refusal."""
        message, hint = (one.text() if isinstance(one, Worded) else one for one in (self.message, self.hint))
        given = {"hint": hint, "place": self.place, "override": self.override, "values": self.values}
        return self.code.refusal(message, **given)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Answer:
    """The result of reading, or why it failed: refused, a fault of ours (its error and where), or the memory did not
    suffice.

    `memory_bytes`: how much more memory the process has now than at its start.
    """

    value: Any = None
    refusal: Refusal | None = None
    fault: str = ""
    exhausted: bool = False
    memory_bytes: int = field(default=0, kw_only=True)


CODEC: Final[Codec] = READ.with_more(Question, Answer, Refusal, Code, Place, Worded, Um, Signed)


class _Queue:
    """The limit of readings at once of one event loop, and how many wait or run."""

    def __init__(self) -> None:
        self.limiter, self.length = CapacityLimiter(AT_ONCE), 0


_OF_LOOP: Final[WeakKeyDictionary[asyncio.AbstractEventLoop, _Queue]] = WeakKeyDictionary()


async def read_apart(
    here: Service, upload: Upload, options: ReadingOptions, reading: Callable[[HandedFile], T], say: Texts = ENGLISH
) -> T:
    """Reads a file by one of `READINGS`. Raises what that raises, FAC-UNKNOWN, SRV-FILE, SRV-DELAY."""

    def read() -> T:
        with handed(here.store, upload, options, say) as given:
            return answered(here.settings.limits, given, reading)

    return await in_turn(here, read)


async def in_turn(here: Service, work: Callable[[], T]) -> T:
    """Does what reads files that were handed over, at most `AT_ONCE` at a time. Raises what it raises, SRV-DELAY."""
    queue = _OF_LOOP.setdefault(asyncio.get_running_loop(), _Queue())
    if queue.length >= AT_ONCE + WAITING:
        raise Code.SRV_DELAY.refusal(
            wording("{n} files that were handed over wait to be read", n=WAITING),
            hint=wording("hand it over again later"),
            values={"retry_after_s": here.settings.limits.read_s},
        )
    queue.length += 1
    try:
        return await run_sync(work, limiter=queue.limiter)
    finally:
        queue.length -= 1


def answered(limits: Limits, file: HandedFile, reading: Callable[[HandedFile], T]) -> T:
    """Returns what a process apart reads of a file in its folder. Raises what the reading raises, and SRV-FILE."""
    answer = PROCESSES.answer(Question(reading.__name__, file, limits.read_s, limits.read_bytes))
    if answer.refusal is not None:
        raise answer.refusal.error()
    if answer.exhausted:
        raise not_read(file.name, wording("it takes more than {gb:.3g} GB of memory", gb=limits.read_bytes / 1e9))
    if answer.fault:
        raise RuntimeError(answer.fault)
    return cast(T, answer.value)


def not_read(name: str, why: str) -> TrueloopError:
    """Makes the error SRV-FILE."""
    return Code.SRV_FILE.refusal(
        wording("{name!r} was not read: {why}", name=name, why=why),
        hint=wording("hand over a smaller file, or see what it holds: `trueloop measure read`, `trueloop nc check`"),
        values={"file": name},
    )


class Process:
    """One process that reads files."""

    def __init__(self) -> None:
        environment = {name: value for name, value in os.environ.items() if name.startswith(_PASSED_ON)}
        self._popen = subprocess.Popen(
            [sys.executable, "-P", "-m", "trueloop.server.apart.process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**environment, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
        self.pid = self._popen.pid
        self._ready = False

    @property
    def alive(self) -> bool:
        """Returns whether it has not ended."""
        return self._popen.poll() is None

    def answer(self, question: Question) -> Answer:
        """Raises SRV-FILE where none comes: the process has ended then, and what it held is free."""
        if not self._ready:
            with self._ended_after(START_S):
                self._ready = bool(self._line())
            if not self._ready:
                raise RuntimeError(f"the process that reads files did not begin: {self._how_it_ended()}")
        with self._ended_after(question.seconds) as late:
            line = self._line(CODEC.to_json(question).encode())
        if line.endswith(b"\n"):
            return CODEC.from_json(line, Answer)
        ended = self._how_it_ended()
        why = (
            wording("it takes longer than {seconds:g} s", seconds=question.seconds)
            if late.is_set()
            else wording("the process that read it ended {how}", how=ended)
        )
        raise not_read(question.handed.name, why)

    def _how_it_ended(self) -> str:
        """It has closed its output."""
        with suppress(subprocess.TimeoutExpired):
            self._popen.wait(END_S)
        self.end()
        status = self._popen.returncode
        return f"by {signal.Signals(-status).name}" if status < 0 else f"with status {status}"

    def end(self) -> None:
        """Ends it, whatever it is at."""
        self._popen.kill()
        self._popen.communicate()

    def _line(self, question: bytes = b"") -> bytes:
        assert self._popen.stdin is not None and self._popen.stdout is not None
        try:
            self._popen.stdin.write(question)
            self._popen.stdin.flush()
        except BrokenPipeError:
            return b""
        return self._popen.stdout.readline()

    @contextmanager
    def _ended_after(self, seconds: float) -> Iterator[Event]:
        """A process that takes longer than this block may is killed, which is seen by the event."""
        late = Event()

        def kill() -> None:
            late.set()
            self._popen.kill()

        timer = Timer(seconds, kill)
        timer.start()
        try:
            yield late
        finally:
            timer.cancel()


class Processes:
    """Those that wait for a file, the last that has read one first."""

    def __init__(self) -> None:
        self._waiting: list[Process] = []
        self._lock = Lock()

    def start(self) -> None:
        """Starts one process, so that the first file need not wait for it."""
        with self._lock:
            self._waiting = self._waiting or [Process()]

    def answer(self, question: Question) -> Answer:
        """Answers by a process that waits, else by a new one. Raises SRV-FILE."""
        process = self._taken() or Process()
        try:
            answer = process.answer(question)
        except BaseException:
            process.end()
            raise
        if answer.exhausted or answer.memory_bytes > KEPT_BYTES:
            process.end()
        else:
            with self._lock:
                self._waiting.append(process)
        return answer

    def end(self) -> None:
        """Ends those that wait."""
        while (process := self._taken()) is not None:
            process.end()

    def _taken(self) -> Process | None:
        with self._lock:
            while self._waiting:
                process = self._waiting.pop()
                if process.alive:
                    return process
                process.end()
        return None


PROCESSES: Final = Processes()
"""Those of this process: they end with it."""
atexit.register(PROCESSES.end)
