"""Where moves start once the ends of the cuts before them are displaced."""

from collections.abc import Mapping

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.units import UM_PER_MM


def held_starts(path: ToolPath, ends: Mapping[int, Array]) -> Array:
    """Where each move starts in the written program, (n, 3): coordinates that no word sets stay displaced."""
    held = np.array(path.start_mm)
    for move in range(1, len(path)):
        last = ends.get(move - 1)
        if last is None:
            last = np.where(path.word[move - 1] >= 0, path.end_mm[move - 1], held[move - 1])
        held[move] = last + (path.start_mm[move] - path.end_mm[move - 1])
    return held


def require_arcs_stay(program: Program, path: ToolPath, ends: Mapping[int, Array]) -> None:
    """Raises SRF-PROGRAM for an arc that starts where a cut left a coordinate displaced: its centre would not fit."""
    off = np.abs(held_starts(path, ends) - path.start_mm).max(axis=1, initial=0.0)
    step_mm = np.where(path.inch, program.dialect.step_mm(True), program.dialect.step_mm(False))
    moved = np.flatnonzero((path.motion == Motion.ARC) & (off > step_mm / 2))
    if len(moved):
        raise TrueloopError(
            Code.SRF_PROGRAM,
            f"this arc starts {off[moved[0]] * UM_PER_MM:.2f} µm from where it did: its centre would not fit",
            hint="name all axes in the move before it, or lead out by a line",
            place=program.place(program.block(int(path.block[moved[0]])).start),
        )
