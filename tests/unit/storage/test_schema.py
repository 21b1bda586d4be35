"""A new store has the tables of the published schema; a store of another schema is refused."""

import sqlite3
from pathlib import Path
from typing import Any

import psycopg
import pytest
from sqlalchemy import Engine, create_engine, inspect

from tests.support.postgresql import Server
from tests.support.records import TURNED
from tests.support.stores import AT, cut, part, touched
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import BothInspections, Inspection, MachineStood, Reading, StandardPart
from trueloop.domain.life import Cut
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.record import Correction, sha256_of
from trueloop.domain.tool import Machine
from trueloop.errors import Code, TrueloopError
from trueloop.storage import schema
from trueloop.storage.integrity import damage
from trueloop.storage.schema import METADATA
from trueloop.storage.store import find, keep, life, open_store

PUBLISHED = Path(__file__).with_name("published.sql")
PUBLISHED_IN_POSTGRESQL = Path(__file__).with_name("published.postgresql.sql")
DIAGNOSED = ("both_inspections", "model_decision", "model_version", "standard_part")


def described(engine: Engine) -> dict[str, Any]:
    """Columns, keys, constraints and indexes of each table, and the triggers, as the database has them."""
    look = inspect(engine)
    tables: dict[str, Any] = {
        table: (
            [(one["name"], str(one["type"]), one["nullable"], str(one["default"])) for one in look.get_columns(table)],
            look.get_pk_constraint(table)["constrained_columns"],
            sorted(str((one["constrained_columns"], one["referred_table"])) for one in look.get_foreign_keys(table)),
            sorted(str((one["name"], one["column_names"])) for one in look.get_unique_constraints(table)),
            sorted(str((one["name"], one["column_names"])) for one in look.get_indexes(table)),
            sorted(str(one["name"]) for one in look.get_check_constraints(table)),
        )
        for table in look.get_table_names()
    }
    if engine.dialect.name == "sqlite":
        triggers = "SELECT name, tbl_name FROM sqlite_master WHERE type = 'trigger'"
    else:
        triggers = "SELECT DISTINCT tgname, tgrelid::regclass::text FROM pg_trigger WHERE NOT tgisinternal"
    with engine.connect() as connection:
        guards = sorted(map(tuple, connection.exec_driver_sql(triggers)))
    engine.dispose()
    return {**tables, "triggers": guards}


def test_a_new_store_has_the_tables_of_the_published_schema(place: str, server: Server, tmp_path: Path) -> None:
    published_store(place)
    new = server.new_database() if "://" in place else str(tmp_path / "new.db")
    open_store(new, create=True).close()
    published, made = described(engine_at(place)), described(engine_at(new))
    assert made == published
    assert made["trueloop_schema"]
    assert set(made) == {"triggers", "trueloop_schema", *METADATA.tables}


def test_a_database_of_something_else_is_left_alone(tmp_path: Path) -> None:
    other = create_engine(f"sqlite:///{tmp_path}/other.db")
    with other.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE songs (title TEXT)")
    other.dispose()
    before = (tmp_path / "other.db").read_bytes()
    for create in (False, True):
        with pytest.raises(TrueloopError) as refused:
            open_store(tmp_path / "other.db", create=create)
        assert refused.value.code is Code.STO_FILE
    assert (tmp_path / "other.db").read_bytes() == before


def test_a_file_that_is_no_database_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "touches.csv"
    file.write_text("point,x,z\n" * 200)
    for create in (False, True):
        with pytest.raises(TrueloopError) as refused:
            open_store(file, create=create)
        assert refused.value.code is Code.STO_FILE
    assert file.read_text() == "point,x,z\n" * 200
    with pytest.raises(TrueloopError):
        open_store(tmp_path, create=True)


def test_making_a_store_where_one_is_changes_nothing(tmp_path: Path) -> None:
    open_store(tmp_path / "trueloop.db", create=True)
    before = (tmp_path / "trueloop.db").read_bytes()
    open_store(tmp_path / "trueloop.db", create=True)
    assert (tmp_path / "trueloop.db").read_bytes() == before


@pytest.mark.parametrize("number", ["0005", "9999"])
@pytest.mark.parametrize("how", [{}, {"read_only": True}, {"create": True}])
def test_a_store_of_another_schema_is_refused_and_left_as_it_is(place: str, number: str, how: dict[str, Any]) -> None:
    open_store(place, create=True).close()
    engine = engine_at(place)
    with engine.begin() as connection:
        connection.exec_driver_sql(f"UPDATE trueloop_schema SET version_num = '{number}'")
    before = described(engine)
    with pytest.raises(TrueloopError, match=f"schema {number}.*{schema.TODAY}") as refused:
        open_store(place, **how)
    assert refused.value.code is Code.STO_SCHEMA
    assert ("db restore" in refused.value.hint) == (number < schema.TODAY)
    assert described(engine) == before


def engine_at(place: str) -> Engine:
    where = place.replace("postgresql:", "postgresql+psycopg:") if "://" in place else f"sqlite:///{place}"
    return create_engine(where)


def published_store(place: str) -> Engine:
    """The SQL files were dumped from stores of the first published schema: they never change."""
    if "://" not in place:
        connection = sqlite3.connect(place)
        connection.executescript(PUBLISHED.read_text(encoding="utf-8"))
        connection.close()
    else:
        with psycopg.connect(place, autocommit=True) as server:
            server.execute(PUBLISHED_IN_POSTGRESQL.read_bytes())
    return engine_at(place)


def rows(engine: Engine) -> dict[str, list[tuple[Any, ...]]]:
    """All that each table holds, but for the number of the schema."""
    with engine.connect() as connection:
        tables = sorted(set(inspect(connection).get_table_names()) - {"trueloop_schema"})
        found = {
            name: sorted(map(tuple, connection.exec_driver_sql(f"SELECT * FROM {name}")), key=repr) for name in tables
        }
    engine.dispose()
    return found


def test_a_store_of_the_published_schema_keeps_every_row_of_every_table(place: str) -> None:
    engine = published_store(place)
    before = rows(engine)
    assert sum(map(len, before.values())) == 23
    open_store(place, create="://" in place).close()
    after = rows(engine)
    assert after == before


def test_a_store_of_the_published_schema_is_read_as_it_was_written(place: str) -> None:
    published_store(place).dispose()
    store = open_store(place, create="://" in place)
    assert [one.value for one in find(store, Inspection)] == [touched("17"), touched("18", shift_mm=0.001)]
    assert [one.superseded_by for one in find(store, Inspection, superseded=True)] == [None, 3, None]
    assert [one.value for one in find(store, Cut)] == [cut()]
    assert life(store, part("17")).cut_of(touched("17")) == cut()
    assert [one.value.record.id for one in find(store, Correction)] == [TURNED.id]
    assert damage(store) == []
    assert [one.new for one in keep(store, [touched("17"), cut(), touched("19")])] == [False, False, True]
    store.close()


def test_a_store_of_the_published_schema_takes_what_a_diagnosis_keeps(place: str) -> None:
    published_store(place).dispose()
    store = open_store(place, create="://" in place)
    lathe, text = Machine("lathe", "7"), '{"trueloop": 1}'
    stood = MachineStood((0.1, 0.0, -250.0), ((80.0, 0.0, 160.0),), {"T1": 20.7})
    on_machine, on_cmm = touched("17"), touched("17", sha256="3" * 64)
    given = [
        BothInspections(part("17"), lathe, on_machine.identity, on_cmm.identity, stood, stood, "4" * 64, True),
        ModelVersion(lathe, sha256_of(text.encode()), text, "4" * 64, ("EXX",), "why", "better", AT, "ana"),
        ModelDecision(sha256_of(text.encode()), "accepted", "ana", AT, "looked at"),
        StandardPart(part("master"), (Reading("d1", Quantity.DIAMETER, 40.0012, standard_u=0.0004),), AT, "lab"),
    ]
    assert all(one.new for one in keep(store, given))
    assert [[one.value for one in find(store, type(value))] for value in given] == [[value] for value in given]
    assert damage(store) == []
    for table in DIAGNOSED:
        with pytest.raises(Exception, match="append-only"), store.writing() as connection:
            connection.exec_driver_sql(f"DELETE FROM {table}")
    store.close()
