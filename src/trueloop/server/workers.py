"""Threads that do slow tasks, as long as the service runs; what they were at when it stops another one takes up."""

import secrets
from collections.abc import Callable
from datetime import datetime
from threading import Event, Thread
from typing import Final

from trueloop.errors import TrueloopError
from trueloop.factory.carry_out import hold_silent
from trueloop.factory.tasks import run_task
from trueloop.jobs.factory.runners import RUNNERS
from trueloop.server.settings import log
from trueloop.storage.store import Store

_IDLE_S: Final = 0.5
_AFTER_A_FAULT_S: Final = 5.0
_WATCH_S: Final = 5.0


def start_workers(store: Store, clock: Callable[[], datetime], stopping: Event, count: int) -> None:
    """Starts them. They end with the process: a task is leased, and its lease runs out."""
    for _ in range(count):
        name = f"worker-{secrets.token_hex(4)}"
        Thread(target=_work, args=(store, clock, stopping, name), name=name, daemon=True).start()


def start_watch(store: Store, clock: Callable[[], datetime], stopping: Event, silent_s: float) -> None:
    """Looks for machines that are silent while they cut, as long as the service runs."""
    Thread(target=_watch, args=(store, clock, stopping, silent_s), name="watch", daemon=True).start()


def _watch(store: Store, clock: Callable[[], datetime], stopping: Event, silent_s: float) -> None:
    while not stopping.wait(_WATCH_S):
        try:
            if held := hold_silent(store, clock(), silent_s):
                log("silent", held=held)
        except TrueloopError as refused:  # the store is busy or away
            log("watch waits", code=refused.code.value, why=refused.message)


def _work(store: Store, clock: Callable[[], datetime], stopping: Event, name: str) -> None:
    while not stopping.is_set():
        try:
            task = run_task(store, RUNNERS, name, clock)
        except TrueloopError as refused:  # the store is busy or away
            log("worker waits", worker=name, code=refused.code.value, why=refused.message)
            stopping.wait(_AFTER_A_FAULT_S)
            continue
        except Exception as fault:  # the task is tried again when its lease has run out, three times at most
            log("worker failed", worker=name, error=f"{type(fault).__name__}: {fault}")
            stopping.wait(_AFTER_A_FAULT_S)
            continue
        if task is None:
            stopping.wait(_IDLE_S)
        else:
            log("task", worker=name, task=task.id, kind=task.kind, state=task.state)
