"""Every way in which a program is refused or remarked upon."""

from collections.abc import Callable

from trueloop.errors import Code
from trueloop.nc.check import check
from trueloop.nc.edit import Edit, apply_edits, displace_word, set_offset
from trueloop.nc.program import Program, read_program
from trueloop.nc.tool_path import CoordinateState

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


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.NC_DIALECT: lambda: read_program(b"", "fanuc-0"),
    Code.NC_PARAMETER: lambda: ge2000t("G70\nG00 X(P46+0.0625)").run(),
    Code.NC_EXPRESSION: lambda: linuxcnc("G21 G0 X[1/0]").run(),
    Code.NC_WORD: lambda: ge2000t("G00 X1.0 ??").findings,
    Code.NC_CODE: lambda: ge2000t("G123").findings,
    Code.NC_DUPLICATE: lambda: ge2000t("G01 X1.0 X2.0").findings,
    Code.NC_NUMBER: lambda: ge2000t("G00 X6,2625").findings,
    Code.NC_MISPLACED: lambda: ge2000t("G70\nG02").run().findings,
    Code.NC_ARC: lambda: ge2000t("G70\nG00 X0 Z0\nG02 X4.0 Z0 R0.5 F1").run().findings,
    Code.NC_ARC_FIT: lambda: check(linuxcnc("G21 G18 G0 X10 Z0\nG2 X5.5 Z5 I-5 K0 F1")),
    Code.NC_TANGENT: lambda: check(linuxcnc("G21 G18 G8 G0 X10 Z-9\nG1 Z0 X9.7 F1\nG2 X4.7 Z5 I-5 K0")),
    Code.NC_FEED: lambda: check(linuxcnc("G21 G1 X10")),
    Code.NC_RAPID: lambda: check(
        linuxcnc("G21 G18 G8 F1\nG0 X20 Z0\nG1 X0\nG0 Z1\nG0 X10\nG1 Z-20\nG1 X12\nG0 Z-10\nG0 X8\nG0 X20")
    ),
    Code.NC_OPAQUE: lambda: linuxcnc("G21 G76 P1 Z-5 I1 J1 K1").run().findings,
    Code.NC_UNIT: lambda: linuxcnc("G0 X1").run().findings,
    Code.NC_FLOW: lambda: linuxcnc("o100 while [1]\nM2").run(),
    Code.NC_LIMIT: lambda: linuxcnc("o100 while [1]\nG91\no100 endwhile\nM2").run(block_limit=1000),
    Code.NC_EDIT: _overlapping_edits,
    Code.NC_OFFSET: lambda: set_offset(ge2000t("G00 X1.0"), "X", 0.01, DIAMETER_INCH),
}
