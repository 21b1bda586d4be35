"""What a program makes the machine do, whatever its words: moves in machine coordinates, joined where they go on."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion

STANDS_MM = 1e-5
"""What leads nowhere: no word says where a helix of Klartext ends, and the block after it makes up for its rounding."""

SAME_MM = 1e-3


@dataclass(frozen=True, eq=False)
class MachineMove:
    """A move in machine coordinates by the program's own offsets, mm, X a radius; of a rapid one no feed."""

    motion: Motion
    end_mm: Array
    centre_mm: Array
    sweep_rad: float
    feed: tuple[float, int]


def machine_moves(program: Program, parameters: Mapping[str, float] | None = None) -> list[MachineMove]:
    """The moves that lead somewhere; arcs that go on about the same centre are one."""
    path = program.run(parameters, trace=True)
    counts = np.diff(path.executed[:, 1], prepend=0)
    offset = np.repeat(path.executed_offset_mm, counts, axis=0)
    rapid = path.rapid
    found: list[MachineMove] = []
    for k in range(len(path)):
        centre = path.centre_mm[k] + offset[k]
        feed = (0.0, 0) if rapid[k] else (round(float(path.feed[k]), 4), int(path.feed_mode[k]))
        move = MachineMove(Motion(path.motion[k]), path.end_mm[k] + offset[k], centre, float(path.sweep_rad[k]), feed)
        if move.motion != Motion.ARC and np.abs(path.end_mm[k] - path.start_mm[k]).max() <= STANDS_MM:
            continue
        if found and _goes_on(found[-1], move, int(path.plane[k])):
            found[-1] = replace(move, sweep_rad=found[-1].sweep_rad + move.sweep_rad, centre_mm=found[-1].centre_mm)
        else:
            found.append(move)
    return found


def _goes_on(before: MachineMove, move: MachineMove, plane: int) -> bool:
    """Whether an arc goes on with the one before: a whole turn, then the rest."""
    in_plane = {17: [0, 1], 18: [0, 2], 19: [1, 2]}[plane]
    both = before.motion == move.motion == Motion.ARC and before.sweep_rad * move.sweep_rad > 0
    return both and bool(np.abs((before.centre_mm - move.centre_mm)[in_plane]).max() < SAME_MM)
