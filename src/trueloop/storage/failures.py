"""Failures of a database as refusals: STO-BUSY, STO-WRITE, STO-FILE, and STO-TEXT for what was given to it."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from trueloop.errors import Code, TrueloopError

AWAY: Final = frozenset((Code.STO_FILE, Code.STO_SCHEMA, Code.STO_BUSY, Code.STO_WRITE))
"""Refusals that the state of the store causes and not what it was given: the same request may be taken later."""
_SQLITE: Final = {
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
    Code.STO_WRITE: "make room, or see that the file and its folder may be written; nothing was kept",
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
    return TrueloopError(code, f"the store {where!r} {what}: {_first_line(cause)}", hint=_HINTS[code])


def _code(cause: BaseException) -> Code:
    if isinstance(cause, sqlite3.Error):
        return _SQLITE.get((getattr(cause, "sqlite_errorcode", 0) or 0) & 0xFF, Code.STO_FILE)
    state = str(getattr(cause, "sqlstate", None) or "")
    if not state and type(cause).__name__ == "DataError":  # refused by the driver, before the server saw it
        return Code.STO_TEXT
    return _POSTGRESQL.get(state, _POSTGRESQL.get(state[:2], Code.STO_FILE))


def _first_line(cause: BaseException) -> str:
    return str(cause).strip().partition("\n")[0] or type(cause).__name__
