"""A cell beside a service whose PostgreSQL is stopped in the middle of a run: nothing that the cell knows is lost."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path

import pytest
from sqlalchemy import select

from tests.support.factory import CELL, PLAN, Shop
from tests.support.postgresql import Server, running
from tests.support.served import served
from tests.unit.controllers.cell.test_client import PACE, Table
from trueloop.controllers.linuxcnc.cell.client import Client, RefusedError, Service
from trueloop.controllers.linuxcnc.cell.journal import Journal
from trueloop.domain.factory import Block, BlockKind, RunFact
from trueloop.domain.record import Program, ProgramText
from trueloop.factory import requests as ask
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.keys import NewKey, add_key
from trueloop.storage.schema import RUN_TOUCHES, TEMPERATURE
from trueloop.storage.store import Store, find, keep, open_store

STEPS = 9
"""So many steps take the cell through a run: asked, noted, sent, opened, begun, and what its witness logs."""
TEXT = b"(PROBEOPEN t.txt)\nG38.2 X0\n(PROBECLOSE)\nM2\n"
SHA = sha256(TEXT).hexdigest()
GAUGED = replace(PLAN, serials=("a",), blocks=(Block(BlockKind.INSPECT, SHA), Block(BlockKind.REMOVE)))


@pytest.fixture
def own_server() -> Iterator[Server]:
    """A server of this test's own: it is stopped."""
    with running() as server:
        yield server


@contextmanager
def _cell(store: Store, folder: Path) -> Iterator[tuple[Client, Table]]:
    key = add_key(store, NewKey("lathe", "cell", 1), "test", datetime.now(UTC)).key
    with served(store) as address, closing(Service(address, key)) as service:
        table, journal = Table(), Journal(folder / "cell.journal")
        yield Client("lathe", table, service, journal, PACE), table
        journal.close()


def _works_on(client: Client, table: Table) -> None:
    """One step; a program that was started has ended by the next."""
    client.step()
    if table.starts and client.known.run is not None:
        table.log = f"{client.known.run.key} started\n{client.known.run.key} ended\n"
        table.files["t.txt"] = b"1 2 3"


@pytest.mark.parametrize("stopped_at", range(STEPS))
def test_what_a_cell_notes_while_the_database_is_away_arrives(
    tmp_path: Path, own_server: Server, stopped_at: int
) -> None:
    store = open_store(own_server.new_database(), create=True, codec=store_codec())
    keep(store, [Program("inspect.ngc", "linuxcnc", SHA, "mm"), ProgramText(SHA, TEXT)])
    shop = Shop(store)
    shop.do(ask.ReleaseProgram(SHA, "ran in"))
    shop.set_up(GAUGED)
    shop.do(ask.Arm(shop.order, 1, "test"), CELL)
    with _cell(store, tmp_path) as (client, table):
        for number in range(STEPS):
            client.temperatures({"table": float(number)})
            if number == stopped_at:
                own_server.stop()
                _works_on(client, table)
                assert client.fault is not None and "503" in client.fault.message
                assert not isinstance(client.fault, RefusedError)
                client.temperatures({"table": 100.0})
                _works_on(client, table)
                own_server.start()
            _works_on(client, table)
        for _ in range(10):
            _works_on(client, table)
        assert client.known.refused == () and client.known.waiting == () and client.known.run is None
        told = {one.values["what"] for one in client.journal.entries if one.what == "fact"}
    facts = [one.value.what.value for one in find(store, RunFact)]
    with store.reading() as connection:
        celsius = list(connection.scalars(select(TEMPERATURE.c.celsius).where(TEMPERATURE.c.signal == "table")))
        touches = list(connection.scalars(select(RUN_TOUCHES.c.content)))
    store.close()
    assert sorted(facts) == sorted(told) == ["ended", "sent", "started", "verified"]
    assert sorted(celsius) == [*map(float, range(STEPS)), 100.0] and touches == [b"1 2 3"]
