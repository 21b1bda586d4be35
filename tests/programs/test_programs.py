"""Programs, a folder each: `program.nc` or `program.ngc`, and in `case.toml` what running it must give.

`moves`: line, kind, end (x, z) in `unit`, x a radius, and for an arc centre (x, z) and sweep in degrees, positive for
G02; worked out by hand. `starts`: line and start (x, z) of the first move of that line. `findings`: line, column,
code; without the key there must be none. `given_unit`: what whoever runs it says.
`roughing = false` leaves out what roughing cycles do. LinuxCNC's own
programs are run by LinuxCNC's own interpreter as well; of another control's program it runs `equivalent.ngc`, the same
cut in its own words, which must give the same moves.
"""

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.csv_reference import csv_lines
from tests.support.linuxcnc import LATHE_STARTUP, interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import Motion, ToolPath, csv_text

CASES = sorted(path.parent for path in Path(__file__).parent.glob("*/case.toml"))
LINUXCNC_CASES = [case for case in CASES if case.name.startswith("linuxcnc")]
EQUIVALENT_CASES = [case for case in CASES if (case / "equivalent.ngc").exists()]
NAMES = [case.name for case in CASES]
LINUXCNC_NAMES = [case.name for case in LINUXCNC_CASES]


def case_of(folder: Path) -> tuple[dict[str, Any], Program]:
    case = tomllib.loads((folder / "case.toml").read_text())
    (file,) = folder.glob("program.*")
    return case, read_program(file.read_bytes(), case["dialect"], file.name, unit=case.get("given_unit"))


def run(case: dict[str, Any], program: Program) -> ToolPath:
    return program.run(case.get("parameters"), roughing=case.get("roughing", True))


def row_mm(path: ToolPath, move: int) -> list[Any]:
    row = [int(path.line[move]), Motion(path.motion[move]).name.lower(), *path.end_mm[move, [0, 2]]]
    if path.motion[move] == Motion.ARC:
        row += [*path.centre_mm[move, [0, 2]], math.degrees(path.sweep_rad[move])]
    return row


def in_mm(row: Sequence[Any], unit: str) -> list[Any]:
    line, kind, *lengths = row
    sweep = [lengths.pop()] if kind == "arc" else []
    return [line, kind, *(value * (25.4 if unit == "inch" else 1.0) for value in lengths), *sweep]


@pytest.mark.parametrize("folder", CASES, ids=NAMES)
def test_the_csv_is_that_of_the_slow_reference(folder: Path) -> None:
    path = run(*case_of(folder))
    assert "".join(csv_text(path)).splitlines() == list(csv_lines(path))


@pytest.mark.parametrize("folder", CASES, ids=NAMES)
def test_unedited_programs_keep_every_byte(folder: Path) -> None:
    _, program = case_of(folder)
    assert program.core.source() == program.source


@pytest.mark.parametrize("folder", CASES, ids=NAMES)
def test_the_path_is_the_one_worked_out_by_hand(folder: Path) -> None:
    case, program = case_of(folder)
    path = run(case, program)
    if "moves" in case:
        expected = [in_mm(row, case["unit"]) for row in case["moves"]]
        found = [row_mm(path, move) for move in range(len(path))]
        assert [row[:2] for row in found] == [row[:2] for row in expected]
        for row, wanted in zip(found, expected, strict=True):
            assert row[2:6] == pytest.approx(wanted[2:6], abs=1e-9), f"line {row[0]}"
            assert row[6:] == pytest.approx(wanted[6:], abs=1e-4), f"line {row[0]}"
    for line, x, z in case.get("starts", []):
        start = path.start_mm[np.flatnonzero(path.line == line)[0]]
        assert start[[0, 2]] == pytest.approx([x * 25.4, z * 25.4], abs=1e-9)


@pytest.mark.parametrize("folder", CASES, ids=NAMES)
def test_every_oddity_is_said_with_its_place_and_no_other(folder: Path) -> None:
    case, program = case_of(folder)
    found = [*program.findings, *run(case, program).findings]
    rows = sorted([finding.place.line, finding.place.column, finding.code.value] for finding in found)
    assert rows == case.get("findings", [])


@pytest.mark.parametrize("folder", LINUXCNC_CASES, ids=LINUXCNC_NAMES)
def test_linuxcnc_itself_makes_the_same_moves(folder: Path) -> None:
    _, program = case_of(folder)
    path = program.run(inch=False, diameter=False, plane=18)
    assert_same_moves(path, interpret(folder / "program.ngc", startup=LATHE_STARTUP, block_delete=True))


@pytest.mark.parametrize("folder", EQUIVALENT_CASES, ids=[case.name for case in EQUIVALENT_CASES])
def test_linuxcnc_makes_the_same_moves_of_an_equivalent_program(folder: Path) -> None:
    case, program = case_of(folder)
    judged = interpret(folder / "equivalent.ngc", startup=LATHE_STARTUP)
    assert_same_moves(run(case, program), judged, same_lines=False)
