"""Every way in which the store refuses."""

import sqlite3
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import psycopg

from tests.support.stores import touched
from trueloop.errors import Code
from trueloop.storage.engines import understood
from trueloop.storage.store import Store, keep, open_store


def _path(name: str = "trueloop.db") -> Path:
    return Path(tempfile.mkdtemp()) / name


def _made(read_only: bool = False) -> Store:
    path = _path()
    open_store(path, create=True)
    return open_store(path, read_only=read_only, wait_s=0.05)


def _newer() -> object:
    store = _made()
    with sqlite3.connect(store.where) as connection:
        connection.execute("UPDATE trueloop_schema SET version_num = '9999'")
    connection.close()
    return open_store(store.where)


def _busy() -> object:
    store = _made()
    with store.writing():
        return keep(store, [touched()])


def _nul() -> None:
    with understood("postgresql://plant/trueloop"):
        raise psycopg.DataError("PostgreSQL text fields cannot contain NUL (0x00) bytes")


def _differs() -> object:
    store = _made()
    keep(store, [touched()])
    return keep(store, [touched(shift_mm=0.001)])


def _without_driver() -> object:
    with mock.patch.dict(sys.modules, {"psycopg": None}):
        return open_store("postgresql://ana@plant/trueloop")


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.STO_FILE: lambda: open_store(_path()),
    Code.STO_SCHEMA: _newer,
    Code.STO_BUSY: _busy,
    Code.STO_WRITE: lambda: keep(_made(read_only=True), [touched()]),
    Code.STO_TEXT: _nul,
    Code.STO_DIFFERS: _differs,
    Code.STO_UNKNOWN: lambda: keep(_made(), [touched()], supersedes=77),
    Code.STO_DRIVER: _without_driver,
}
