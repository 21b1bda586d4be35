"""The offset as a program of each control: what it makes of the control's memory, and of LinuxCNC's tool."""

from dataclasses import replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import pytest

from tests.loops.test_tool_table_of_a_job import job
from tests.support.cli import invoke, run
from tests.support.linuxcnc import Tool, interpret
from tests.support.offset_control import Memory
from tests.support.tool_tables import OFFSET, record_with
from trueloop.cli import shared_options
from trueloop.domain.proposal import HeldTool, ToolOffset
from trueloop.errors import Code, TrueloopError
from trueloop.turned.program.wear_numbers import CONTROLS, Control, WearOffset, blocks_of, offset_program

XIs = Literal["radius", "diameter"]


def written(control: Control, x_is: XIs, offset: ToolOffset = OFFSET) -> str:
    return offset_program(control, WearOffset.of(offset, x_is), "0123456789abcdef")


@pytest.mark.parametrize("control", ["fanuc", "haas", "okuma", "siemens"])
@pytest.mark.parametrize(("x_is", "factor"), [("radius", 1), ("diameter", 2)])
def test_it_adds_to_what_is_in_force(control: Control, x_is: XIs, factor: int) -> None:
    """12 µm in on the radius, 4 µm out along z, on top of 0.1 and −0.05; tool 4 stays."""
    memory = Memory({3: [0.1, -0.05], 4: [1.0, 2.0]})
    memory.run(written(control, x_is))
    assert memory.offsets[3] == pytest.approx([0.1 - 0.012 * factor, -0.046], abs=1e-12)
    assert memory.offsets[4] == [1.0, 2.0]


@pytest.mark.parametrize("control", ["fanuc", "haas", "okuma"])
def test_in_inches(control: Control) -> None:
    memory = Memory({3: [0.0, 0.0]}, inch=True)
    memory.run(written(control, "diameter", replace(OFFSET, unit="inch", decimals=5)))
    assert memory.offsets[3] == pytest.approx([-0.024 / 25.4, 0.004 / 25.4], abs=5e-6)


def test_an_edge_of_a_sinumerik() -> None:
    assert "$TC_DP12[3,2]=$TC_DP12[3,2]-0.0120" in written("siemens", "radius", replace(OFFSET, held=HeldTool(edge=2)))


@pytest.mark.parametrize("control", ["fanuc", "haas", "okuma", "linuxcnc"])
def test_another_edge_is_not_dropped_by_words_that_count_none(control: Control) -> None:
    with pytest.raises(TrueloopError, match="count no edges") as refused:
        written(control, "diameter", replace(OFFSET, held=HeldTool(edge=2)))
    assert refused.value.code is Code.OFS_WORDS


def test_a_ge_2000t_gets_the_blocks_of_its_own_program() -> None:
    """They set what the program sets itself, and the change."""
    memory = Memory({3: [0.1, 0.2]})
    memory.run(written("ge2000t", "diameter", replace(OFFSET, blocks=("(UPD, 3, TOV(X), 0.0760)",))))
    assert memory.offsets[3] == [0.076, 0.2]


@pytest.mark.parametrize(("mode", "x_is", "x"), [("G7", "diameter", "60"), ("G8", "radius", "30")])
@pytest.mark.parametrize(("unit", "code"), [("mm", "G21"), ("inch", "G20")])
def test_linuxcnc_moves_the_tool_by_it(
    tmp_path: Path, mode: str, x_is: XIs, x: str, unit: Literal["mm", "inch"], code: str
) -> None:
    """Run by its interpreter before the course: the tool's ends lie off by the offset, x as a radius."""
    text = written("linuxcnc", x_is, replace(OFFSET, unit=unit, decimals=6))
    course = [f"{code} {mode} G18 G40 G90 G94 F10", f"G0 X{x} Z5", "G1 Z-20 F10", "M2", ""]
    step_mm = {"mm": 1e-6, "inch": 1.3e-5}[unit]  # half a step of six decimals
    ends = []  # the offset stays in force: the judge keeps no tool table that a second M6 could read anew
    for name, blocks in (("plain", ["T3 M6", "G43"]), ("worn", text.replace("M2\n", "").splitlines())):
        (tmp_path / name).write_text("\n".join([*blocks, *course]))
        tool = Tool(3, 0.4, x_offset_mm=3.0, z_offset_mm=7.0)
        ends.append(np.array([move.machine_mm for move in interpret(tmp_path / name, tools=[tool])]))
    assert ends[1] - ends[0] == pytest.approx(np.tile([-0.012, 0.0, 0.004], (2, 1)), abs=step_mm)


def record(folder: Path, offset: ToolOffset = OFFSET) -> Path:
    path = folder / "record.json"
    path.write_text(record_with(offset).to_json())
    return path


def test_a_records_offset_in_its_own_controls_words_and_in_anothers(tmp_path: Path) -> None:
    path = record(tmp_path)
    own = "%\n(TRUELOOP OFFSET 0123456789ABCDEF, RUN ONCE)\nG21 G10 P3 U-0.0240 W0.0040\nM30\n%\n"
    assert run("offsets", "program", path) == own
    okuma = run("offsets", "program", path, "--control", "okuma", "--x-is", "diameter")
    assert okuma.splitlines()[1:3] == ["VTOFX[3]=VTOFX[3]-0.0240", "VTOFZ[3]=VTOFZ[3]+0.0040"]
    run("offsets", "program", path, "-o", tmp_path / "o.nc")
    assert (tmp_path / "o.nc").read_text() == own


@pytest.mark.parametrize(
    "more", [("--control", "okuma"), ("--control", "heidenhain"), ("--control", "ge2000t"), ("--control", "haas")]
)
def test_what_is_not_clear_is_not_written(tmp_path: Path, more: tuple[str, ...]) -> None:
    assert "OFS-WORDS" in run("offsets", "program", record(tmp_path), *more, status=3)


def test_a_sinumerik_in_inch_and_an_unknown_control_are_refused(tmp_path: Path) -> None:
    inch = record(tmp_path, replace(OFFSET, unit="inch"))
    assert "OFS-WORDS" in run("offsets", "program", inch, "--control", "siemens", status=3)
    assert invoke("offsets", "program", inch, "--control", "mazak").exit_code == 2


def test_a_job_gives_the_program_of_its_control(tmp_path: Path) -> None:
    printed = run("offsets", "program", job(tmp_path, "number = 3\nnose_radius_mm = 0.4"))
    assert "G21 G10 P3 U-0.024 W0.004" in printed.splitlines()


def test_the_command_knows_the_controls() -> None:
    assert get_args(shared_options.Control) == CONTROLS
    assert blocks_of("heidenhain", WearOffset.of(OFFSET, "radius")) == ()
