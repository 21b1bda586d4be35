"""Every way in which `trueloop db` refuses files and stores."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.jobs.db.imported import import_files
from trueloop.jobs.db.inspected import Inspected
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.store.opened import made
from trueloop.storage.store import open_store

MODBAS2 = Path(__file__).parents[2] / "examples" / "modbas2"


def _imported(path: Path, *serials: str) -> None:
    store = open_store("sqlite://", create=True, codec=store_codec())
    for serial in serials:
        list(import_files(store, [path], Inspected(MODBAS2 / "job.toml", serial)))


def _exists() -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "trueloop.db"
        file.write_text("something")
        made(str(file))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.STO_EXISTS: _exists,
    Code.STO_IMPORT: lambda: _imported(MODBAS2 / "touch.csv", "2511"),
    Code.STO_PART: lambda: _imported(MODBAS2 / "touches.csv", ""),
    Code.STO_OTHER_PART: lambda: _imported(MODBAS2 / "touches.csv", "2511", "2512"),
}
