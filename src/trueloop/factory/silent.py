"""Looks for machines that are silent while they cut: `hold_silent`."""

from datetime import datetime
from typing import Final

from sqlalchemy import Connection, select

from trueloop.domain.factory import StepState
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.load import last_word
from trueloop.factory.roles import By, Role
from trueloop.storage.factory_tables import STEP
from trueloop.storage.store import Store

_SERVICE: Final = By("service", Role.SERVICE)


def hold_silent(store: Store, now: datetime, limit_s: float) -> int:
    """Holds every part that was being cut when its machine was heard last, longer ago than this. Returns how many."""
    with store.reading() as connection:
        found = [one for one in _started(connection) if _silent(connection, one, now, limit_s)]
    held = 0
    for order, part, no in found:
        held += len(carry_out(store, ask.CellSilent(order, part, no, limit_s), _SERVICE, now).orders)
    return held


def _started(connection: Connection) -> list[tuple[str, int, int]]:
    query = select(STEP.c.order, STEP.c.part, STEP.c.no).where(STEP.c.state == StepState.STARTED.value)
    return [(row.order, row.part, row.no) for row in connection.execute(query)]


def _silent(connection: Connection, step: tuple[str, int, int], now: datetime, limit_s: float) -> bool:
    at = last_word(connection, *step)
    return at is not None and (now - at).total_seconds() > limit_s
