"""Compensation tables as controls read them.

LinuxCNC's COMP_FILE is tested in LinuxCNC: the motor goes where the error is undone. For Siemens and Heidenhain names
and layout are those of their manuals. With which sign those controls apply a value the manuals do not say of these
tables (of Siemens' other one, ENC_COMP, that a positive value moves the axis in the negative direction). Values here
are meant to be added to the command; the files say that this has to be tried, and `opposite` turns all signs round.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

import numpy as np

from trueloop.errors import Code
from trueloop.formats.measurements.rows import csv_cell
from trueloop.turned.compensation.targets import CorrectionTable
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:  # slow to import
    from trueloop.machine.correct import AxisTable

HEADER = "feature,commanded_x_radius_mm,commanded_z_mm,correction_x_radius_um,correction_z_um"


def table_to_csv(table: CorrectionTable) -> bytes:
    """Rows in cutting order. Positions to a nanometre, corrections to a picometre: below what a control resolves.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> table = trueloop.table_to_csv(trueloop.compensate(job.inputs).table)
    >>> for row in table.decode().splitlines()[:2]:
    ...     print(row)
    feature,commanded_x_radius_mm,commanded_z_mm,correction_x_radius_um,correction_z_um
    collar,73.437750,-162.655250,-13.792704,-0.002140
    """
    rows = zip(table.feature, table.commanded_mm.tolist(), (table.correction_mm * UM_PER_MM).tolist(), strict=True)
    lines = [f"{csv_cell(name)},{x:.6f},{z:.6f},{dx:+.6f},{dz:+.6f}" for name, (x, z), (dx, dz) in rows]
    return "\n".join([HEADER, *lines, ""]).encode()


LINUXCNC_MOST = 256


def linuxcnc_comp(table: "AxisTable") -> str:
    """COMP_FILE of COMP_FILE_TYPE 0: nominal, actual forward, actual reverse; 256 rows at most, ascending.

    Its joint only: raises MCH-TABLE for an error of another axis. It switches BACKLASH off.
    """
    if table.input_axis != table.output or len(table.position_mm) > LINUXCNC_MOST:
        raise Code.MCH_TABLE.refusal(
            f"a COMP_FILE holds {LINUXCNC_MOST} rows of an axis' own error, not {len(table.position_mm)} rows of "
            f"{table.output} as a function of {table.input_axis}",
            hint="correct the program instead: `trueloop machine compensate`",
            values={"rows": len(table.position_mm), "limit": LINUXCNC_MOST, "axis": table.output},
        )
    actual = (table.position_mm + table.forward_mm, table.position_mm + table.reverse_mm)
    rows = zip(table.position_mm, *actual, strict=True)
    return "".join(f"{nominal:.6f} {forward:.6f} {reverse:.6f}\n" for nominal, forward, reverse in rows)


def siemens_cec(table: "AxisTable", *, opposite: bool = False) -> str:
    """CEC tables: values −E; one table where both ways agree, else one for each way of travel. End values hold outside.

    Axis names are placeholders of the control's geometry axes: AX1 for X, AX2 for Y, AX3 for Z.
    """
    ways = [(1, table.forward_mm), (-1, table.reverse_mm)] if _both_ways(table) else [(0, table.forward_mm)]
    sign = 1.0 if opposite else -1.0
    lines = ["%_N_NC_CEC_INI", *(f"; {words}" for words in CAUTION), "CHANDATA(1)"]
    for k, (direction, values) in enumerate(ways):
        step = float(table.position_mm[1] - table.position_mm[0])
        lines += [f"$AN_CEC[{k},{n}]={sign * value:.6f}" for n, value in enumerate(values)]
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


CAUTION: Final = (
    "The sign with which the control applies these values was not tried: they are meant to be added to the command.",
    "Move one axis to where its value is largest, with the table on and off, before the table is trusted.",
)


def heidenhain_com(table: "AxisTable", *, opposite: bool = False) -> str:
    """A .COM table: AXISPOS from the machine's datum, and −E on the way forward in the column of the corrected axis.

    BACKLASH holds the values of the way back where they differ: those "measured in the negative direction of traverse".
    """
    sign = 1.0 if opposite else -1.0
    names = ["NR", "AXISPOS", *(["BACKLASH"] if _both_ways(table) else []), table.output]
    lines = ["BEGIN TRY-SIGN-FIRST.COM MM", "".join(f"{name:<12}" for name in names).rstrip()]
    for n, position in enumerate(table.position_mm):
        back = [f"{sign * table.reverse_mm[n]:+.5f}"] if _both_ways(table) else []
        cells = [f"{n}", f"{position:+.4f}", *back, f"{sign * table.forward_mm[n]:+.5f}"]
        lines.append("".join(f"{cell:<12}" for cell in cells).rstrip())
    return "\n".join([*lines, "[END]", ""])


def heidenhain_cma(input_axis: str, com_file: str) -> str:
    """A .CMA file with one active line: the .COM table in the column of the axis whose position it runs over."""
    return f"BEGIN TRUELOOP.CMA\nNR      ACTIVE  {input_axis}\n0       *       {com_file}\n[END]\n"


def _both_ways(table: "AxisTable") -> bool:
    return not np.allclose(table.forward_mm, table.reverse_mm, atol=5e-7)


@dataclass(frozen=True)
class ControlTables:
    """A control's tables: `files`(table, file's name, opposite=…) gives texts; `caution` "": the sign was tried."""

    files: Callable[..., list[tuple[str, str]]]
    caution: tuple[str, ...] = CAUTION


def _of_linuxcnc(table: "AxisTable", name: str, *, opposite: bool) -> list[tuple[str, str]]:
    assert not opposite  # the sign was tried
    return [(name, linuxcnc_comp(table))]


def _of_siemens(table: "AxisTable", name: str, *, opposite: bool) -> list[tuple[str, str]]:
    return [(name, siemens_cec(table, opposite=opposite))]


def _of_heidenhain(table: "AxisTable", name: str, *, opposite: bool) -> list[tuple[str, str]]:
    cma = PurePath(name).with_suffix(".cma").name
    return [(name, heidenhain_com(table, opposite=opposite)), (cma, heidenhain_cma(table.input_axis, name))]


TABLES: Final[Mapping[str, ControlTables]] = {
    "linuxcnc": ControlTables(_of_linuxcnc, caution=()),
    "siemens": ControlTables(_of_siemens),
    "heidenhain": ControlTables(_of_heidenhain),
}
