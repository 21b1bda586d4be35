"""docs/linuxcnc-programs.md says how many of LinuxCNC's programs run the same, and why not the others."""

from pathlib import Path

from tests.support.linuxcnc_programs import FOLDER, outcomes, table
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.program.program import read_program

DOCUMENT = (Path(__file__).parents[3] / "docs" / "linuxcnc-programs.md").read_text(encoding="utf-8")


def test_the_page_carries_the_table_as_it_is_today() -> None:
    assert f"\n{table(outcomes())}\n" in DOCUMENT


def test_every_program_is_written_back_byte_for_byte() -> None:
    files = sorted(FOLDER.rglob("*.ngc"))
    assert len(files) > 100
    for file in files:
        program = read_program(file.read_bytes(), "linuxcnc")
        assert program.core.source() == apply_edits(program, []) == file.read_bytes()
