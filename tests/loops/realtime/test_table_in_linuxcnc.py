"""LinuxCNC cuts the given program with its table in force, and the drives go where the corrected program goes.

A contour under G41: the control turns the nose about edges and shortens moves at a corner, and reports the lines by
which the table is chosen. The path of the corrected program is that of LinuxCNC's interpreter.
"""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from tests.loops.test_realtime_table import END, FORWARD, KNOB, START, Judged, inputs_of, judged
from tests.support.line_table import off_moves_mm
from trueloop.domain.record import sha256_of
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import Identity, Image, RealTimeLimits
from trueloop_lab.linuxcnc.realtime.session import Driven, Setup, drive, home, on, put, record, run, wait

ZERO = (0.0, 0.0)
IN_FORCE = 3
UM = 1e-3
PINS = (
    *("joint.0.pos-cmd", "joint.1.pos-cmd", "rtec.out-0", "rtec.out-2", "joint.0.motor-offset", "joint.1.motor-offset"),
    *("rtec.line", "rtec.fault-code", "rtec.on-path", "rtec.corr-0", "rtec.corr-2"),
)
CONTOUR = range(5, 10)
"""Lines from the first cut to the last."""


@cache
def cut(mode: str) -> tuple[Judged, Driven]:
    """The given program in LinuxCNC with its table, at 50 mm/s."""
    source = (START + FORWARD + END).replace("G64 P0.002 Q0", mode).replace("F100", "F3000")
    with TemporaryDirectory() as folder:
        found = judged(inputs_of(source.encode(), KNOB), Path(folder), origin_mm=ZERO)
    travel = RealTimeLimits(((-500.0, 2000.0), (-1.0, 1.0), (-2000.0, 2000.0)))
    image = Image(
        Identity("lathe", "8", program="given.ngc", program_sha256=sha256_of(source.encode())),
        travel,
        None,
        found.table.blocks,
    )
    files = {"given.ngc": source.encode(), "tool.tbl": b"T1 P1 X0 Z0 D1.6 Q9\n"}
    steps = [
        *(on(), home(), put("rtec.program", 1), put("rtec.enable", 1), wait("rtec.phase", IN_FORCE)),
        *(record(), run("given.ngc"), record(on=False)),
    ]
    return found, drive(Setup(image_to_bytes(image), files, PINS, module="program=given.ngc"), steps)


@pytest.mark.parametrize("mode", ["G61", "G64 P0.002 Q0"])
def test_the_drives_go_where_the_corrected_program_goes(mode: str) -> None:
    """As near to the corrected program's path as motion itself keeps to the given one's, which G64 P rounds at corners
    and which LinuxCNC's motion leaves by 0.29 µm on the arcs that it puts about edges.
    """
    found, driven = cut(mode)
    assert not driven.messages and not driven["rtec.fault-code"].any()
    commanded = np.column_stack([driven["joint.0.pos-cmd"], driven["joint.1.pos-cmd"]])
    went = np.column_stack([driven[f"rtec.out-{k}"] - driven[f"joint.{j}.motor-offset"] for k, j in ((0, 0), (2, 1))])
    cutting = np.isin(driven["rtec.line"], CONTOUR) & (commanded[:, 1] > -60.0)
    assert cutting.sum() > 1000 and driven["rtec.on-path"][cutting].mean() > 0.99
    given, corrected = ([move for move in moves if move.kind != "rapid"] for moves in (found.given, found.corrected))
    motion_mm = off_moves_mm(commanded[cutting], given, ZERO)
    assert np.max(motion_mm) < 2.5 * UM
    assert np.max(off_moves_mm(went[cutting], corrected, ZERO) - motion_mm) < 0.1 * UM
    assert np.max(off_moves_mm(commanded[cutting], corrected, ZERO)) > 25 * UM, "there was something to correct"


def test_nothing_is_added_after_the_way_out() -> None:
    _, driven = cut("G61")
    end = driven["rtec.line"] > max(block.line for block in cut("G61")[0].table.blocks)
    assert end.any()
    assert not driven["rtec.corr-0"][end][-5:].any() and not driven["rtec.corr-2"][end][-5:].any()
