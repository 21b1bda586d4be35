"""Slow work that was asked for: rows that workers lease, report on and end. A task commits with its cause.

A lease that is not renewed runs out, and another worker takes the task: what a task does has to bear being done twice.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import and_, or_, select, update

from trueloop.described import filled_from
from trueloop.errors import TrueloopError
from trueloop.factory.known import unknown
from trueloop.storage.engines import AWAY
from trueloop.storage.schema import TASK, stamp
from trueloop.storage.store import Store
from trueloop.wording import wording

LEASE_S: Final = 60.0
MOST_TRIES: Final = 3
Clock = Callable[[], datetime]


@dataclass(frozen=True)
class Task:
    """One task. `state`: waiting, running, done, failed; `progress` from 0 to 1; `problem`: of a refusal."""

    id: int
    kind: str
    subject: str
    values: Mapping[str, str]
    state: str
    progress: float
    said: str
    tries: int
    made_by: str
    problem: Mapping[str, Any] | None = None
    result: Mapping[str, str] | None = None


@dataclass(frozen=True)
class Working:
    """The reporter of a running task: `say` renews the lease, and is False where another worker has the task."""

    store: Store
    task: Task
    worker: str
    clock: Clock

    def say(self, progress: float, text: str) -> bool:
        """Reports how far it is; returns whether the task is still this worker's."""
        now = self.clock()
        return self._set({"progress": progress, "said": text, "lease_until": _until(now)}, now)

    def end(self, state: str, **more: Any) -> bool:
        """Ends the task, if it is still this worker's."""
        return self._set({"state": state, "lease_until": None, **more}, self.clock())

    def _set(self, values: dict[str, Any], now: datetime) -> bool:
        own = (TASK.c.id == self.task.id, TASK.c.worker == self.worker, TASK.c.state == "running")
        with self.store.writing() as connection:
            done = connection.execute(update(TASK).where(*own).values(**values, changed_at=stamp(now)))
            return bool(done.rowcount)


Runner = Callable[[Store, Task, Working], Mapping[str, str]]
"""Does a task; what it returns is kept as the result. What it raises as `TrueloopError` is the task's problem."""


def task_of(store: Store, number: int) -> Task:
    """Returns the task of that number. Raises FAC-UNKNOWN."""
    with store.reading() as connection:
        row = connection.execute(select(TASK).where(TASK.c.id == number)).one_or_none()
    if row is None:
        raise unknown(wording("task"), str(number), wording("the store has none of that number"))
    return _task(row)


def lease(store: Store, worker: str, now: datetime) -> Task | None:
    """Leases the oldest task that waits, or whose worker is gone; None: none. One tried too often comes as failed."""
    gone = and_(TASK.c.state == "running", TASK.c.lease_until < stamp(now))
    free = or_(TASK.c.state == "waiting", gone)
    query = select(TASK).where(free).order_by(TASK.c.id).limit(1).with_for_update(skip_locked=True)
    with store.reading() as connection:  # so that idle workers do not take turns with who writes
        if connection.execute(select(TASK.c.id).where(free).limit(1)).first() is None:
            return None
    with store.writing() as connection:
        row = connection.execute(query).first()
        if row is None:
            return None
        mine: dict[str, Any] = {
            "state": "running",
            "worker": worker,
            "tries": row.tries + 1,
            "lease_until": _until(now),
        }
        if row.tries >= MOST_TRIES:
            said = {"code": "", "message": f"its worker ended without a word {row.tries} times", "hint": ""}
            mine = {"state": "failed", "lease_until": None, "problem": json.dumps(said)}
        connection.execute(update(TASK).where(TASK.c.id == row.id).values(**mine, changed_at=stamp(now)))
        again = connection.execute(select(TASK).where(TASK.c.id == row.id)).one()
    return _task(again)


def run_task(store: Store, runners: Mapping[str, Runner], worker: str, clock: Clock) -> Task | None:
    """Does one task; None: there is none. A kind unknown or refused has failed; without the store it is taken again."""
    task = lease(store, worker, clock())
    if task is None or task.state != "running":
        return task
    working = Working(store, task, worker, clock)
    try:
        if task.kind not in runners:
            raise unknown(wording("task"), task.kind, f"known are {', '.join(sorted(runners))}")
        result = runners[task.kind](store, task, working)
    except TrueloopError as refused:
        if refused.code in AWAY:
            raise
        said = {"code": refused.code.value, "message": refused.message, "hint": refused.hint}
        working.end("failed", problem=json.dumps({**said, "values": dict(refused.values)}))
    else:
        working.end("done", progress=1.0, result=json.dumps(dict(result)))
    return task_of(store, task.id)


def _until(now: datetime) -> str:
    return stamp(now + timedelta(seconds=LEASE_S))


def _task(row: Any) -> Task:
    problem, result = (None if one is None else json.loads(one) for one in (row.problem, row.result))
    return filled_from(Task, row, values=json.loads(row.document), problem=problem, result=result)
