"""The offset variant run by LinuxCNC's own interpreter: in machine coordinates the contour moves, and nothing else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import Move, Tool, interpret
from trueloop.arrays import Array
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import read_program

JOB = Path(__file__).parents[2] / "examples" / "linuxcnc" / "job.toml"
TOOLS = [Tool(1, nose_radius_mm=0.79375, orientation=9)]
APPROACH = "G0 Z-6.54375\n"
FIRST_CUT = "G1 X[#46+2.2+0.0625] Z[-6.44375+[3.6-#46]/2] (to the collar)\n"
LEAD = "G0 Z[-6.44375+[3.6-#46]/2] (always"
RETRACT = "G0 Z0.13125\n"
FIRST, LAST = 4, 11
"""Moves of the contour, the way past the axis included."""


def corrected(*changes: tuple[str, str]) -> Correction:
    """The correction of the example with its finish program changed; z counts from no face, so that the tool's offset
    along Z shows in the touches.
    """
    inputs = read_job(JOB).inputs
    touches = replace(inputs.touches, at_reference=np.zeros_like(inputs.touches.at_reference))
    text = inputs.program.source.decode()
    for before, after in changes:
        assert text.count(before) == 1
        text = text.replace(before, after)
    return compensate(replace(inputs, touches=touches, program=read_program(text.encode(), "linuxcnc")))


def run(source: bytes | None, folder: Path) -> list[Move]:
    assert source is not None
    program = folder / "program.ngc"
    program.write_bytes(source)
    return interpret(program, tools=TOOLS)


def ends(moves: list[Move]) -> Array:
    return np.array([move.machine_mm for move in moves])


def moved_mm(correction: Correction, folder: Path) -> Array:
    """How far every move of the variant ends from where that of the source does, on the machine."""
    shifted, plain = (run(source, folder) for source in (correction.offsets_program, correction.source_program))
    assert [move.kind for move in shifted] == [move.kind for move in plain]
    return ends(shifted) - ends(plain)


OWN_SHIFTS = {
    "none": [],
    "G52": [(APPROACH, "G52 X0.2 Z-1\n" + APPROACH)],
    "G92": [(APPROACH, "G92 X6.1 Z1\n" + APPROACH)],
    "a work offset": [(" G54 ", " G55 "), (APPROACH, "G10 L2 P2 X.3 Z-20\n" + APPROACH)],
    "G52, and another after the contour": [(APPROACH, "G52 Z-1\n" + APPROACH), (RETRACT, "G52 Z-2\n" + RETRACT)],
}


@pytest.mark.parametrize("own", OWN_SHIFTS)
def test_the_contour_is_cut_off_by_the_offset_and_all_else_where_it_was(own: str, tmp_path: Path) -> None:
    """Whatever shift of the programmer's is in force: it stays in force, before, in and after the cut."""
    correction = corrected(*OWN_SHIFTS[own])
    dx_mm, dz_mm = correction.decision.offset_mm
    assert min(abs(dx_mm), abs(dz_mm)) > 0.01
    moved = moved_mm(correction, tmp_path)
    contour = moved[FIRST - 1 : LAST + 1]
    assert contour == pytest.approx(np.tile([dx_mm, 0.0, dz_mm], (len(contour), 1)), abs=1.3e-4)
    retract = LAST + 1
    assert moved[retract] == pytest.approx((dx_mm, 0.0, 0.0), abs=1.3e-4)  # inherits x: the tool stays where it is
    assert np.delete(moved, range(FIRST - 1, retract + 1), axis=0) == pytest.approx(0.0, abs=1e-9)


def test_a_shift_that_a_stopped_run_left_is_taken_back(tmp_path: Path) -> None:
    """LinuxCNC keeps it over a restart; the next run begins as the first did."""
    source = corrected().offsets_program or b""
    left_on = source.replace(b"%\n", b"%\nG20 G7 G52 X-0.0035 Z-0.0014\n", 1)
    first, again = run(source, tmp_path), run(left_on, tmp_path)
    assert [move.machine_mm for move in again] == [move.machine_mm for move in first]


def test_the_shift_begins_before_an_inherited_coordinate(tmp_path: Path) -> None:
    """The cut inherits X from two blocks before it: they are shifted with it."""
    approach = "G95 F0.005\nG0 X[#46+2.2+0.0625]\nG0 Z[-6.44375+[3.6-#46]/2]\nG1 Z[-6.14375+[3.6-#46]/2]\n"
    text = JOB.with_name("finish.ngc").read_text()
    old = text[text.index(LEAD) : text.index("G1 X[#46+1.8+0.03684]")]
    correction = corrected((old, approach))
    moved = moved_mm(correction, tmp_path)
    dx_mm, dz_mm = correction.decision.offset_mm
    cut = int(np.flatnonzero([move.kind == "line" for move in run(correction.source_program, tmp_path)])[0])
    assert moved[cut] == pytest.approx((dx_mm, 0.0, dz_mm), abs=1.3e-4)
    assert moved[cut - 1] == pytest.approx((dx_mm, 0.0, dz_mm), abs=1.3e-4)
