"""Connections to a store's database: SQLite by its file, PostgreSQL by URL; every wait of theirs ends.

SQLite: write-ahead log, `synchronous = FULL`, so that what was acknowledged outlasts a power cut; writers take turns by
`BEGIN IMMEDIATE`. PostgreSQL: writers take turns by an advisory lock, so that rows are numbered in the order in which
they appear.
"""

import sqlite3
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError, SQLAlchemyError
from sqlalchemy.pool import StaticPool

from trueloop.errors import Code, TrueloopError
from trueloop.extras import install_command
from trueloop.storage.keeping import shown
from trueloop.wording import shell_word

AWAY: Final = frozenset((Code.STO_FILE, Code.STO_SCHEMA, Code.STO_BUSY, Code.STO_WRITE))
"""Refusals that the state of the store causes and not what it was given: the same request may be taken later."""
_SQLITE_CODES: Final = {
    sqlite3.SQLITE_BUSY: Code.STO_BUSY,
    sqlite3.SQLITE_LOCKED: Code.STO_BUSY,
    sqlite3.SQLITE_FULL: Code.STO_WRITE,
    sqlite3.SQLITE_IOERR: Code.STO_WRITE,
    sqlite3.SQLITE_READONLY: Code.STO_WRITE,
}
"""By SQLite's primary result codes; whatever else goes wrong is the file's fault."""
_POSTGRESQL: Final = {
    "55P03": Code.STO_BUSY,  # lock not available
    "57014": Code.STO_BUSY,  # cancelled by a timeout
    "22": Code.STO_TEXT,  # data exceptions
    "40": Code.STO_BUSY,  # serialisation, deadlock
    "53": Code.STO_WRITE,  # no room, no memory, too many connections
    "25006": Code.STO_WRITE,  # read-only transaction
    "42501": Code.STO_WRITE,  # no right to
    "58": Code.STO_WRITE,  # the system refuses
}
"""By SQLSTATE or its class."""
_HINTS: Final = {
    Code.STO_BUSY: "wait until the other program is done, then try again; nothing was kept",
    Code.STO_WRITE: "make room, see that it may be written, or name another store by --db; nothing was kept",
    Code.STO_TEXT: "leave control characters out; nothing was kept",
    Code.STO_FILE: "see that it is a store of trueloop, that it can be reached, and `trueloop db check` it",
}


@contextmanager
def understood(where: str) -> Iterator[None]:
    """Turns what the database raises inside into a refusal that names the store."""
    try:
        yield
    except (SQLAlchemyError, sqlite3.Error) as wrong:
        raise _refusal(wrong, where) from wrong
    except Exception as wrong:
        if type(wrong).__module__.partition(".")[0] != "psycopg":
            raise
        raise _refusal(wrong, where) from wrong


def _refusal(wrong: Exception, where: str) -> TrueloopError:
    cause = wrong.orig if isinstance(wrong, DBAPIError) and wrong.orig is not None else wrong
    code = _code(cause)
    said = {
        Code.STO_BUSY: "is locked by another program",
        Code.STO_WRITE: "cannot be written",
        Code.STO_TEXT: "cannot keep a value",
    }
    what = said.get(code, "cannot be used")
    return code.refusal(f"the store {where!r} {what}: {_first_line(cause)}", hint=_HINTS[code])


def _code(cause: BaseException) -> Code:
    if isinstance(cause, sqlite3.Error):
        return _SQLITE_CODES.get((getattr(cause, "sqlite_errorcode", 0) or 0) & 0xFF, Code.STO_FILE)
    state = str(getattr(cause, "sqlstate", None) or "")
    if not state and type(cause).__name__ == "DataError":  # refused by the driver, before the server saw it
        return Code.STO_TEXT
    return _POSTGRESQL.get(state, _POSTGRESQL.get(state[:2], Code.STO_FILE))


def _first_line(cause: BaseException) -> str:
    return str(cause).strip().partition("\n")[0] or type(cause).__name__


WRITING: Final = "trueloop_writing"
"""The execution option of a connection that is to write."""
_TURN: Final = 0x7472_6C70
"""The number of PostgreSQL's advisory lock by which writers take turns."""
_SQLITE: Final = ("PRAGMA foreign_keys = ON", "PRAGMA recursive_triggers = ON", "PRAGMA synchronous = FULL")
HELD_OPEN: Final = 16
"""Connections to a file that stay open between transactions: opening one costs as much as reading a part's life."""
_REACHED_S: Final = 10
"""How long to wait for a server that does not answer."""


def url_of(where: str | Path) -> URL:
    """Returns the URL of a store: of a file, of SQLite, or of PostgreSQL. Raises STO-FILE for another."""
    text = str(where)
    if "://" not in text:
        return URL.create("sqlite", database=text)
    if text.partition("?")[0].count("@") > 1:  # it would be taken for a part of the host's name, and be printed
        raise _no_store(shown(text), "write `%40` for an `@` in a name or a password")
    try:
        url = make_url(text)
    except (ArgumentError, ValueError):
        raise _no_store(shown(text)) from None
    name = url.get_backend_name() if url.drivername != "postgres" else "postgresql"
    if name == "postgresql":
        return url.set(drivername="postgresql+psycopg")
    if name == "sqlite":
        return url
    raise _no_store(shown(text))


def engine_of(url: URL, wait_s: float, *, create: bool, read_only: bool) -> Engine:
    """Creates the engine, not yet connected. Raises STO-FILE for a missing file, STO-DRIVER without psycopg."""
    if url.get_backend_name() == "postgresql":
        return _postgresql(url, wait_s, read_only)
    if url.database in (None, "", ":memory:"):
        engine = create_engine("sqlite://", poolclass=StaticPool, connect_args={"check_same_thread": False})
    else:
        engine = _sqlite_file(url, create, read_only)
    _set_up_sqlite(engine, wait_s)
    return engine


def _sqlite_file(url: URL, create: bool, read_only: bool) -> Engine:
    path = Path(str(url.database))
    try:
        usable = stat.S_ISREG(path.stat().st_mode)
    except OSError:  # another process may make it between two looks
        usable = create
    if not usable:
        raise Code.STO_FILE.refusal(
            f"there is no store '{path}'",
            hint=f"make it by `trueloop db init {shell_word(str(path))}`, or name another by --db",
        )
    mode = "ro" if read_only else "rwc" if create else "rw"
    uri = f"file:{quote(str(path.absolute()))}?mode={mode}"

    def connect() -> sqlite3.Connection:
        return sqlite3.connect(uri, uri=True, check_same_thread=False)

    return create_engine(url, creator=connect, pool_size=HELD_OPEN, max_overflow=-1)


def _set_up_sqlite(engine: Engine, wait_s: float) -> None:
    @event.listens_for(engine, "connect")
    def connected(connection: Any, _: object) -> None:
        connection.isolation_level = None  # the transactions are ours: `began`
        connection.execute(f"PRAGMA busy_timeout = {int(wait_s * 1000)}")
        for pragma in _SQLITE:
            connection.execute(pragma)

    @event.listens_for(engine, "begin")
    def began(connection: Connection) -> None:
        writing = connection.get_execution_options().get(WRITING, False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if writing else "BEGIN")


def _postgresql(url: URL, wait_s: float, read_only: bool) -> Engine:
    try:
        import psycopg  # noqa: F401
    except ImportError:
        raise Code.STO_DRIVER.refusal(
            "a store in PostgreSQL needs the package 'psycopg'", hint=f"install it: {install_command('postgresql')}"
        ) from None
    settings = {
        "lock_timeout": f"{int(wait_s * 1000)}",
        "idle_in_transaction_session_timeout": "60000",
        "synchronous_commit": "on",
        "default_transaction_read_only": "on" if read_only else "off",
    }
    given = {"connect_timeout": _REACHED_S, "tcp_user_timeout": 30_000, "client_encoding": "utf8"}
    engine = create_engine(url, pool_pre_ping=True, connect_args=given)

    @event.listens_for(engine, "connect")
    def connected(connection: Any, _: object) -> None:
        for name, value in settings.items():
            connection.execute(f"SET {name} = '{value}'")
        connection.commit()

    @event.listens_for(engine, "begin")
    def began(connection: Connection) -> None:
        if connection.get_execution_options().get(WRITING, False):
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_TURN})")
        else:  # what is read in several steps is of one moment
            connection.exec_driver_sql("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ, READ ONLY")

    return engine


def _no_store(name: str, hint: str = "give a file, or postgresql://user@host/database") -> TrueloopError:
    return Code.STO_FILE.refusal(f"{name!r} is neither a file, nor SQLite, nor PostgreSQL", hint=hint)
