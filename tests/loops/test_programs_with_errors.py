"""A program with an error of its own is refused by everything that writes; LinuxCNC says what an error is."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.correction import EXAMPLES, example_inputs
from tests.support.linuxcnc import ProgramRefusedError, interpret
from tests.support.mapped import mapped
from tests.support.refusals import refused
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.jobs.machine.mapped_program import write_corrected_points
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.machine.standards import QuadrupoleField
from trueloop.nc.check.check import check
from trueloop.nc.field import affine_field
from trueloop.nc.program.program import read_program
from trueloop.surface.compensation.program import corrected_program

SHIFTED = affine_field(np.eye(3), [0.01, 0.0, 0.01])
OFF_BY_3_MM = "G21 G17 G90 G94 F100\nG0 X10 Y0 Z0\nG3 X0 Y13 I-10 J0\nM2\n"
TWO_OF_A_GROUP = "G21 G17 G90 G94 F100\nG0 X10 Y0 Z0\nG1 X5\nG0 G1 X0\nM2\n"


def arc(unit: str, radius: float, off: float) -> str:
    end = f"X0 Y{radius + off:.6f} I-{radius}"
    return f"{unit} G17 G90 G94 F100\nG0 X{radius} Y0 Z0\nG3 {end} J0\nM2\n"


def half_turn(unit: str, radius: float, longer: float) -> str:
    return f"{unit} G17 G90 G94 F100\nG0 X{radius} Y0 Z0\nG3 X{-radius - 2 * longer:.7f} Y0 R{radius}\nM2\n"


@pytest.mark.parametrize(
    "text",
    [
        *(arc("G21", 10.0, off) for off in (0.0279, 0.0287, -0.0279, -0.0287, 3.0)),
        *(arc("G21", 100.0, off) for off in (0.0999, 0.1003, -0.0997, -0.1003)),
        *(arc("G21", 5000.0, off) for off in (2.82, 2.84)),
        *(arc("G20", 0.4, off) for off in (0.0028, 0.0029)),
        *(arc("G20", 40.0, off) for off in (0.0399, 0.0402)),
        *(half_turn("G21", 10.0, longer) for longer in (0.0012, 0.0014, 0.004)),
        *(half_turn("G20", 0.4, longer) for longer in (0.00004, 0.00006)),
    ],
)
def test_an_arc_is_an_error_where_linuxcnc_refuses_it(text: str, tmp_path: Path) -> None:
    source = tmp_path / "program.ngc"
    source.write_text(text)
    try:
        interpret(source)
    except ProgramRefusedError as refusal:
        refusals = [refusal.line]
    else:
        refusals = []
    errors = [found for found in check(read_program(text.encode(), "linuxcnc")) if found.severity is Severity.ERROR]
    assert [found.place.line for found in errors] == refusals
    try:
        mapped(tmp_path, text, SHIFTED)
    except TrueloopError as refusal_of_map:
        assert refusals and refusal_of_map.place.line == 3 and refusal_of_map.code in (Code.NC_ARC, Code.NC_ARC_FIT)
        assert not (tmp_path / "mapped.ngc").exists()
    else:
        assert not refusals


@pytest.mark.parametrize(
    ("dialect", "head", "bound_mm"),
    [("siemens", "G71", 0.01), ("fanuc-mill", "G21", 0.0283), ("haas-mill", "G20", 0.0718)],
)
def test_other_controls_have_their_own_bounds(dialect: str, head: str, bound_mm: float, tmp_path: Path) -> None:
    mm = 25.4 if head == "G20" else 1.0
    for off_mm, wrong in ((0.98 * bound_mm, False), (1.03 * bound_mm, True)):
        text = arc(head, 5.0 / mm, off_mm / mm)
        found = [one.severity for one in check(read_program(text.encode(), dialect)) if one.code is Code.NC_ARC_FIT]
        assert found == [Severity.ERROR if wrong else Severity.WARNING]


@pytest.mark.parametrize(
    ("text", "code", "line", "column"),
    [(OFF_BY_3_MM, Code.NC_ARC_FIT, 3, 4), (TWO_OF_A_GROUP, Code.NC_DUPLICATE, 4, 4)],
)
def test_every_command_that_writes_refuses_it(text: str, code: Code, line: int, column: int, tmp_path: Path) -> None:
    source, out = tmp_path / "part.ngc", tmp_path / "out.ngc"
    source.write_text(text)
    command = ["nc", "map", source, "-o", out, "-d", "linuxcnc", "--shift", "0.01,0,0"]
    told = run(*command, status=int(ExitStatus.REFUSED))
    assert f"{source}:{line}:{column}: {code}" in told and "hint:" in told and not out.exists()
    holes = read_program(text.replace("G3 X0 Y13 I-10 J0", "G0 G1 X5").encode(), "linuxcnc", str(source))
    points = refused(write_corrected_points, holes, out, QuadrupoleField(1e-4, 0.0), {})
    assert points.code is Code.NC_DUPLICATE and not out.exists()


@pytest.mark.parametrize("which", ["finish", "semifinish"])
def test_compensate_refuses_it_in_both_programs(which: str, tmp_path: Path) -> None:
    """MODBAS2's dome with an R that is far too small for its chord."""
    folder = tmp_path / "modbas2"
    shutil.copytree(EXAMPLES / "modbas2", folder)
    file = folder / f"{which}.nc"
    text = file.read_text("latin-1")
    at = text.index(" R(P46/2")
    line = 1 + text[:at].count("\n")
    file.write_text(text.replace(" R(P46/2", " R(P46/9"), "latin-1")
    told = run("compensate", folder / "job.toml", "--output", tmp_path / "out", status=int(ExitStatus.REFUSED))
    assert f"{file}:{line}:" in told and "NC-ARC:" in told and not (tmp_path / "out").exists()


def test_surface_compensate_refuses_it() -> None:
    inputs = read_surface(EXAMPLES / "surface" / "surface.toml").inputs
    program = inputs.program
    assert program is not None and inputs.cutter is not None
    text = program.source.replace(b"M2", b"G0 G1 X0\nM2")
    again = read_program(text, program.dialect.name, "finish.ngc")
    found = refused(corrected_program, again, inputs.surface, inputs.surface, inputs.cutter, "0" * 16)
    assert found.code is Code.NC_DUPLICATE and found.place.line == 1 + text[: text.index(b"G0 G1")].count(b"\n")


def test_what_is_right_is_not_refused() -> None:
    assert compensate(example_inputs("modbas2")).corrected_program
