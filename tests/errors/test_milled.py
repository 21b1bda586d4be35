"""Every way in which a milled part's job, measurements and records are refused."""

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.examples import copy_example
from trueloop.jobs.milled import KIND, entries_for_next_part, read_milled

MEASURED = '[[measured]]\nfile = "part-1.dmo"\n'


def _job(change: Callable[[str], str], record: object = None) -> object:
    folder = Path(tempfile.mkdtemp()) / "plate"
    copy_example("plate", folder)
    path = folder / "plate.toml"
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
    (folder / "entries.json").write_text(json.dumps(record), encoding="utf-8")
    return entries_for_next_part(read_milled(path))


def _second(entered: str) -> Callable[[str], str]:
    return lambda text: text + "\n" + MEASURED + entered


OTHER = {"kind": KIND, "part_type": "cover", "entries": []}
SHIFTED = {
    "kind": KIND,
    "part_type": "plate",
    "entries": [{"register": "x", "of": "G54", "change": 0.03, "unit": "mm"}],
}

PRODUCERS = {
    Code.MIL_NOMINAL: lambda: _job(lambda text: text.replace("size = 12.0", "size = 13.0")),
    Code.MIL_NONE: lambda: _job(lambda text: text.replace('name = "', 'name = "my ')),
    Code.MIL_LARGE: lambda: _job(lambda text: text + "\n[limits]\ndeviation_um = 30\n"),
    Code.MIL_ENTRY: lambda: _job(lambda text: text + "\n[limits]\nentry_um = 15\n"),
    Code.MIL_ENTERED: lambda: _job(_second("")),
    Code.MIL_CONTRADICTED: lambda: _job(_second('entered = ["entries.json"]\n'), SHIFTED),
    Code.MIL_RECORD: lambda: _job(_second('entered = ["entries.json"]\n'), OTHER),
}
