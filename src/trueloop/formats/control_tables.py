"""Compensation tables as controls read them.

LinuxCNC's COMP_FILE was read in its documentation; names and layout of Siemens' and Heidenhain's in their manuals, but
the sign with which those controls apply a value was not: run one axis by hand before trusting the table.
"""

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.machine.axis_table import AxisTable

LINUXCNC_MOST = 256


def linuxcnc_comp(table: AxisTable) -> str:
    """COMP_FILE of COMP_FILE_TYPE 0: nominal, actual forward, actual reverse; 256 rows at most, ascending.

    Its joint only: raises MCH-TABLE for an error of another axis. It switches BACKLASH off.
    """
    if table.input_axis != table.output or len(table.position_mm) > LINUXCNC_MOST:
        raise TrueloopError(
            Code.MCH_TABLE,
            f"a COMP_FILE holds {LINUXCNC_MOST} rows of an axis' own error, not {len(table.position_mm)} rows of "
            f"{table.output} as a function of {table.input_axis}",
            hint="correct the program instead: `trueloop machine compensate`",
        )
    actual = (table.position_mm + table.forward_mm, table.position_mm + table.reverse_mm)
    rows = zip(table.position_mm, *actual, strict=True)
    return "".join(f"{nominal:.6f} {forward:.6f} {reverse:.6f}\n" for nominal, forward, reverse in rows)


def siemens_cec(table: AxisTable, number: int = 0) -> str:
    """CEC tables: values −E; one table where both ways agree, else one for each way of travel. End values hold outside.

    Axis names are placeholders of the control's geometry axes: AX1 for X, AX2 for Y, AX3 for Z.
    """
    same = np.allclose(table.forward_mm, table.reverse_mm, atol=5e-7)
    ways = [(0, table.forward_mm)] if same else [(1, table.forward_mm), (-1, table.reverse_mm)]
    lines = ["%_N_NC_CEC_INI", "CHANDATA(1)"]
    for k, (direction, values) in enumerate(ways, number):
        step = float(table.position_mm[1] - table.position_mm[0])
        lines += [f"$AN_CEC[{k},{n}]={-value:.6f}" for n, value in enumerate(values)]
        lines += [
            f"$AN_CEC_INPUT_AXIS[{k}]=(AX{'XYZ'.index(table.input_axis) + 1})",
            f"$AN_CEC_OUTPUT_AXIS[{k}]=(AX{'XYZ'.index(table.output) + 1})",
            f"$AN_CEC_STEP[{k}]={step:.6f}",
            f"$AN_CEC_MIN[{k}]={table.position_mm[0]:.6f}",
            f"$AN_CEC_MAX[{k}]={table.position_mm[-1]:.6f}",
            f"$AN_CEC_DIRECTION[{k}]={direction}",
            f"$AN_CEC_MULT_BY_TABLE[{k}]=0",
            f"$AN_CEC_IS_MODULO[{k}]=0",
        ]
    return "\n".join([*lines, "M17", ""])


def heidenhain_com(tables: list[AxisTable]) -> str:
    """A .COM table of one input axis: AXISPOS, BACKLASH, and a column −E (forward) for each dependent axis.

    BACKLASH is the mean of return minus forward of the axis' own error. Raises MCH-TABLE for several input axes.
    """
    if len({table.input_axis for table in tables}) != 1:
        raise TrueloopError(
            Code.MCH_TABLE,
            f"{len(tables)} tables have the input axes {' '.join(table.input_axis for table in tables)}",
            hint="write one .COM file an input axis and name them in the .CMA",
        )
    own = [table for table in tables if table.output == table.input_axis]
    backlash = float(np.mean(own[0].reverse_mm - own[0].forward_mm)) if own else 0.0
    header = ["NR", "AXISPOS", "BACKLASH", *(table.output for table in tables)]
    lines = ["BEGIN TRUELOOP.COM MM", "".join(f"{name:<12}" for name in header).rstrip()]
    for n, position in enumerate(tables[0].position_mm):
        cells = [f"{n}", f"{position:+.4f}", f"{backlash:+.4f}", *(f"{-t.forward_mm[n]:+.4f}" for t in tables)]
        lines.append("".join(f"{cell:<12}" for cell in cells).rstrip())
    return "\n".join([*lines, "[END]", ""])


def heidenhain_cma(files: dict[str, str]) -> str:
    """A .CMA file: one column an axis, naming its .COM file."""
    header = "NR".ljust(12) + "".join(axis.ljust(16) for axis in files)
    row = "0".ljust(12) + "".join(file.ljust(16) for file in files.values())
    return "\n".join(["BEGIN TRUELOOP.CMA", header.rstrip(), row.rstrip(), "[END]", ""])
