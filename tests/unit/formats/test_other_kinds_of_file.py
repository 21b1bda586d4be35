"""Workbooks, archives, PDF and UTF-16 in the place of a text file are recognised, by content and by name."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.cli import run
from tests.support.correction import EXAMPLES
from trueloop.errors import Code, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.jobs.machine.mapped_program import lines_of

TEXT = "point,nominal_x_mm,nominal_z_mm,error_um\n1,10,20,3\n"


def workbook(path: Path) -> bytes:
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("[Content_Types].xml", "<Types/>")
    return path.read_bytes()


KINDS = {
    "UTF-16 as Excel writes it": (TEXT.encode("utf-16"), "text in UTF-16"),
    "UTF-16 big end first": (b"\xfe\xff" + TEXT.encode("utf-16-be"), "text in UTF-16"),
    "UTF-16 without a mark": (TEXT.encode("utf-16-le"), "text in UTF-16"),
    "UTF-16 without a mark, big end first": (TEXT.encode("utf-16-be"), "text in UTF-16"),
    "a workbook": (None, "an archive or a workbook"),
    "an old workbook": (bytes.fromhex("d0cf11e0a1b11ae1") + bytes(512), "a workbook"),
    "PDF": (b"%PDF-1.7\n", "a PDF document"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("given_as", ["touches.csv", "job.toml", "finish.nc"])
def test_by_content(tmp_path: Path, kind: str, given_as: str) -> None:
    content, words = KINDS[kind]
    file = tmp_path / given_as
    file.write_bytes(content or workbook(tmp_path / "zipped"))
    read: dict[str, Callable[[], object]] = {
        "touches.csv": lambda: read_touches(file),
        "job.toml": lambda: read_turned_job(file),
        "finish.nc": lambda: list(lines_of(file)),
    }
    codes = {"touches.csv": Code.TCH_FILE, "job.toml": Code.JOB_MISSING, "finish.nc": Code.NC_FILE}
    with pytest.raises(TrueloopError) as refused:
        read[given_as]()
    assert refused.value.code is codes[given_as]
    assert f"'{given_as}' is {words}" in refused.value.message
    assert "UTF-8" in refused.value.hint or "text" in refused.value.hint
    assert refused.value.place.file == str(file)


@pytest.mark.parametrize("name", ["touches.xlsx", "touches.XLS", "touches.ods", "touches.zip", "touches.pdf"])
def test_by_name(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_bytes(b"\x00\x01\x02")
    with pytest.raises(TrueloopError, match=f"TCH-FILE: '{name}' is a"):
        read_touches(file)


def test_a_program_beside_a_workbook_of_touches_is_not_the_one_blamed(tmp_path: Path) -> None:
    for file in (EXAMPLES / "facetst").iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    workbook(tmp_path / "touches.xlsx")
    job = tmp_path / "job.toml"
    job.write_text(job.read_text().replace("touches.csv", "touches.xlsx"))
    said = run("compensate", job, "-o", tmp_path / "out", status=3)
    assert "touches.xlsx: TCH-FILE: 'touches.xlsx' is an archive or a workbook" in " ".join(said.split())


@pytest.mark.parametrize("text", ["%\nO1\nG21\nM30\n%\n", "0 BEGIN PGM A MM\n", "\ufeffpoint\n", "", "ä ö ü µ\n"])
def test_text_is_text(tmp_path: Path, text: str) -> None:
    """A program's percent sign is no PDF, umlauts are no UTF-16."""
    file = tmp_path / "program.nc"
    file.write_text(text, encoding="utf-8")
    assert read_text(file, Code.NC_FILE, hint="") == text.removeprefix("\ufeff")
