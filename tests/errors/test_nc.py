"""Every way in which a program is refused or remarked upon."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.nc.check.check import check
from trueloop.nc.edit.edit import Edit, apply_edits, displace_word, set_offset
from trueloop.nc.field import function_field, table_field
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import CoordinateState

DIAMETER_INCH = CoordinateState(inch=True, diameter=True)


def ge2000t(text: str) -> Program:
    return read_program(text.encode(), "ge2000t", "part.nc")


def linuxcnc(text: str) -> Program:
    return read_program(text.encode(), "linuxcnc", "part.ngc")


def _overlapping_edits() -> object:
    return apply_edits(ge2000t("G00 X1.0"), [Edit(4, 8, "X2.0"), Edit(6, 8, "0")])


def _increment_displaced() -> object:
    program = ge2000t("G70 G91 G01 X1.0 F1")
    return displace_word(program, program.block(0).words[3], 0.1, program.run().coordinate_state(0))


def _mapped_across_a_repetition() -> object:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "part.ngc")
        file.write_text("G21 G91 F1\no1 repeat [3]\nG1 X10\no1 endrepeat\n")
        bend = function_field(lambda points: 1e-5 * points**2, "bend")
        return map_program(file, Path(folder, "out.ngc"), bend, dialect="linuxcnc")


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.NC_DIALECT: lambda: read_program(b"", "fanuc-0"),
    Code.NC_PARAMETER: lambda: ge2000t("G70\nG00 X(P46+0.0625)").run(),
    Code.NC_EXPRESSION: lambda: linuxcnc("G21 G0 X[1/0]").run(),
    Code.NC_WORD: lambda: ge2000t("G00 X1.0 ??").findings,
    Code.NC_CODE: lambda: ge2000t("G123").findings,
    Code.NC_DUPLICATE: lambda: ge2000t("G01 X1.0 X2.0").findings,
    Code.NC_NUMBER: lambda: ge2000t("G00 X6,2625").findings,
    Code.NC_MISPLACED: lambda: ge2000t("G70\nG02").run().findings,
    Code.NC_DIAMETER: lambda: read_program(b"G18 G71 G0 X10", "siemens").run().findings,
    Code.NC_ARC: lambda: ge2000t("G70\nG00 X0 Z0\nG02 X4.0 Z0 R0.5 F1").run().findings,
    Code.NC_ARC_FIT: lambda: check(linuxcnc("G21 G18 G0 X10 Z0\nG2 X5.5 Z5 I-5 K0 F1")),
    Code.NC_TANGENT: lambda: check(linuxcnc("G21 G18 G8 G0 X10 Z-9\nG1 Z0 X9.7 F1\nG2 X4.7 Z5 I-5 K0")),
    Code.NC_FEED: lambda: check(linuxcnc("G21 G1 X10")),
    Code.NC_RAPID: lambda: check(
        linuxcnc("G21 G18 G8 F1\nG0 X20 Z0\nG1 X0\nG0 Z1\nG0 X10\nG1 Z-20\nG1 X12\nG0 Z-10\nG0 X8\nG0 X20")
    ),
    Code.NC_BLEND: lambda: check(linuxcnc("G21 G64 F1 S1\nG1 X10")),
    Code.NC_OPAQUE: lambda: linuxcnc("G21 G72 Q1 X1 Z1 D1").run().findings,
    Code.NC_UNIT: lambda: linuxcnc("G0 X1").run().findings,
    Code.NC_FLOW: lambda: linuxcnc("o100 while [1]\nM2").run(),
    Code.NC_LIMIT: lambda: linuxcnc("o100 while [1]\nG91\no100 endwhile\nM2").run(block_limit=1000),
    Code.NC_TOOL: lambda: linuxcnc("G21 G17 G42 D3\nG1 X5").run(tools=[CutterTool(0.4, number=2)]),
    Code.NC_ENTRY: lambda: linuxcnc("G21 G17 G42\nG1 X1").run(tools=[CutterTool(1.5)]),
    Code.NC_GOUGE: lambda: linuxcnc("G21 G17 G41\nG1 X5\nG1 X6\nG1 Y1\nX9\nG40 X20").run(tools=[CutterTool(1.5)]),
    Code.NC_EDIT: _overlapping_edits,
    Code.NC_MAP: _mapped_across_a_repetition,
    Code.NC_FIELD: lambda: table_field(np.arange(2.0), np.arange(1.0), np.arange(1.0), np.zeros((3, 3))),
    Code.NC_OFFSET: lambda: set_offset(ge2000t("G00 X1.0"), "X", 0.01, DIAMETER_INCH),
}


def fanuc(text: str) -> Program:
    return read_program(text.encode(), "fanuc-lathe", "part.nc")


FANUC: list[tuple[str, Code, str]] = [
    ("G21\nM98 P1000", Code.NC_FLOW, "program O1000 is not in this file"),
    ("G21\nGOTO 30", Code.NC_FLOW, "block N30 is not in this program"),
    ("G21\nWHILE[1]DO1", Code.NC_FLOW, "a DO without its END"),
    ("G21\nEND2", Code.NC_FLOW, "an END without its DO"),
    ("G21\nIF[1]#1=2", Code.NC_FLOW, "IF without GOTO or THEN"),
    ("G21\nG70 P20 Q10\nN10\nN20", Code.NC_FLOW, "the contour's last block is before its first"),
    ("N1 GOTO1", Code.NC_LIMIT, "stopped after 1000 blocks or moves"),
    ("G21\nM98 P1\nM30\nO1\nM98 P1", Code.NC_LIMIT, "programs call one another more than 64 deep"),
    ("G21 G00 X#7", Code.NC_PARAMETER, "parameter #7 has no value"),
    ("G21\n#1=[1.]2.", Code.NC_EXPRESSION, 'an operator is missing in "#1=[1.]2."'),
    ("G21 G00 X#<a>", Code.NC_WORD, '"X#<a>" is no word of the dialect fanuc-lathe'),
    ("G00 X10", Code.NC_NUMBER, '"X10" has no decimal point: what it counts is a parameter of the machine'),
    ("G21\nG28", Code.NC_MISPLACED, "a return to the reference point without an axis: nothing moves"),
    ("G21\nG70", Code.NC_MISPLACED, "G70 without P and Q: nothing moves"),
    ("G10 P1 X0.01", Code.NC_OPAQUE, "G10: only L2 with P1 to P6 and the words of X, Y and Z is followed"),
    ("G50 U1.", Code.NC_OPAQUE, "a shift of the position register by increments is not followed"),
    ("G12.1", Code.NC_OPAQUE, "G12.1: the path goes on as if it were not there"),
    ("G21 G01 X1. ,C.5", Code.NC_OPAQUE, "a corner that is not cut: no move comes after it"),
    ("G21 G01 X1. ,C.5\nG00 Z1.", Code.NC_OPAQUE, "a corner that is not cut: it is not between two cuts"),
    ("G21 ,R1.", Code.NC_OPAQUE, "a corner that is not cut: its block makes no move"),
    ("G21 G01 A30.\nM30", Code.NC_OPAQUE, "A30.: a line without an end, which the next block does not give"),
    ("G21 G01 X1. A180.", Code.NC_OPAQUE, "G21 G01 X1. A180.: a line that never gets there"),
    ("G21 G01 X1. Z1. A45.", Code.NC_OPAQUE, "G21 G01 X1. Z1. A45.: an angle beside both coordinates of the end"),
    ("T0101", Code.NC_OPAQUE, "T0101: the offset in the control's table is taken as zero"),
    ("G42", Code.NC_OPAQUE, "G42: the path is the programmed contour, not that of the tool's centre"),
    ("C90.", Code.NC_OPAQUE, "C90.: this axis is not in the path"),
    ("N1\nN2\nN1\nM99 P1", Code.NC_FLOW, "block N1 is there more than once: the next one is taken"),
]


@pytest.mark.parametrize(("text", "code", "message"), FANUC, ids=[text for text, _, _ in FANUC])
def test_what_is_said_of_programs_for_fanuc_controls(text: str, code: Code, message: str) -> None:
    program = fanuc(text)
    found = [*program.findings, *program.run(strict=False, block_limit=1000).findings]
    assert (code, message) in [(finding.code, finding.message) for finding in found]


def test_an_increment_is_not_displaced() -> None:
    program = fanuc("G21 G01 U1. F1.")
    with pytest.raises(TrueloopError, match=r"U1\. is an increment"):
        displace_word(program, program.block(0).words[2], 0.1, program.run().coordinate_state(0))
