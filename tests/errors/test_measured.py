"""Every way in which an inspection file is refused."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import Stated
from trueloop.formats.inspections.text import number_in


def _read(content: bytes, name: str) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        return read_measured_file(path, Stated())


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MSR_FILE: lambda: read_measured_file(Path("/nowhere/part.dmo"), Stated()),
    Code.MSR_FORMAT: lambda: _read(b"Dear colleague,\nthe part is fine.\n", "letter.txt"),
    Code.MSR_NUMBER: lambda: number_in("1,234.5", Path("report.txt"), 7),
}
