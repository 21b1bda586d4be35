"""The migrations make the tables that the program knows; a store of another schema is refused or migrated."""

import shutil
import sqlite3
from pathlib import Path
from typing import Any

import psycopg
import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine, create_engine, inspect

from tests.support.postgresql import Server
from tests.support.records import TURNED
from tests.support.stores import AT, cut, link, part, touched
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import BothInspections, Inspection, MachineStood, Reading, StandardPart
from trueloop.domain.life import Cut, InspectionLink
from trueloop.domain.part import PartType
from trueloop.domain.proposal import ModelDecision, ModelVersion
from trueloop.domain.record import Correction, sha256_of
from trueloop.domain.tool import Machine
from trueloop.errors import Code, TrueloopError
from trueloop.storage import schema
from trueloop.storage.integrity import damage
from trueloop.storage.schema import LOGS, METADATA, STATES
from trueloop.storage.store import find, keep, life, open_store

FIRST = Path(__file__).with_name("first.sql")
FIRST_IN_POSTGRESQL = Path(__file__).with_name("first.postgresql.sql")
NEWEST = schema.TODAY
ADDED = ("both_inspections", "model_decision", "model_version", "standard_part")
"""Tables of the second schema."""
THIRD = ("work_order", "run", "run_fact", *(table.name for table in (*LOGS, *STATES)))


def test_the_migrations_lead_to_the_tables_of_today() -> None:
    store = open_store("sqlite://", create=True)
    with store.reading() as connection:
        context = MigrationContext.configure(connection, opts={"version_table": "trueloop_schema"})
        assert compare_metadata(context, METADATA) == []


def test_a_new_file_is_made_as_all_migrations_make_it() -> None:
    """Those of a later version are added by `NEW_FILE.write_text(statements_of(connection))`, migrated from nothing."""
    with create_engine("sqlite://").begin() as migrated:
        schema.migrate_to("head", migrated)
        assert schema.NEW_FILE.read_text("utf-8") == schema.statements_of(migrated)
    with open_store("sqlite://", create=True).reading() as connection:
        assert schema.statements_of(connection) == schema.NEW_FILE.read_text("utf-8")


def test_the_newest_migration_is_the_schema_of_today() -> None:
    scripts = ScriptDirectory(str(Path(schema.__file__).with_name("migrations")))
    assert scripts.get_heads() == [schema.TODAY]


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


NEXT = '''"""A schema to come: cuts with a remark."""
import sqlalchemy as sa
from alembic import op

revision = "9998"
down_revision = "{before}"


def upgrade() -> None:
    op.add_column("cut", sa.Column("remark", sa.Text))
'''


@pytest.fixture
def to_come(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A version of trueloop with a schema more."""
    scripts = tmp_path / "migrations"
    shutil.copytree(Path(schema.__file__).with_name("migrations"), scripts)
    (scripts / "versions" / "v9998_remark.py").write_text(NEXT.format(before=schema.TODAY))
    monkeypatch.setattr(schema, "_SCRIPTS", scripts)
    monkeypatch.setattr(schema, "TODAY", "9998")


def test_a_store_is_migrated_with_what_it_holds(place: str, request: pytest.FixtureRequest) -> None:
    store = open_store(place, create=True)
    keep(store, [touched(), cut(), link(touched(), cut())])
    before = [find(store, kind) for kind in (Inspection, Cut, InspectionLink, PartType)]
    store.close()
    request.getfixturevalue("to_come")
    with pytest.raises(TrueloopError, match=rf"schema {NEWEST}.*9998") as refused:
        open_store(place, read_only=True)
    assert refused.value.code is Code.STO_SCHEMA
    store = open_store(place, create="://" in place)
    assert [find(store, kind) for kind in (Inspection, Cut, InspectionLink, PartType)] == before
    with store.reading() as connection:
        assert connection.exec_driver_sql("SELECT remark FROM cut").scalar() is None
    assert damage(store) == []
    with pytest.raises(Exception, match="append-only"), store.writing() as connection:
        connection.exec_driver_sql("UPDATE cut SET remark = 'x'")
    store.close()


def test_a_shared_database_is_not_migrated_by_the_way(server: Server, request: pytest.FixtureRequest) -> None:
    place = server.new_database()
    open_store(place, create=True).close()
    request.getfixturevalue("to_come")
    with pytest.raises(TrueloopError, match=rf"schema {NEWEST}.*9998") as refused:
        open_store(place)
    assert refused.value.code is Code.STO_SCHEMA


def first_schema(place: str) -> Engine:
    """`first.sql` and `first.postgresql.sql` were dumped from stores of the first schema: they never change."""
    if "://" not in place:
        connection = sqlite3.connect(place)
        connection.executescript(FIRST.read_text(encoding="utf-8"))
        connection.close()
        return create_engine(f"sqlite:///{place}")
    with psycopg.connect(place, autocommit=True) as server:
        server.execute(FIRST_IN_POSTGRESQL.read_bytes())
    return create_engine(place.replace("postgresql:", "postgresql+psycopg:"))


def rows(engine: Engine) -> dict[str, list[tuple[Any, ...]]]:
    """All that each table holds, but for the number of the schema."""
    with engine.connect() as connection:
        tables = sorted(set(inspect(connection).get_table_names()) - {"trueloop_schema"})
        found = {
            name: sorted(map(tuple, connection.exec_driver_sql(f"SELECT * FROM {name}")), key=repr) for name in tables
        }
    engine.dispose()
    return found


def test_a_store_of_the_first_schema_keeps_every_row_of_every_table(place: str) -> None:
    engine = first_schema(place)
    before = rows(engine)
    assert sum(map(len, before.values())) == 23
    open_store(place, create="://" in place).close()
    after = rows(engine)
    assert {name: after[name] for name in before} == before
    assert {name: after[name] for name in after if name not in before} == {name: [] for name in (*ADDED, *THIRD)}


def test_a_store_of_the_first_schema_is_read_as_it_was_written(place: str) -> None:
    first_schema(place).dispose()
    store = open_store(place, create="://" in place)
    assert [one.value for one in find(store, Inspection)] == [touched("17"), touched("18", shift_mm=0.001)]
    assert [one.superseded_by for one in find(store, Inspection, superseded=True)] == [None, 3, None]
    assert [one.value for one in find(store, Cut)] == [cut()]
    assert life(store, part("17")).cut_of(touched("17")) == cut()
    assert [one.value.record.id for one in find(store, Correction)] == [TURNED.id]
    assert damage(store) == []
    assert [one.new for one in keep(store, [touched("17"), cut(), touched("19")])] == [False, False, True]
    store.close()


def test_a_store_of_the_first_schema_takes_what_a_diagnosis_keeps(place: str) -> None:
    first_schema(place).dispose()
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
    for table in ADDED:
        with pytest.raises(Exception, match="append-only"), store.writing() as connection:
            connection.exec_driver_sql(f"DELETE FROM {table}")
    store.close()


def test_an_account_of_the_third_schema_is_shown_millimetres(place: str) -> None:
    first_schema(place).dispose()
    engine = create_engine(
        place.replace("postgresql:", "postgresql+psycopg:") if "://" in place else f"sqlite:///{place}"
    )
    with engine.begin() as connection:
        schema.migrate_to("0003", connection)
        connection.exec_driver_sql(
            "INSERT INTO account (name, display, argon2id, role, language, created_at, disabled, version) "
            "VALUES ('ana', 'Ana', '', 'viewer', 'de', '2026-01-02T08:00:00.000000+00:00', 0, 3)"
        )
    engine.dispose()
    store = open_store(place, create="://" in place)
    with store.reading() as connection:
        (account,) = connection.exec_driver_sql("SELECT name, language, version, unit FROM account").all()
    assert tuple(account) == ("ana", "de", 3, "mm")
    store.close()
