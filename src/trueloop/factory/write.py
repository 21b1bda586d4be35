"""The changes of a decision written, in the transaction in which its facts were read."""

import json
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

from sqlalchemy import Connection, Table, insert, update

from trueloop.factory.known import Changes, OrderNow, PartNow, StepNow
from trueloop.factory.load import StoreReader
from trueloop.storage.factory_tables import DONE, EVENT, IDEMPOTENCY, LOGS, ORDER_STATE, PART_STATE, STEP, TASK, stamp
from trueloop.storage.keeping import Keeping

_LOGS: Final[Mapping[str, Table]] = {table.name: table for table in LOGS}


def write(
    reader: StoreReader, changes: Changes, before: Mapping[str, OrderNow], by: str, now: datetime
) -> tuple[OrderNow, ...]:
    """Values, then orders with their parts and steps, then what happened. Returns the orders as they are now."""
    keeping = Keeping(reader.codec, reader.connection, by)
    for value in changes.keep:
        keeping.keep(value)
    at = stamp(now)
    done = tuple(_order(reader, keeping, before.get(one.order.id), one, at) for one in changes.orders)
    for table, row in changes.rows:
        reader.connection.execute(insert(_LOGS[table]).values(**row))
    for event in changes.events:
        said = json.dumps(dict(event.values))
        row = {"at": at, "who": by, "what": event.what, "subject": event.subject, "document": said}
        reader.connection.execute(insert(EVENT).values(**row))
    for task in changes.tasks:
        row = {"kind": task.kind, "subject": task.subject, "document": json.dumps(dict(task.values)), "made_by": by}
        reader.connection.execute(insert(TASK).values(**row, **_NEW_TASK, made_at=at, changed_at=at))
    return done


def note_done(connection: Connection, account: str, key: str) -> None:
    """Marks a request as done, for it has changed something: whatever becomes of its answer, it is not done again."""
    mine = (IDEMPOTENCY.c.account == account) & (IDEMPOTENCY.c.key == key)
    connection.execute(update(IDEMPOTENCY).where(mine).values(status=DONE))


_NEW_TASK: Final[Mapping[str, Any]] = {"state": "waiting", "said": "", "worker": "", "tries": 0, "progress": 0.0}


def _order(reader: StoreReader, keeping: Keeping, old: OrderNow | None, new: OrderNow, at: str) -> OrderNow:
    if old is None:
        return _new_order(reader, keeping, new, at)
    if old == new:
        return new
    new = replace(new, version=old.version + 1)
    state = {"state": new.state, "armed_parts": new.armed_parts, "version": new.version, "changed_at": at}
    reader.connection.execute(update(ORDER_STATE).where(ORDER_STATE.c.order == new.order.id).values(**state))
    for was, part in zip(old.parts, new.parts, strict=True):
        if was != part:
            _part(reader, new.order.id, was, part, at)
    return new


def _part(reader: StoreReader, order: str, was: PartNow, part: PartNow, at: str) -> None:
    said = {"state": part.state.value, "held_why": part.held_why, "version": was.version + 1, "changed_at": at}
    reader.connection.execute(update(PART_STATE).where(PART_STATE.c.part == part.row).values(**said))
    own = (STEP.c.order == order, STEP.c.part == part.row)
    for before, step in zip(was.steps, part.steps, strict=True):
        if before != step:
            changed = _of_step(replace(step, version=before.version + 1), at)
            reader.connection.execute(update(STEP).where(*own, STEP.c.no == step.no).values(**changed))


def _of_step(step: StepNow, at: str) -> dict[str, Any]:
    return {
        **{"state": step.state.value, "run": step.run, "program_sha256": step.program_sha256},
        **{"attempts": step.attempts, "version": step.version, "changed_at": at},
    }


def _new_order(reader: StoreReader, keeping: Keeping, new: OrderNow, at: str) -> OrderNow:
    name, machine = new.order.id, new.order.machine.name
    rows = [replace(one, row=keeping.keep(one.value).row) for one in new.parts]
    new = replace(new, parts=tuple(rows))
    state = {"state": new.state, "machine": machine, "changed_at": at, "armed_parts": new.armed_parts}
    reader.connection.execute(insert(ORDER_STATE).values(order=name, number=new.number, version=new.version, **state))
    parts = [
        {
            **{"part": one.row, "state": one.state.value, "order": name, "machine": machine, "changed_at": at},
            **{"held_why": one.held_why, "version": one.version},
        }
        for one in new.parts
    ]
    reader.connection.execute(insert(PART_STATE), parts)
    steps = [
        {"order": name, "part": one.row, "no": step.no, "kind": step.kind.value, **_of_step(step, at)}
        for one in new.parts
        for step in one.steps
    ]
    reader.connection.execute(insert(STEP), steps)
    return new
