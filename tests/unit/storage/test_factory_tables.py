"""Tables of the factory: an export holds values alone, a backup of a file all; logs take no change."""

import sqlite3
from contextlib import closing
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import insert

from trueloop.domain.factory import Block, BlockKind, FactKind, Route, Run, RunFact, WorkOrder
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Machine
from trueloop.jobs.db.copied import back_up, export, keep_lines, read_export
from trueloop.storage.schema import ACCOUNT, API_KEY, EVENT, PROGRAM_RELEASE, stamp
from trueloop.storage.store import Store, find, keep, open_store

AT = datetime(2026, 3, 4, 5, 6, 7, tzinfo=UTC)
TYPE, LATHE = PartType("shaft", "B"), Machine("lathe", "7")
ROUTE = Route((Block(BlockKind.SEMIFINISH, "1" * 64, "dome"), Block(BlockKind.CORRECT), Block(BlockKind.REMOVE)), "x=1")
ORDER = WorkOrder("17", TYPE, LATHE, ("a", "b"), ROUTE, AT, "ana")
RUN = Run("key", "17", Part(TYPE, "a"), 0, 1, LATHE, "1" * 64)
FACT = RunFact("key", FactKind.STARTED, AT, "program", {"line": "3"})
SECRET = "5ecret0f5omebody"


def filled(store: Store) -> None:
    keep(store, [ORDER, RUN, FACT])
    with store.writing() as connection:
        common = {"display": "Ana", "role": "viewer", "language": "en", "created_at": stamp(AT)}
        connection.execute(insert(ACCOUNT).values(name="ana", argon2id=SECRET, disabled=0, version=1, **common))
        key = {"machine": "lathe", "name": "cell", "key_sha256": SECRET, "scope": "cell", "expires_at": stamp(AT)}
        connection.execute(insert(API_KEY).values(made_by="ana", created_at=stamp(AT), **key))
        said = {"at": stamp(AT), "who": "ana", "what": "released", "subject": "program:1", "document": "{}"}
        connection.execute(insert(EVENT).values(**said))


def test_orders_runs_and_facts_come_back(store: Store) -> None:
    keep(store, [ORDER, RUN, FACT])
    found: list[Any] = [one.value for kind in (WorkOrder, Run, RunFact) for one in find(store, kind)]
    assert found == [ORDER, RUN, FACT]
    assert [one.value for one in find(store, Part)] == [Part(TYPE, "a"), Part(TYPE, "b")]
    assert not keep(store, [FACT])[0].new


def test_an_export_holds_values_and_no_account(store: Store, tmp_path: Path) -> None:
    filled(store)
    export(store, tmp_path / "all.jsonl")
    assert SECRET.encode() not in (tmp_path / "all.jsonl").read_bytes()
    other = open_store("sqlite://", create=True)
    keep_lines(other, read_export(tmp_path / "all.jsonl", other.codec), lambda _: None, "all")
    assert [one.value for one in find(other, WorkOrder)] == [ORDER]
    with other.reading() as connection:
        assert connection.exec_driver_sql("SELECT count(*) FROM account").scalar() == 0


def test_a_backup_of_a_file_holds_all(tmp_path: Path) -> None:
    store = open_store(tmp_path / "here.db", create=True)
    filled(store)
    back_up(store, tmp_path / "there.db", lambda _: None)
    with closing(sqlite3.connect(tmp_path / "there.db")) as copy:
        assert copy.execute("SELECT name FROM account").fetchall() == [("ana",)]
        assert copy.execute("SELECT what FROM event").fetchall() == [("released",)]
    store.close()


def test_a_log_takes_no_change(store: Store) -> None:
    filled(store)
    with store.writing() as connection:
        given = {"at": stamp(AT), "who": "ana", "why": "looked at"}
        connection.execute(insert(PROGRAM_RELEASE).values(program_sha256="1" * 64, **given))
    for change in ("DELETE FROM event", "UPDATE event SET who = 'ben'", "DELETE FROM program_release"):
        with pytest.raises(Exception, match="append-only"), store.writing() as connection:
            connection.exec_driver_sql(change)


def test_times_sort_as_they_follow_each_other() -> None:
    zone = timezone(timedelta(hours=5))
    times = [AT, AT + timedelta(microseconds=1), AT + timedelta(seconds=1), (AT + timedelta(hours=1)).astimezone(zone)]
    assert sorted(map(stamp, times)) == list(map(stamp, times))
    with pytest.raises(ValueError, match="no zone"):
        stamp(datetime(2026, 1, 1))
