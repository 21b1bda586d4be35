"""Every way in which an inspection file is refused."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from trueloop.errors import Code
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import Stated, Unit
from trueloop.formats.inspections.text import number_in


def _read(content: bytes, name: str, mapping: str = "", unit: Unit | None = None) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path, stated = Path(folder) / name, Path(folder) / "meaning.toml"
        path.write_bytes(content)
        stated.write_text(mapping, encoding="utf-8")
        return read_measured_file(path, Stated(unit, stated if mapping else None))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MSR_FILE: lambda: read_measured_file(Path("/nowhere/part.dmo"), Stated()),
    Code.MSR_SIZE: lambda: _read(b"<QIFDocument>" + b"<a>" * 300, "deep.qif"),
    Code.MSR_FORMAT: lambda: _read(b"Dear colleague,\nthe part is fine.\n", "letter.txt"),
    Code.MSR_UNIT: lambda: _read(b"1 2 3 0 0 0 0 0 0\n", "probe.txt"),
    Code.MSR_MEANING: lambda: _read(b"#500=29.991\n#501=\n", "macro.txt"),
    Code.MSR_MAPPING: lambda: _read(b"#500=29.991\n", "macro.txt", "[variables.500]\nquantity = 'girth'\n"),
    Code.MSR_VALUE: lambda: _read(b"#500=1.\n", "macro.txt", "[variables.501]\nquantity = 'length'\n", "mm"),
    Code.MSR_NUMBER: lambda: number_in("1,234.5", Path("report.txt"), 7),
    Code.MSR_TIME: lambda: _read(b"date,nominal [mm],actual [mm]\n03/04/2026,25,25.01\n", "part.csv"),
    Code.MSR_LIMITS: lambda: _read(b"upper limit [mm];lower limit [mm];actual [mm]\n24,9;25,1;25\n", "part.csv"),
}
