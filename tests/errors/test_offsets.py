"""Every way in which a tool table, or an offset for it, is refused."""

import json
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from tests.support.files import read_as_file
from tests.support.records import sealed
from tests.support.tool_tables import FANUC, HAAS, HEIDENHAIN, LINUXCNC, OFFSET, SIEMENS, made_at, record_with
from trueloop.domain.proposal import HeldTool, ToolOffset
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.known import nose_radius_mm, read_tool_table
from trueloop.formats.tables.tool_tables.tool_table import Unit
from trueloop.jobs.turned.outputs import apply_offset
from trueloop.turned.program.wear_numbers import counted


def _read(text: str, name: str = "tool.tbl", unit: Unit | None = "mm") -> object:
    return read_as_file(text, lambda path: read_tool_table(path, unit), name)


def _apply(
    text: str = LINUXCNC, offset: ToolOffset | None = OFFSET, name: str = "tool.tbl", unit: Unit | None = "mm"
) -> object:
    with tempfile.TemporaryDirectory() as folder:
        table, record = Path(folder) / name, Path(folder) / "record.json"
        table.write_text(text)
        record.write_text(record_with(offset).to_json())
        return apply_offset(record, table, Path(folder) / "new.tbl", unit)


def _nose(stated_mm: float) -> object:
    return read_as_file(
        LINUXCNC, lambda path: nose_radius_mm(read_tool_table(path, "mm"), 3, 1, "", stated_mm), "t.tbl"
    )


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.OFS_FILE: partial(_read, FANUC.replace("G10 P1 ", "G91 G10 P1 "), "a.txt"),
    Code.OFS_FORMAT: partial(_read, "POCKET LENGTH DIAMETER\n1 2 3\n", "sim.tbl"),
    Code.OFS_NUMBER: partial(_read, LINUXCNC.replace("Z-3.25", "Z-3,25")),
    Code.OFS_UNIT: partial(_apply, unit=None),
    Code.OFS_TOOL: partial(_apply, offset=replace(OFFSET, tool=7)),
    Code.OFS_ROWS: partial(_apply, LINUXCNC + "\nT3 P8 X1 Z1\n"),
    Code.OFS_NAME: partial(_apply, offset=replace(OFFSET, held=HeldTool("rough"))),
    Code.OFS_NOSE: partial(_nose, 0.8),
    Code.OFS_ROW: partial(_apply, HAAS, name="a.ofs"),
    Code.OFS_CHANGED: partial(_apply, offset=made_at("geometry", "+12.4", "-3.25")),
    Code.OFS_TWICE: partial(_apply, offset=made_at("geometry", "+12.512", "-3.254")),
    Code.OFS_WORDS: lambda: counted("okuma", None),
    Code.OFS_NONE: partial(_apply, offset=replace(OFFSET, makes_the_correction=False)),
}


def _code(call: Callable[[], object]) -> Code:
    with pytest.raises(TrueloopError) as caught:
        call()
    return caught.value.code


@pytest.mark.parametrize(
    ("call", "code"),
    [
        (partial(_read, FANUC.replace("X-0.1", "U-0.1"), "a.txt"), Code.OFS_FILE),
        (partial(_read, FANUC + "G20\n", "a.txt"), Code.OFS_FILE),
        (partial(_read, "G10 X1.\nG10 P1 X1.\n", "a.txt"), Code.OFS_FILE),
        (partial(_read, LINUXCNC.replace("Z-3.25", "Z-3.25 Z1")), Code.OFS_FILE),
        (partial(_read, HEIDENHAIN.replace("[END]", ""), "tool.t"), Code.OFS_FILE),
        (partial(_read, "<TOOL1><X_WEAR>1</X_WEAR>", "a.ofs"), Code.OFS_FILE),
        (partial(_read, FANUC.replace("G21\n", ""), "a.txt", None), Code.OFS_UNIT),
        (partial(_read, SIEMENS, "to.ini", "inch"), Code.OFS_UNIT),
        (partial(_read, SIEMENS + "$TC_DP12[3,1]=1\n", "to.ini"), Code.OFS_ROWS),
        (partial(_read, LINUXCNC.replace("X+12.500000", "Xnan")), Code.OFS_NUMBER),
        (partial(_read, LINUXCNC.replace("T3", "T3.5")), Code.OFS_NUMBER),
        (partial(_apply, SIEMENS.replace("=500", "=120"), name="to.ini"), Code.OFS_ROW),
        (partial(_apply, FANUC.replace(" Z.05", ""), name="a.txt"), Code.OFS_ROW),
        (partial(_apply, HEIDENHAIN.replace("-0.05     +0.4", "-0.05  +0.4").replace("DXL       RS", "DXL    RS"),
                 name="t.trn"), Code.OFS_ROW),
        (partial(_apply, offset=replace(OFFSET, x_radius_mm=-0.2)), Code.CMP_SIZE),
        (partial(_apply, offset=None), Code.OFS_NONE),
        (partial(_apply, offset=made_at("wear", "+12.5", "-3.25")), Code.OFS_CHANGED),
    ],
)  # fmt: skip
def test_each_is_refused_with_its_own_code(call: Callable[[], object], code: Code) -> None:
    assert _code(call) is code


def test_what_is_in_a_row_already_is_not_added_again(tmp_path: Path) -> None:
    """By the mark in the comment: of the same record, and of another record of the same measurements."""
    table, record, new = tmp_path / "tool.tbl", tmp_path / "record.json", tmp_path / "new.tbl"
    table.write_text(LINUXCNC)
    record.write_text(record_with(OFFSET).to_json())
    apply_offset(record, table, new, "mm")
    assert _code(lambda: apply_offset(record, new, tmp_path / "newer.tbl", "mm")) is Code.OFS_TWICE
    record.write_text(sealed(json.dumps(json.loads(record.read_text()) | {"id": "another"})))
    assert _code(lambda: apply_offset(record, new, tmp_path / "newer.tbl", "mm")) is Code.OFS_TWICE
    assert not (tmp_path / "newer.tbl").exists()
    record.write_text(
        sealed(record_with(replace(OFFSET, measured_sha256="2" * 64)).to_json().replace("0123456789", "9" * 10))
    )
    apply_offset(record, new, tmp_path / "newer.tbl", "mm")  # measured anew: the next correction


def test_the_table_is_never_overwritten_and_a_target_that_takes_nothing_is_refused(tmp_path: Path) -> None:
    table, record = tmp_path / "tool.tbl", tmp_path / "record.json"
    table.write_text(LINUXCNC)
    record.write_text(record_with(OFFSET).to_json())
    assert _code(lambda: apply_offset(record, table, table, "mm")) is Code.OUT_INPUT
    (tmp_path / "file").write_text("")
    assert _code(lambda: apply_offset(record, table, tmp_path / "file" / "new.tbl", "mm")) is Code.OUT_FOLDER
    assert table.read_text() == LINUXCNC
