"""A store that comes back from its backup is the same in every row, and the shop goes on where it was."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

from tests.support.factory import PLAN, Shop
from tests.support.postgresql import Server
from trueloop.domain.factory import BlockKind
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.db.copied import back_up, restore
from trueloop.server.identity.accounts import NewAccount, add_account
from trueloop.storage.schema import METADATA
from trueloop.storage.store import Store, open_store


@pytest.fixture(params=["sqlite", "postgresql"])
def new_place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where nothing is yet."""
    if request.param == "sqlite":
        return str(tmp_path / "restored.db")
    server: Server = request.getfixturevalue("server")
    return server.new_database()


def rows_of(store: Store) -> dict[str, list[Any]]:
    with store.reading() as connection:
        return {
            table.name: [tuple(row) for row in connection.execute(select(table).order_by(*table.primary_key.columns))]
            for table in METADATA.sorted_tables
        }


def silent(_: str) -> None:
    """Nobody is told."""


def test_a_restored_store_is_the_same_and_goes_on(store: Store, new_place: str, tmp_path: Path) -> None:
    shop = Shop(store).set_up()
    add_account(store, NewAccount("ana", "engineer", "four words, none alike"), shop.now)
    shop.run()
    back_up(store, tmp_path / "copy.db", silent)
    copied = restore(tmp_path / "copy.db", new_place, silent)
    again = open_store(new_place, codec=store.codec)
    before, after = rows_of(store), rows_of(again)
    assert after == before
    assert before["account"] and before["event"] and copied.count == sum(len(rows) for rows in before.values())
    on = Shop(again, shop.now, shop.order)
    assert on.run().block.kind is BlockKind.PROBE
    assert on.do(replace(PLAN, serials=("c", "d"))) != shop.order
    again.close()


def test_a_backup_that_was_changed_is_refused(store: Store, tmp_path: Path) -> None:
    Shop(store).set_up()
    back_up(store, tmp_path / "copy.db", silent)
    held = (tmp_path / "copy.db").read_bytes()
    assert b'"serial": "b"' in held
    (tmp_path / "copy.db").write_bytes(held.replace(b'"serial": "b"', b'"serial": "c"'))
    with pytest.raises(TrueloopError) as refused:
        restore(tmp_path / "copy.db", str(tmp_path / "restored.db"), silent)
    assert refused.value.code is Code.STO_DAMAGED
    assert not (tmp_path / "restored.db").exists()
