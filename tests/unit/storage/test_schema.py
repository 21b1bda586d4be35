"""The migrations make the tables that the program knows; a store of another schema is refused or migrated."""

from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import create_engine

from trueloop.errors import Code, TrueloopError
from trueloop.storage import schema
from trueloop.storage.store import open_store
from trueloop.storage.tables import METADATA


def test_the_migrations_lead_to_the_tables_of_today() -> None:
    store = open_store("sqlite://", create=True)
    with store.reading() as connection:
        context = MigrationContext.configure(connection, opts={"version_table": "trueloop_schema"})
        assert compare_metadata(context, METADATA) == []


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
