"""A service on a new store, in SQLite or in PostgreSQL."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.new_stores import new_database, new_file
from tests.support.service import Running, started
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import Store, open_store


@pytest.fixture(params=["sqlite", "postgresql"])
def store(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Store]:
    if request.param == "sqlite":
        place = new_file(tmp_path / "trueloop.db")
    else:
        place = new_database(request.getfixturevalue("server"))
    opened = open_store(place, codec=store_codec())
    yield opened
    opened.close()


@pytest.fixture
def service(store: Store) -> Running:
    return started(store)
