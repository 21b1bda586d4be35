"""The tool table of a control through its link: shown, corrected, read back, and never while a program runs."""

import json
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.cli import output_of
from tests.support.refusals import refused
from tests.support.tool_tables import FANUC, LINUXCNC, OFFSET, record_with
from tests.unit.controllers.links.test_line import Terminal
from trueloop.controllers.links.folder import Folder, named_in
from trueloop.controllers.links.line import Line
from trueloop.errors import Code
from trueloop.jobs.links import Opened, apply_at, differing_rows, send, with_table

CORRECTED = "T3 P7 X+12.488000 Z-3.24600 D0.8 Q2"  # 12.5 − 0.012, −3.25 + 0.004


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """links.toml, a control's folder with tool.tbl and running.txt, and a correction's record.json."""
    (tmp_path / "control").mkdir()
    (tmp_path / "control" / "tool.tbl").write_text(LINUXCNC, encoding="utf-8")
    (tmp_path / "control" / "running.txt").write_text("\n")
    (tmp_path / "record.json").write_text(record_with(OFFSET).to_json())
    (tmp_path / "links.toml").write_text(
        '[folder.lathe]\nfolder = "control"\nrunning_file = "control/running.txt"\n'
        'tool_table = "tool.tbl"\ntable_unit = "mm"\n[folder.bare]\nfolder = "control"\n'
    )
    return tmp_path


def offsets(place: Path, *call: object, link: str = "lathe", status: int = 0) -> str:
    return output_of("link", "offsets", "-l", link, "--settings", place / "links.toml", *call, status=status)


def test_the_table_in_force_is_shown_and_the_offset_put_into_it_once(place: Path) -> None:
    table = place / "control" / "tool.tbl"
    rows = json.loads(offsets(place, "--json"))["rows"]
    assert [(row["tool"], row["x"]) for row in rows] == [(1, 0.0), (3, 12.5), (2, 0.0)]
    done = json.loads(offsets(place, "--apply", place / "record.json", "--json"))
    assert CORRECTED in table.read_text(encoding="utf-8")
    assert table.read_text(encoding="utf-8").splitlines()[0] == LINUXCNC.splitlines()[0]
    assert done["written"] == "tool.tbl" and done["sent_sha256"] == done["read_back_sha256"]
    assert Path(done["kept"]).read_text(encoding="utf-8") == LINUXCNC
    assert "OFS-TWICE" in offsets(place, "--apply", place / "record.json", status=3)


def test_no_table_is_written_while_any_program_runs(place: Path) -> None:
    running, table = place / "control" / "running.txt", place / "control" / "tool.tbl"
    running.write_text("O7.nc\n")
    said = offsets(place, "--apply", place / "record.json", "--not-running", status=3)
    assert "LNK-RUNNING" in said and "O7.nc" in said
    (place / "other.tbl").write_text("T3 P7 X1\n")
    put = ("link", "put", place / "other.tbl", "--name", "tool.tbl", "--replace", "-l", "lathe")
    assert "LNK-RUNNING" in output_of(*put, "--settings", place / "links.toml", status=3)
    running.unlink()
    assert "--not-running" in offsets(place, "--apply", place / "record.json", status=3)
    assert table.read_text(encoding="utf-8") == LINUXCNC and not (place / "replaced").exists()
    assert "read back" in offsets(place, "--apply", place / "record.json", "--not-running")


def test_a_table_is_named_and_its_unit_stated_where_the_settings_do_not(place: Path) -> None:
    assert "LNK-NAME" in offsets(place, link="bare", status=3)
    call = ("--table", "tool.tbl", "--apply", place / "record.json", "--not-running")
    assert "OFS-UNIT" in offsets(place, *call, link="bare", status=3)
    offsets(place, *call, "--unit", "mm", link="bare")
    assert CORRECTED in (place / "control" / "tool.tbl").read_text(encoding="utf-8")


@pytest.mark.parametrize("at", ["read", "write_aside"])
def test_an_offset_entered_at_the_control_meanwhile_is_not_lost(place: Path, at: str) -> None:
    edited = LINUXCNC.replace("X+12.500000", "X+12.600000").encode()

    class Edited(Folder):
        def read(self, name: str) -> bytes:
            content = super().read(name)
            if at == "read":
                (self.folder / name).write_bytes(edited)
            return content

        def write_aside(self, name: str, content: bytes) -> str:
            if at == "write_aside":
                (self.folder / name).write_bytes(edited)
            return super().write_aside(name, content)

    link = Edited(place / "control", named_in(place / "control" / "running.txt"))
    control = with_table(Opened("lathe", link, frozenset(), place / "replaced"), "tool.tbl", "mm")
    assert refused(apply_at, control, place / "record.json").code is Code.LNK_CHANGED
    assert (place / "control" / "tool.tbl").read_bytes() == edited


def at_a_line(place: Path, takes: bytes) -> list[str]:
    """Applies the correction over a serial line; the control puts out FANUC, then `takes`. What a person was told."""
    terminal = Terminal()
    terminal.kept += FANUC.encode("ascii", "replace")
    terminal.reader = threading.Thread(target=lambda: None)
    terminal.reader.start()
    told = []

    def tell(said: str) -> None:
        told.append(said)
        if "read now" in said:
            terminal.kept.clear()
        elif len(told) > 2:
            terminal.reader.join(20)
            terminal.kept[:] = takes
        terminal.tell(said)

    line = Line(terminal.name, 38400, 8, "none", 1, silence_s=20, tell=tell)
    control = with_table(Opened("old", line, frozenset(), place), "OFFSETS", None)
    try:
        apply_at(control, place / "record.json", not_running=True)
    finally:
        terminal.close()
    return told


TAKEN = b"%\nG21\nG10 P1 X0.000 Z0.000 R0.4 Q3\nG10 P3 X-.124 Z.0540 R.8 Q3\nG10 P10003 X-155.5 Z-80.25 R0.8 Q3\n%\n"
"""FANUC with X −0.1 − 0.024 (diameter) and Z 0.05 + 0.004, as a control that keeps numbers alone punches it."""


def test_over_a_line_the_numbers_that_the_control_took_are_compared(place: Path) -> None:
    assert [one.split()[0] for one in at_a_line(place, TAKEN)] == ["have", "let", "have"]
    error = refused(at_a_line, place, TAKEN.replace(b"Z.0540", b"Z.0504"))
    assert error.code is Code.LNK_DIFFERS and "Z.0504" in error.message


def test_a_row_that_is_missing_or_doubled_is_a_difference() -> None:
    table = FANUC.encode("latin-1")
    assert differing_rows("t", table, table.replace(b"X-0.1 ", b"X-.10 "), None) == []
    doubled = table.replace(b"M30", b"G10 P1 X0. Z0. R0.4 Q3\nM30")
    (added,) = differing_rows("t", table, doubled, None)
    assert (added.line, added.other_line) == (None, 7)
    (lost,) = differing_rows("t", doubled, table, None)
    assert (lost.line, lost.other_line) == (7, None)
    assert differing_rows("t", table, table.replace(b"G21", b"G20"), None)


def test_only_the_program_that_was_read_is_replaced(place: Path) -> None:
    link = Folder(place / "control", named_in(place / "control" / "running.txt"))
    control = Opened("lathe", link, frozenset(), place / "replaced")
    call = {"content": b"T1 X1\n", "name": "tool.tbl"}
    assert refused(lambda: send(control, **call, replace=b"another")).code is Code.LNK_CHANGED  # type: ignore[arg-type]
    there = (place / "control" / "tool.tbl").read_bytes()
    assert send(replace(control, tool_table="tool.tbl"), b"T1 X1\n", "tool.tbl", replace=there).written
