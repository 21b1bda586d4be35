"""Machines as they are now, and what their cells say: `heard`."""

import json
from collections.abc import Mapping
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import insert, select, update

from trueloop.domain.factory.route import BlockKind
from trueloop.domain.factory.states import StepState
from trueloop.domain.machine import Machine
from trueloop.factory.load import Known
from trueloop.factory.roles import By, require_machine
from trueloop.factory.shown.paging import known_of, time
from trueloop.factory.views.today import MachineNow
from trueloop.storage.factory_tables import API_KEY, MACHINE_HEARD, STEP, stamp
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES

STALE: Final = timedelta(seconds=10)
"""A cell speaks every 2 s: silence of five words is shown."""
_OPEN: Final = tuple(
    one.value
    for one in (
        *(StepState.OFFERED, StepState.SENT, StepState.VERIFIED, StepState.STARTED, StepState.ENDED),
        StepState.UNKNOWN,
    )
)


def heard(store: Store, machine: str, said: Mapping[str, Any], by: By, now: datetime) -> None:
    """What a cell says every two seconds: the latest counts, nothing is decided by it. Raises FAC-MACHINE."""
    require_machine(by, machine)
    row = {"at": stamp(now), "document": json.dumps(dict(said))}
    with store.writing() as connection:
        done = connection.execute(update(MACHINE_HEARD).where(MACHINE_HEARD.c.machine == machine).values(**row))
        if not done.rowcount:
            connection.execute(insert(MACHINE_HEARD).values(machine=machine, **row))


def machines_now(store: Store, now: datetime) -> tuple[MachineNow, ...]:
    """All machines that the store knows, by name."""
    with known_of(store) as known:
        return all_machines(known, now)


def all_machines(known: Known, now: datetime) -> tuple[MachineNow, ...]:
    """The same within a transaction."""
    said = {one.machine: one for one in known.rows(select(MACHINE_HEARD))}
    keys = select(API_KEY.c.machine).where(API_KEY.c.scope == "cell", API_KEY.c.ended_at.is_(None))
    named = {one.name for one in known.values(Machine)} | set(said) | set(known.connection.scalars(keys))
    doing = _doing(known)
    return tuple(_now(name, said.get(name), doing.get(name), now) for name in sorted(named))


def part_on(known: Known, machine: str) -> int | None:
    """The row of the part that a machine is at; None: none that an order made."""
    found = _doing(known).get(machine)
    return None if found is None else int(found.part)


def _doing(known: Known) -> Mapping[str, Any]:
    """The step that each machine is at."""
    run, part = TABLES["run"], TABLES["part"]
    query = (
        select(STEP.c.order, STEP.c.kind, STEP.c.state, part.c.serial, part.c.id.label("part"), run.c.machine)
        .join(run, run.c.identity == STEP.c.run)
        .join(part, part.c.id == STEP.c.part)
        .where(STEP.c.state.in_(_OPEN))
        .order_by(STEP.c.changed_at)
    )
    return {row.machine: row for row in known.rows(query)}


def _now(name: str, row: Any, doing: Any, now: datetime) -> MachineNow:
    said: Mapping[str, Any] = {} if row is None else json.loads(row.document)
    at = None if row is None else time(row.at)
    return MachineNow(
        name,
        at,
        at is None or now - at > STALE,
        str(said.get("state") or ""),
        order="" if doing is None else doing.order,
        part="" if doing is None else doing.serial,
        block=None if doing is None else BlockKind(doing.kind),
        step_state=None if doing is None else StepState(doing.state),
        program=str(said.get("program") or ""),
        line=said.get("line"),
        progress=said.get("progress"),
        corrector=str(said.get("corrector") or ""),
        temperatures_c=said.get("temperatures_c"),
    )
