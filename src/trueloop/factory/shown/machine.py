"""One machine: what it does, its calibrations, temperatures and transfers, each with its time."""

import json
from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import ColumnElement, Select, func, select

from trueloop.domain.model_version import ModelDecision, ModelVersion
from trueloop.factory.known import unknown
from trueloop.factory.load import Known
from trueloop.factory.shown.machines import all_machines, part_on
from trueloop.factory.shown.paging import known_of, time
from trueloop.factory.shown.records import transfer_view
from trueloop.factory.views.machines import CalibrationView, MachineView, TemperatureView
from trueloop.factory.views.today import MachineNow
from trueloop.storage.factory_tables import API_KEY, CALIBRATION, TEMPERATURE, TRANSFER, stamp
from trueloop.storage.store import Store

LATEST: Final = 20
"""Of transfers and of calibrations."""
HOURS: Final = timedelta(hours=8)
"""Of temperatures: a shift."""
MINUTE: Final = len("2026-01-02T03:04")
"""Characters of a stored time that say the minute."""
COLD: Final = timedelta(minutes=5)
"""A temperature that is older is grey."""


def machine_view(store: Store, name: str, now: datetime) -> MachineView:
    """One machine. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        keys = select(func.count()).where(API_KEY.c.machine == name, API_KEY.c.ended_at.is_(None))
        return MachineView(
            *(_wanted(known, name, now), part_on(known, name), _model(known, name)),
            known.connection.scalar(keys) or 0,
            tuple(_calibration(row) for row in _latest(known, CALIBRATION, CALIBRATION.c.machine == name)),
            tuple(_temperatures(known, name, now)),
            tuple(transfer_view(row) for row in _latest(known, TRANSFER, TRANSFER.c.control == name)),
        )


def require_known(store: Store, name: str, now: datetime) -> None:
    """Raises FAC-UNKNOWN for a machine that nothing has named."""
    with known_of(store) as known:
        _wanted(known, name, now)


def _wanted(known: Known, name: str, now: datetime) -> MachineNow:
    found = next((one for one in all_machines(known, now) if one.name == name), None)
    if found is None:
        raise unknown("machine", name, "no order, cell, key or inspection has named it")
    return found


def _model(known: Known, name: str) -> str:
    """The hash of the machine model that was accepted last; empty: none was."""
    versions = [one.sha256 for one in known.values(ModelVersion, machine=name)]
    accepted = [one for one in known.values(ModelDecision, verdict="accepted") if one.model in versions]
    return max(accepted, key=lambda one: one.at).model if accepted else ""


def _latest(known: Known, table: Any, of_machine: Any) -> list[Any]:
    return known.rows(select(table).where(of_machine).order_by(table.c.id.desc()).limit(LATEST))


def _calibration(row: Any) -> CalibrationView:
    return CalibrationView(time(row.at), row.who, json.loads(row.document))


def _temperatures(known: Known, name: str, now: datetime) -> Iterator[TemperatureView]:
    """By sensor: of the latest hours, or its last value where that is older."""
    for signal in _signals(known, name):
        of_signal = (TEMPERATURE.c.machine == name) & (TEMPERATURE.c.signal == signal)
        rows = known.rows(_last_of_minutes(of_signal & (TEMPERATURE.c.at >= stamp(now - HOURS))))
        rows = rows or known.rows(select(TEMPERATURE).where(of_signal).order_by(TEMPERATURE.c.at.desc()).limit(1))
        at = tuple(time(row.at) for row in rows)
        yield TemperatureView(signal, at, tuple(row.celsius for row in rows), now - at[-1] > COLD)


def _signals(known: Known, name: str) -> Iterator[str]:
    """Each by a look into the index: a machine may have millions of temperatures, and a handful of sensors."""
    signal, first = "", select(func.min(TEMPERATURE.c.signal)).where(TEMPERATURE.c.machine == name)
    while (found := known.connection.scalar(first.where(TEMPERATURE.c.signal > signal))) is not None:
        yield (signal := found)


def _last_of_minutes(chosen: ColumnElement[bool]) -> Select[Any]:
    """Oldest first, one a minute: a shift may have 30,000, and a picture shows no more than these 480."""
    last = func.max(TEMPERATURE.c.id)
    of_minutes = select(last).where(chosen).group_by(func.substr(TEMPERATURE.c.at, 1, MINUTE))
    return select(TEMPERATURE).where(TEMPERATURE.c.id.in_(of_minutes)).order_by(TEMPERATURE.c.at, TEMPERATURE.c.id)
