"""Every way in which an inspection file is refused."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.support.shaft import SHAFT, write_job
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts, Unit
from trueloop.formats.inspections.shared.text import number_in
from trueloop.jobs.measure.measured import read_measured, read_part_of_job, write_measured
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.of_this_part import check_matches


def _read(content: bytes, name: str, mapping: str = "", unit: Unit | None = None) -> object:
    with tempfile.TemporaryDirectory() as folder:
        path, stated = Path(folder) / name, Path(folder) / "meaning.toml"
        path.write_bytes(content)
        stated.write_text(mapping, encoding="utf-8")
        return read_measured_file(path, StatedFacts(unit, stated if mapping else None))


def _on_shaft(*rows: str, output: str = "") -> object:
    """What is odd about a print-out of the shaft; with `output` it is to be written."""
    with tempfile.TemporaryDirectory() as folder:
        path, part = Path(folder) / "print.txt", read_part_of_job(write_job(Path(folder)))
        path.write_text("".join(f"{row}\n" for row in rows), encoding="utf-8")
        file = read_measured(path, StatedFacts("mm"), part)
        if output:
            return write_measured([file], part, Path(folder) / output, [path])
        return [found for one in file.on_part for found in one.findings]


def _check(*readings: Reading) -> object:
    inspection = Inspection(Part(PartType("shaft")), "readings", "0" * 64, len(readings), readings)
    return check_matches(SHAFT, inspection, match_inspection(SHAFT, inspection), {}, None)


def size(nominal: float) -> str:
    """A diameter as the print-out has it."""
    return f"SIZE D{nominal:.4f} ACTUAL {nominal:.4f} TOL 0.02 DEV 0.0"


def part(number: int) -> str:
    """The heading of a component."""
    return f"COMPONENT NO {number} FEATURE NO 1"


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MSR_FILE: lambda: read_measured_file(Path("/nowhere/part.dmo"), StatedFacts()),
    Code.MSR_COUNTED: lambda: _read(b"K1001/1 4711\nK2002/1 cracks\nK2004/1 1\nK0021/1 3\n", "counts.dfq"),
    Code.MSR_SIZE: lambda: _read(b"<QIFDocument>" + b"<a>" * 300, "deep.qif"),
    Code.MSR_FORMAT: lambda: _read(b"Dear colleague,\nthe part is fine.\n", "letter.txt"),
    Code.MSR_UNIT: lambda: _read(b"1 2 3 0 0 0 0 0 0\n", "probe.txt"),
    Code.MSR_MEANING: lambda: _read(b"#500=29.991\n#501=\n", "macro.txt"),
    Code.MSR_MAPPING: lambda: _read(b"#500=29.991\n", "macro.txt", "[variables.500]\nquantity = 'girth'\n"),
    Code.MSR_VALUE: lambda: _read(b"#500=1.\n", "macro.txt", "[variables.501]\nquantity = 'length'\n", "mm"),
    Code.MSR_PART: lambda: _on_shaft(size(30.0), size(7.0), size(9.0)),
    Code.MSR_SCALE: lambda: _on_shaft(size(1.1811), size(0.7874)),
    Code.MSR_EXCLUDED: lambda: _check(Reading("D1", Quantity.DIAMETER, 30.0, 30.0, 29.96, 29.98)),
    Code.MSR_PLACES: lambda: _on_shaft(size(30.0), size(40.0)),
    Code.MSR_SERIAL: lambda: _on_shaft(part(1), size(30.0), part(2), size(30.0), output="readings.csv"),
    Code.MSR_NONE: lambda: _on_shaft("POSN X0.0 ACTUAL 0.01 DEV 0.01", output="readings.csv"),
    Code.MSR_FRAME: lambda: _read(
        b"UNITS/MM,ANGDEC\nFA(A)=FEAT/POINT,CART,1,2,3\nD(1)=TRANS/XORIG,FA(A)\n", "part.dmo"
    ),
    Code.MSR_NUMBER: lambda: number_in("1,234.5", Path("report.txt"), 7),
    Code.MSR_TIME: lambda: _read(b"date,nominal [mm],actual [mm]\n03/04/2026,25,25.01\n", "part.csv"),
    Code.MSR_EXCHANGED: lambda: _read(b"upper limit [mm];lower limit [mm];actual [mm]\n24,9;25,1;25\n", "part.csv"),
}
