"""A written tool.tbl in LinuxCNC's own interpreter: the tool moves by the offset, x as a radius, whatever the mode."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import Tool, interpret, require_linuxcnc
from tests.support.tool_tables import LINUXCNC, OFFSET
from trueloop.arrays import Array
from trueloop.formats.tables.tool_tables.known import new_table, read_tool_table
from trueloop.formats.tables.tool_tables.tool_table import UNIT_MM, Unit

READ_BACK = "G20 {mode} G18 G40 G90 G94 F10\nT3 M6\nG43\n(debug,#5401 #5403 #5410)\nG1 X1 Z1\nM2\n"


def in_force(table: bytes, mode: str, folder: Path) -> tuple[float, float, float]:
    """X, Z and D of tool 3 as LinuxCNC reads them of the file, in the file's unit."""
    require_linuxcnc()
    (folder / "tool.tbl").write_bytes(table)
    (folder / "read.ngc").write_text(READ_BACK.format(mode=mode))
    command = ["rs274", "-g", "-t", "tool.tbl", "read.ngc"]
    environment = {"HOME": str(folder), "PATH": os.defpath}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    found = re.search(r'MESSAGE\("(\S+) (\S+) (\S+)"\)', done.stdout)
    assert found is not None, done.stdout
    offset = re.search(r"USE_TOOL_LENGTH_OFFSET\((\S+) \S+ (\S+),", done.stdout)
    assert offset is not None and float(offset[1]) == pytest.approx(float(found[1]), abs=1e-4)
    return float(found[1]), float(found[2]), float(found[3])


def ends(unit: str, mode: str, offset_mm: tuple[float, float], folder: Path) -> Array:
    """Where the moves of a program end on the machine with tool 3, mm."""
    x = {"G7": "60", "G8": "30"}[mode]
    (folder / "program.ngc").write_text(f"{unit} {mode} G18 G40 G90 G94 F10\nT3 M6\nG43\nG0 X{x} Z5\nG1 Z-20 F10\nM2\n")
    tool = Tool(3, 0.4, x_offset_mm=offset_mm[0], z_offset_mm=offset_mm[1])
    return np.array([move.machine_mm for move in interpret(folder / "program.ngc", tools=[tool])])


@pytest.mark.parametrize("mode", ["G7", "G8"])
@pytest.mark.parametrize(("unit", "code"), [("mm", "G21"), ("inch", "G20")])
def test_the_written_table_moves_the_tool_by_the_offset(tmp_path: Path, mode: str, unit: Unit, code: str) -> None:
    path = tmp_path / "given.tbl"
    path.write_bytes(LINUXCNC.encode())
    written = new_table(read_tool_table(path, unit), OFFSET, "ID").content
    before, after = (in_force(table, mode, tmp_path) for table in (LINUXCNC.encode(), written))
    assert before == pytest.approx((12.5, -3.25, 0.8), abs=1e-6)
    assert after[2] == before[2]
    old, new = (tuple(value * UNIT_MM[unit] for value in row[:2]) for row in (before, after))
    moved = ends(code, mode, (new[0], new[1]), tmp_path) - ends(code, mode, (old[0], old[1]), tmp_path)
    step_mm = {"mm": 1e-5, "inch": 2.54e-5}[unit]
    assert moved == pytest.approx(np.tile([-0.012, 0.0, 0.004], (2, 1)), abs=step_mm)
