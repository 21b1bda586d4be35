"""One function applied to many parts: here, on local processes, or on the machines of a Dask scheduler."""

import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from threading import current_thread, main_thread
from typing import Final, TypeVar

from trueloop.domain.option import Limits, check_age
from trueloop.domain.record import check_same_program, check_uncorrected
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.extras import install_command
from trueloop.nc.program.program import Program
from trueloop.wording import wording


def refuse_misuse(
    program: Program | None, program_sha256: str | None, measured_at: datetime | None, now: datetime, limits: Limits
) -> list[str]:
    """Raises CMP-TWICE, CMP-OTHER-PROGRAM and CMP-AGE; returns notes on what could not be checked."""
    if program is not None:
        with in_file(program.file):
            check_uncorrected(program.source)
            if program_sha256 is not None:
                check_same_program(program.source, program_sha256)
    if measured_at is None:
        return [wording("The job does not say when the part was touched, so the touches' age was not checked.")]
    check_age(measured_at, now, limits)
    return []


Item = TypeVar("Item")
Result = TypeVar("Result")

TRIES: Final = 3
"""The number of times that work is given out again whose worker died."""
AHEAD: Final = 4
"""Items a local process has in hand or waiting, and so the most results that wait for an earlier one."""


def run_batch(
    work: Callable[[Item], Result], items: Sequence[Item], *, workers: int = 1, scheduler: str | None = None
) -> Iterator[Result]:
    """Yields results in the order of the items, each as soon as it is its turn: only a limited number are held here at
    once.

    `work` is a module's function, its arguments and results can be pickled. workers: local processes; 1 works here.
    scheduler: address of a Dask scheduler, `tcp://host:8786`, which needs the extra `cluster`. What a dying worker had
    in hand is given out again; an exception that `work` raises ends the batch. Raises SRF-BATCH when the scheduler
    cannot be reached, or workers keep dying.
    """
    if scheduler is not None:
        return _on_cluster(work, items, scheduler)
    if workers <= 1 or len(items) < 2:
        return map(work, items)
    return _on_processes(work, items, workers)


def _on_processes(work: Callable[[Item], Result], items: Sequence[Item], workers: int) -> Iterator[Result]:
    from concurrent.futures.process import BrokenProcessPool

    done = tries = 0
    while done < len(items):
        before = done
        try:
            for result in _until_one_dies(work, items[done:], workers):
                done += 1
                yield result
        except BrokenProcessPool:
            tries = tries + 1 if done == before else 1
            if tries == TRIES:
                hint = "a local process died each time: is there memory enough?"
                raise _lost(len(items) - done, hint) from None


def _until_one_dies(work: Callable[[Item], Result], items: Sequence[Item], workers: int) -> Iterator[Result]:
    """Results in order; work is given out so far ahead that nobody waits. A process that dies breaks the pool."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        try:
            with _unheard_by_those_started():
                given = deque(pool.submit(work, item) for item in items[: AHEAD * workers])
            for later in range(len(given), len(items) + len(given)):
                result = given.popleft().result()
                if later < len(items):
                    given.append(pool.submit(work, items[later]))
                yield result
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _unheard_by_those_started() -> Iterator[None]:
    """Makes processes started here ignore Ctrl-C, which a terminal sends to all of them: the process that started them
    ends them.

    Only a program's main thread may say so.
    """
    if current_thread() is not main_thread():
        yield
        return
    heard = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, heard)


def _on_cluster(work: Callable[[Item], Result], items: Sequence[Item], scheduler: str) -> Iterator[Result]:
    try:
        from distributed import Client, KilledWorker
    except ImportError as missing:
        raise Code.SRF_BATCH.refusal(
            f"the scheduler {scheduler!r} needs Dask, which is not installed: {str(missing)!r}",
            hint=install_command("cluster"),
        ) from None
    try:
        client = Client(scheduler, timeout="10s", set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TypeError) as error:
        raise Code.SRF_BATCH.refusal(
            f"the scheduler {scheduler!r} cannot be reached: {error}",
            hint="start one with `dask scheduler` and workers with `dask worker ADDRESS`",
        ) from error
    with client:
        # What a dying worker had, the scheduler gives out again itself; `retries` would repeat what `work` refuses.
        waiting = deque(client.map(work, items, pure=False))
        while waiting:  # a result is the workers' until its turn comes, and forgotten there once it is returned
            try:
                result = waiting.popleft().result()
            except KilledWorker as error:
                raise _lost(len(waiting) + 1, f"workers of the cluster died on it: {error}") from error
            yield result


def _lost(count: int, why: str) -> TrueloopError:
    return Code.SRF_BATCH.refusal(f"{count} parts could not be worked off in {TRIES} tries", hint=why)
