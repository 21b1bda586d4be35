"""Machines as they are now, and what their cells say: `heard`."""

import json
from collections.abc import Mapping
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import func, insert, select, update

from trueloop.domain.factory.route import BlockKind
from trueloop.domain.factory.states import StepState
from trueloop.domain.machine import Machine
from trueloop.domain.model_version import ModelDecision, ModelVersion
from trueloop.factory.known import unknown
from trueloop.factory.load import Known
from trueloop.factory.roles import By, require_machine
from trueloop.factory.shown.paging import known_of, time
from trueloop.factory.shown.records import transfer_view
from trueloop.factory.views.orders import MachineView
from trueloop.factory.views.today import MachineNow
from trueloop.storage.factory_tables import API_KEY, MACHINE_HEARD, STEP, TRANSFER, stamp
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
    named = {one.name for one in known.values(Machine)} | set(said)
    doing = _doing(known)
    return tuple(_now(name, said.get(name), doing.get(name), now) for name in sorted(named))


def machine_view(store: Store, name: str, now: datetime) -> MachineView:
    """One machine. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        found = next((one for one in all_machines(known, now) if one.name == name), None)
        if found is None:
            raise unknown("machine", name, "no order, cell or inspection has named it")
        keys = select(func.count()).where(API_KEY.c.machine == name, API_KEY.c.ended_at.is_(None))
        query = select(TRANSFER).where(TRANSFER.c.control == name).order_by(TRANSFER.c.id.desc()).limit(20)
        transfers = tuple(transfer_view(one) for one in known.rows(query))
        return MachineView(found, _model(known, name), known.connection.scalar(keys) or 0, transfers)


def _model(known: Known, name: str) -> str:
    """The hash of the machine model that was accepted last; empty: none was."""
    versions = [one.sha256 for one in known.values(ModelVersion, machine=name)]
    accepted = [one for one in known.values(ModelDecision, verdict="accepted") if one.model in versions]
    return max(accepted, key=lambda one: one.at).model if accepted else ""


def _doing(known: Known) -> Mapping[str, Any]:
    """The step that each machine is at."""
    run, part = TABLES["run"], TABLES["part"]
    query = (
        select(STEP.c.order, STEP.c.kind, STEP.c.state, part.c.serial, run.c.machine)
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
