"""Machines as they are now, and what their cells say: `heard`."""

import json
from collections.abc import Iterator, Mapping
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import ColumnElement, Select, func, insert, select, update

from trueloop.domain.factory import BlockKind, StepState
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.tool import Edge, Setting
from trueloop.factory.known import unknown
from trueloop.factory.load import StoreReader, machine_names
from trueloop.factory.requests import By, require_machine
from trueloop.factory.shown.records import known_of, time, transfer_view
from trueloop.factory.views.orders import MachineNow
from trueloop.factory.views.parts import CalibrationView, MachineView, TemperatureView
from trueloop.factory.views.series import ToolRow
from trueloop.storage.keeping import Query, found
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.schema import API_KEY, CALIBRATION, MACHINE_HEARD, STEP, TABLES, TEMPERATURE, TRANSFER, stamp
from trueloop.storage.store import Store
from trueloop.wording import wording

STALE: Final = timedelta(seconds=10)
"""A cell speaks every 2 s: silence of five words is shown."""
_OPEN: Final = tuple(
    step_state.value
    for step_state in (
        *(StepState.OFFERED, StepState.SENT, StepState.VERIFIED, StepState.STARTED, StepState.ENDED),
        StepState.UNKNOWN,
    )
)


def heard(store: Store, machine: str, report: Mapping[str, Any], by: By, now: datetime) -> None:
    """Records a cell's report of every two seconds: the latest counts, it decides nothing. Raises FAC-MACHINE."""
    require_machine(by, machine)
    row = {"at": stamp(now), "document": json.dumps(dict(report))}
    with store.writing() as connection:
        done = connection.execute(update(MACHINE_HEARD).where(MACHINE_HEARD.c.machine == machine).values(**row))
        if not done.rowcount:
            connection.execute(insert(MACHINE_HEARD).values(machine=machine, **row))


def machines_now(store: Store, now: datetime) -> tuple[MachineNow, ...]:
    """Returns all machines that the store knows, by name."""
    with known_of(store) as known:
        return all_machines(known, now)


def all_machines(reader: StoreReader, now: datetime) -> tuple[MachineNow, ...]:
    """Returns all machines, within a transaction."""
    said = {row.machine: row for row in reader.rows(select(MACHINE_HEARD))}
    doing = _doing(reader)
    return tuple(_now(name, said.get(name), doing.get(name), now) for name in sorted(machine_names(reader)))


def part_on(reader: StoreReader, machine: str) -> int | None:
    """Returns the row of the part that a machine is at; None: none that an order made."""
    found = _doing(reader).get(machine)
    return None if found is None else int(found.part)


def _doing(reader: StoreReader) -> Mapping[str, Any]:
    """The step that each machine is at."""
    run, part = TABLES["run"], TABLES["part"]
    query = (
        select(STEP.c.order, STEP.c.kind, STEP.c.state, part.c.serial, part.c.id.label("part"), run.c.machine)
        .join(run, run.c.identity == STEP.c.run)
        .join(part, part.c.id == STEP.c.part)
        .where(STEP.c.state.in_(_OPEN))
        .order_by(STEP.c.changed_at)
    )
    return {row.machine: row for row in reader.rows(query)}


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


LATEST: Final = 20
"""Of transfers and of calibrations."""
HOURS: Final = timedelta(hours=8)
"""Of temperatures: a shift."""
MINUTE: Final = len("2026-01-02T03:04")
"""Characters of a stored time that say the minute."""
COLD: Final = timedelta(minutes=5)
"""A temperature that is older is grey."""


def machine_view(store: Store, name: str, now: datetime) -> MachineView:
    """Returns one machine. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        keys = select(func.count()).where(API_KEY.c.machine == name, API_KEY.c.ended_at.is_(None))
        return MachineView(
            now=_wanted(known, name, now),
            part_id=part_on(known, name),
            model_version=_model(known, name),
            keys=known.connection.scalar(keys) or 0,
            calibrations=tuple(_calibration(row) for row in _latest(known, CALIBRATION, CALIBRATION.c.machine == name)),
            temperatures=tuple(_temperatures(known, name, now)),
            transfers=tuple(transfer_view(row) for row in _latest(known, TRANSFER, TRANSFER.c.control == name)),
        )


def require_known(store: Store, name: str, now: datetime) -> None:
    """Raises FAC-UNKNOWN for a machine that nothing has named."""
    with known_of(store) as known:
        _wanted(known, name, now)


def _wanted(reader: StoreReader, name: str, now: datetime) -> MachineNow:
    found = next((machine for machine in all_machines(reader, now) if machine.name == name), None)
    if found is None:
        raise unknown(wording("machine"), name, wording("no order, cell, key or inspection has named it"))
    return found


def _model(reader: StoreReader, name: str) -> str:
    """The hash of the machine model that was accepted last; empty: none was."""
    versions = [one.sha256 for one in reader.values(ModelVersion, machine=name)]
    accepted = [one for one in reader.values(ModelDecision, verdict="accepted") if one.model in versions]
    return max(accepted, key=lambda one: one.at).model if accepted else ""


def _latest(reader: StoreReader, table: Any, of_machine: Any) -> list[Any]:
    return reader.rows(select(table).where(of_machine).order_by(table.c.id.desc()).limit(LATEST))


def _calibration(row: Any) -> CalibrationView:
    return CalibrationView(time(row.at), row.who, json.loads(row.document))


def _temperatures(reader: StoreReader, name: str, now: datetime) -> Iterator[TemperatureView]:
    """By sensor: of the latest hours, or its last value where that is older."""
    for signal in _signals(reader, name):
        of_signal = (TEMPERATURE.c.machine == name) & (TEMPERATURE.c.signal == signal)
        rows = reader.rows(_last_of_minutes(of_signal & (TEMPERATURE.c.at >= stamp(now - HOURS))))
        rows = rows or reader.rows(select(TEMPERATURE).where(of_signal).order_by(TEMPERATURE.c.at.desc()).limit(1))
        at = tuple(time(row.at) for row in rows)
        yield TemperatureView(signal, at, tuple(row.celsius for row in rows), now - at[-1] > COLD)


def _signals(reader: StoreReader, name: str) -> Iterator[str]:
    """Each by a look into the index: a machine may have millions of temperatures, and a handful of sensors."""
    signal, first = "", select(func.min(TEMPERATURE.c.signal)).where(TEMPERATURE.c.machine == name)
    while (found := reader.connection.scalar(first.where(TEMPERATURE.c.signal > signal))) is not None:
        yield (signal := found)


def _last_of_minutes(chosen: ColumnElement[bool]) -> Select[Any]:
    """Oldest first, one a minute: a shift may have 30,000, and a picture shows no more than these 480."""
    last = func.max(TEMPERATURE.c.id)
    of_minutes = select(last).where(chosen).group_by(func.substr(TEMPERATURE.c.at, 1, MINUTE))
    return select(TEMPERATURE).where(TEMPERATURE.c.id.in_(of_minutes)).order_by(TEMPERATURE.c.at, TEMPERATURE.c.id)


def tool_rows(store: Store) -> tuple[ToolRow, ...]:
    """Returns all edges; `parts`: how many parts each has cut."""
    cut = TABLES["cut"]
    with known_of(store) as known:
        count = select(cut.c.edge, func.count(cut.c.serial.distinct())).where(cut.c.edge.is_not(None))
        parts = dict(known.rows(count.group_by(cut.c.edge)))
        settings = _settings(known)
        edges = list(found(known.connection, known.codec, Query(kind_of(Edge))))
    rows = []
    for stored in edges:
        edge: Edge = stored.value
        key = searchable(joined(edge.identity)) or ""
        set_at = None if key not in settings else settings[key].set_at
        insert = " ".join(filter(None, (edge.insert, edge.corner)))
        rows.append(
            ToolRow(
                id=stored.row,
                tool=edge.tool.identity[0],
                edge=insert,
                nose_radius_mm=edge.tool.corner_radius_mm,
                set_at=set_at,
                parts=parts.get(key, 0),
            )
        )
    return tuple(rows)


def _settings(reader: StoreReader) -> dict[str, Setting]:
    """The latest of each edge."""
    every: list[Setting] = reader.values(Setting)
    dated = sorted(
        (setting for setting in every if setting.set_at is not None), key=lambda setting: str(setting.set_at)
    )
    return {searchable(joined(setting.edge.identity)) or "": setting for setting in dated}
