"""Stores to test: a new one in SQLite or in PostgreSQL."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.new_stores import new_database, new_file
from tests.support.postgresql import Server
from trueloop.storage.store import Store, open_store


@pytest.fixture(params=["sqlite", "postgresql"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where a store can be made."""
    if request.param == "sqlite":
        return str(tmp_path / "trueloop.db")
    server: Server = request.getfixturevalue("server")
    return server.new_database()


@pytest.fixture(params=["sqlite", "postgresql"])
def stored_at(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where an empty store is."""
    if request.param == "sqlite":
        return new_file(tmp_path / "trueloop.db")
    return new_database(request.getfixturevalue("server"))


@pytest.fixture
def store(stored_at: str) -> Iterator[Store]:
    opened = open_store(stored_at)
    yield opened
    opened.close()
