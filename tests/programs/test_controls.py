"""What controls make of the same words: every row of the table of controls has a program, and its path is right."""

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.support.linuxcnc import ProgramRefusedError, interpret
from trueloop.errors import Code
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

CELLS: list[dict[str, Any]] = [
    cell
    for file in sorted((Path(__file__).parent / "controls").glob("*.toml"))
    for cell in tomllib.loads(file.read_text())["cell"]
]
CRATE = Path(__file__).parents[2] / "crates/nc-program"
TABLES = [CRATE / "controls.tsv", *sorted((CRATE / "controls").glob("*.tsv"))]
NAMES = [f"{cell['id']} {cell['control']} {index}" for index, cell in enumerate(CELLS)]


def path_of(cell: dict[str, Any]) -> tuple[ToolPath, list[str]]:
    """The path, and line and code of what was said, notes on the tables of tools apart."""
    program = read_program(cell["program"].encode(), cell["control"], unit=cell.get("unit"))
    tools = [CutterTool(0.0, number=number, length_mm=length) for number, length in cell.get("tools", [])]
    path = program.run(
        cell.get("parameters"),
        skipped_blocks=cell.get("skipped", False),
        tools=tools,
        work_offsets_mm={int(number): tuple(at) for number, at in cell.get("work", {}).items()},
        strict=False,
    )
    of_tools = ("tool's centre", "length offset")
    found = [one for one in path.findings if not any(text in one.message for text in of_tools)]
    numbers = [one for one in program.findings if "digits" in one.message]
    return path, sorted(f"{one.place.line} {one.code}" for one in [*found, *numbers])


def assert_move(path: ToolPath, move: int, wanted: str) -> None:
    kind, x, y, z, *fed = wanted.split()
    assert Motion(path.motion[move]).name.lower() == kind, wanted
    assert path.end_mm[move].tolist() == pytest.approx([float(x), float(y), float(z)], abs=1e-9, nan_ok=True)
    if fed:
        assert float(path.feed[move]) == pytest.approx(float(fed[0][1:]), rel=1e-12, nan_ok=True)
        assert int(path.feed_mode[move]) == int(fed[1])


@pytest.mark.parametrize("cell", CELLS, ids=NAMES)
def test_the_path_is_the_control_s(cell: dict[str, Any]) -> None:
    path, said = path_of(cell)
    assert said == cell.get("says", [])
    if "moves" in cell:
        assert len(path) == len(cell["moves"])
        for move, wanted in enumerate(cell["moves"]):
            assert_move(path, move, wanted)
    if "last" in cell:
        assert_move(path, len(path) - 1, cell["last"])
    if "centre" in cell:
        assert path.centre_mm[-1].tolist() == pytest.approx(cell["centre"], abs=1e-9)
    if "axis" in cell:
        assert chr(path.turned[-1]).strip("\0") == cell["axis"]
    if "turned" in cell:
        assert math.degrees(path.sweep_rad[-1]) == pytest.approx(cell["turned"], abs=1e-9)
    if "machine" in cell:
        assert (path.end_mm[-1] + path.origin_mm[-1]).tolist() == pytest.approx(cell["machine"], abs=1e-9)
    if "tool" in cell:
        assert int(path.states["tool"][path.state[-1]]) == cell["tool"]
    if "offset" in cell:
        assert int(path.states["work_offset"][path.state[-1]]) == cell["offset"]


@pytest.mark.parametrize("cell", [cell for cell in CELLS if cell.get("judge")], ids=lambda cell: cell["id"])
def test_linuxcnc_s_own_interpreter_refuses_it(cell: dict[str, Any], tmp_path: Path) -> None:
    file = tmp_path / "program.ngc"
    file.write_text(cell["program"] + "\nM2\n")
    with pytest.raises(ProgramRefusedError):
        interpret(file, startup="G17 G21 G40")


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.stem)
def test_every_row_of_the_table_names_its_evidence_and_has_a_program(table: Path) -> None:
    head, *rows = [line.split("\t") for line in table.read_text().splitlines()]
    assert head == ["controls", "item", "value", "meaning", "source", "evidence", "cells"]
    known = {name for cell in CELLS for name in cell["id"].split()}
    for row in rows:
        controls, item, value, meaning, source, evidence, cells = row
        assert all((controls, item, value, meaning, source)), row
        assert evidence in ("manual", "secondary", "run", "memory"), row
        assert not cells or set(cells.split()) & known, row


def test_what_an_answer_decides_is_asked_by_its_name() -> None:
    cell = next(cell for cell in CELLS if cell["id"] == "FM11 HM02 asked")
    path, _ = path_of(cell)
    (asked,) = [one for one in path.findings if one.code is Code.NC_PARAMETER]
    assert "3401#0" in asked.message and "--set '3401#0=0'" in (asked.hint or "")
    assert math.isnan(path.end_mm[-1, 0])
