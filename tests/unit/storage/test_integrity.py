"""What was changed behind the store's back is noticed; a store that cannot be written stays as it was."""

import hashlib
import sqlite3
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.stores import cut, touched
from trueloop.domain.inspection import Inspection, Touch
from trueloop.errors import Code, TrueloopError
from trueloop.storage.integrity import damage
from trueloop.storage.store import Store, find, keep, open_store

ROOT = Path(__file__).parents[3]


def _without_guards(file: Path, change: str) -> None:
    connection = sqlite3.connect(file)
    for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall():
        connection.execute(f"DROP TRIGGER {name}")
    connection.execute(change)
    connection.commit()
    connection.close()


@pytest.mark.parametrize(
    ("change", "table"),
    [
        ("UPDATE touch SET error_mm = error_mm + 1e-17 WHERE position = 1", "inspection"),
        ("UPDATE touch SET position = 7 WHERE position = 2", "inspection"),
        ("DELETE FROM touch WHERE position = 2", "inspection"),
        ("INSERT INTO touch (inspection, position, point) VALUES (1, 3, 'x')", "inspection"),
        ("UPDATE cut SET document = replace(document, 'finish', 'rough')", "cut"),
        ("DELETE FROM inspection", "touch"),
    ],
)
def test_what_was_changed_behind_its_back_is_found(tmp_path: Path, change: str, table: str) -> None:
    file = tmp_path / "trueloop.db"
    store = open_store(file, create=True)
    keep(store, [touched(), cut()])
    assert damage(store) == []
    _without_guards(file, change)
    assert table in {one.table for one in damage(store)}


@pytest.mark.parametrize("count", [1, 99, 100, 10_000, 25_003])
def test_many_values_are_hashed_alike_when_written_and_when_read(place: str, count: int) -> None:
    store = open_store(place, create=True)
    given = touched(count=count)
    keep(store, [given])
    assert damage(store) == []
    assert find(store, Inspection)[0].value == given
    store.close()


def test_the_hash_is_of_the_bits_of_what_is_stated_and_of_nan_where_nothing_is(store: Store) -> None:
    """By hand: the document, positions, names, nominal and measured places and errors by column, lines, `exact`."""
    values = tuple(Touch(str(k), (10.0 + k / 3, -k / 7), error_mm=(None, k / 7e6)[k % 2]) for k in range(3))
    (kept,) = keep(store, [replace(touched(), values=values)])
    with store.reading() as connection:
        document, sha = connection.exec_driver_sql(
            f"SELECT document, sha256 FROM inspection WHERE id = {kept.row}"
        ).one()
    nothing = struct.pack("<Q", 0x7FF8_0000_0000_0000)
    x, z = (b"".join(struct.pack("<d", one.nominal_mm[k]) for one in values) for k in (0, 1))
    errors = nothing + struct.pack("<d", 1 / 7e6) + nothing
    said = (b'[0,1,2]["0","1","2"][null,null,null]', x, z, 6 * nothing, errors, 2 * b"[null,null,null]")
    assert hashlib.sha256(document.encode() + b"".join(said)).hexdigest() == sha


def test_a_page_that_was_overwritten_is_found_or_refused(tmp_path: Path) -> None:
    file = tmp_path / "trueloop.db"
    store = open_store(file, create=True)
    keep(store, [touched(count=5_000)])
    with file.open("r+b") as opened:
        opened.seek(file.stat().st_size - 3 * 4096)
        opened.write(b"\xa5" * 4096)
    try:
        assert damage(store)
    except TrueloopError as refused:
        assert refused.code is Code.STO_FILE


SMALL = """
import resource, sys
from tests.support.stores import touched
from trueloop.errors import TrueloopError
from trueloop.storage.store import keep, open_store
store = open_store(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))
try:
    keep(store, [touched("18", count=50_000)])
except TrueloopError as refused:
    print(refused.code)
"""


def test_where_there_is_no_room_nothing_is_half_written(tmp_path: Path) -> None:
    file = tmp_path / "trueloop.db"
    store = open_store(file, create=True)
    keep(store, [touched()])
    done = subprocess.run(
        [sys.executable, "-c", SMALL, file], cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.stdout.strip() == "STO-WRITE", done.stdout + done.stderr
    assert [one.value for one in find(store, Inspection)] == [touched()]
    assert damage(store) == []
    assert keep(store, [touched("18", count=50_000)])[0].new


def test_a_database_that_is_full_refuses(tmp_path: Path) -> None:
    store = open_store(tmp_path / "trueloop.db", create=True)
    keep(store, [touched()])
    with pytest.raises(TrueloopError) as refused, store.writing() as connection:
        connection.exec_driver_sql("PRAGMA max_page_count = 1")
        _fill(connection.exec_driver_sql)
    assert refused.value.code is Code.STO_WRITE
    assert [one.value for one in find(store, Inspection)] == [touched()]


def _fill(run: Callable[[str], object]) -> None:
    for k in range(10_000):
        run(f"INSERT INTO touch (inspection, position, point) VALUES (1, {k + 10}, '{'x' * 500}')")


def test_a_store_opened_to_be_read_is_not_written(tmp_path: Path) -> None:
    file = tmp_path / "trueloop.db"
    keep(open_store(file, create=True), [touched()])
    before = file.read_bytes()
    store = open_store(file, read_only=True)
    with pytest.raises(TrueloopError) as refused:
        keep(store, [touched("18")])
    assert refused.value.code is Code.STO_WRITE
    assert [one.value for one in find(store, Inspection)] == [touched()]
    assert file.read_bytes() == before
