"""New stores as copies of one that was made once: in PostgreSQL its tables take a fifth of a second."""

import tempfile
from functools import cache
from pathlib import Path

from sqlalchemy import make_url

from tests.support.postgresql import Server
from trueloop.storage.store import open_store


@cache
def _empty_store() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trueloop.db"
        open_store(file, create=True).close()
        return file.read_bytes()


def new_file(file: Path) -> str:
    """An empty store in a file."""
    file.write_bytes(_empty_store())
    return str(file)


@cache
def _template(server: Server) -> str:
    made = server.new_database()
    open_store(made, create=True).close()
    return str(make_url(made).database)


def new_database(server: Server) -> str:
    """An empty store in a database of its own, by its URL."""
    return server.new_database(like=_template(server))
