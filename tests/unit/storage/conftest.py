"""Stores to test: a new one in SQLite or in PostgreSQL."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.postgresql import Server, running
from trueloop.storage.store import Store, open_store


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    with running() as started:
        yield started


@pytest.fixture(params=["sqlite", "postgresql"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Where a store can be made."""
    if request.param == "sqlite":
        return str(tmp_path / "trueloop.db")
    server: Server = request.getfixturevalue("server")
    return server.new_database()


@pytest.fixture
def store(place: str) -> Iterator[Store]:
    opened = open_store(place, create=True)
    yield opened
    opened.close()
