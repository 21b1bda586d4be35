"""The corrected program read by LinuxCNC's own interpreter: it must command the path that we say it commands."""

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
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.options import Arcs

JOB = Path(__file__).parents[2] / "examples" / "linuxcnc" / "job.toml"
WITHIN_MM = 0.0001
TOOLS = [Tool(1, nose_radius_mm=0.79375, orientation=9)]


def corrected(arcs: Arcs = "auto") -> Correction:
    inputs = read_job(JOB).inputs
    return compensate(replace(inputs, options=replace(inputs.options, arcs=arcs)))


def ends(moves: list[Move]) -> Array:
    return np.array([move.end_mm for move in moves])


def own(source: bytes) -> ToolPath:
    return read_program(source, "linuxcnc").run()


@pytest.mark.parametrize("arcs", ["auto", "lines", "arcs"])
def test_linuxcnc_follows_our_path(tmp_path: Path, arcs: Arcs) -> None:
    source = corrected(arcs).corrected_program
    program = tmp_path / "corrected.ngc"
    program.write_bytes(source)
    theirs, ours = interpret(program, tools=TOOLS), own(source)
    assert len(theirs) == len(ours)
    assert np.abs(ends(theirs) - ours.end_mm).max() < WITHIN_MM
    for k, move in enumerate(theirs):
        assert (move.kind == "arc") == (ours.motion[k] == Motion.ARC)
        if move.centre_mm is not None:
            assert move.centre_mm == pytest.approx(tuple(ours.centre_mm[k]), abs=WITHIN_MM)
            assert move.sweep_rad == pytest.approx(float(ours.sweep_rad[k]), abs=1e-5)
