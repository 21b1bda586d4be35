"""Every way in which `trueloop db` refuses files and stores."""

import sqlite3
import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.domain.life import InspectionLink
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code
from trueloop.jobs.db.copied import read_export
from trueloop.jobs.db.found import named
from trueloop.jobs.db.imported import InspectionOptions, check_store, import_files
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.opened import make_store
from trueloop.storage.store import keep, open_store

MODBAS2 = Path(__file__).parents[2] / "examples" / "modbas2"


def _imported(path: Path, *serials: str) -> None:
    store = open_store("sqlite://", create=True, codec=store_codec())
    for serial in serials:
        list(import_files(store, [path], InspectionOptions(MODBAS2 / "job.toml", serial)))


def _exists() -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trueloop.db"
        file.write_text("something")
        make_store(str(file))


def _export(text: str) -> object:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "all.jsonl"
        file.write_text('{"format": "trueloop store", "version": 1}\n' + text)
        return list(read_export(file, store_codec()))


def _several() -> object:
    store = open_store("sqlite://", create=True, codec=store_codec())
    keep(store, [Part(PartType("shaft"), "17"), Part(PartType("bush"), "17")])
    return named(store, "17")


def _damaged() -> object:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trueloop.db"
        keep(open_store(file, create=True), [Part(PartType("shaft"), "17")])
        with sqlite3.connect(file) as connection:
            for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall():
                connection.execute(f"DROP TRIGGER {name}")
            connection.execute("UPDATE part SET document = substr(document, 1, 40)")
        connection.close()
        return check_store(open_store(file)).findings


def _lost() -> object:
    store = open_store("sqlite://", create=True)
    keep(store, [InspectionLink(("1" * 64, "shaft", "", "17", ""), ("shaft", "", "17", "finish", ""))])
    return check_store(store).findings


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.STO_EXISTS: _exists,
    Code.STO_IMPORT: lambda: _imported(MODBAS2 / "touch.csv", "2511"),
    Code.STO_PART: lambda: _imported(MODBAS2 / "touches.csv", ""),
    Code.STO_OTHER_PART: lambda: _imported(MODBAS2 / "touches.csv", "2511", "2512"),
    Code.STO_EXPORT: lambda: _export('{"kind": "part_type", "row": 1, "kept'),
    Code.STO_SEVERAL: _several,
    Code.STO_DAMAGED: _damaged,
    Code.STO_LOST: _lost,
}
