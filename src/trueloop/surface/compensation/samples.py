"""How a surface program is corrected, and the places along its moves that are looked at."""

from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.domain.option import Option
from trueloop.geometry.surface import Surface
from trueloop.nc.program.along import lengths_mm, points_along
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.points import CUTS_MM, moved_locations
from trueloop.surface.compensation.tool_axis import ToolAxes, tool_axes

UP: Final = (0.0, 0.0, 1.0)
TURN_DEG: Final = 1.0
"""The tool turns no more than this between two places that are looked at."""


@dataclass(frozen=True)
class SurfaceJob:
    """How a program is to be corrected: its cutter, the tool axis out of the material, or the letters of the words that
    turn it (`tool_axis`), the chord tolerance, the distance between the places looked at along a move, and what may be
    cut too deep.
    """

    cutter: Cutter
    axis: tuple[float, float, float] = UP
    tolerance_mm: Annotated[
        float,
        Option(
            "compensation.chord_um",
            "How far a block may deviate from the corrected path before blocks are put in.",
            above=0,
        ),
    ] = 5e-4
    sample_mm: float = 0.5
    gouge_mm: Annotated[
        float, Option("compensation.gouge_um", "How deep the cutter may go into the corrected surface.", above=0)
    ] = 5e-3
    cuts_mm: float = CUTS_MM
    rotary: str = ""


@dataclass(frozen=True, eq=False)
class Samples:
    """Places along the moves at feed: move and share of it (n,), and tips before and after (n, 3); and the tool's axes
    along all moves.
    """

    move: np.ndarray
    share: Array
    before_mm: Array
    after_mm: Array
    cutting: np.ndarray
    axes: ToolAxes

    @property
    def cutting_moves(self) -> np.ndarray:
        """Indices of the moves that cut."""
        return np.unique(self.move[self.cutting])


def places(
    path: ToolPath, axes: ToolAxes, moves: Integers, sample_mm: float, turn_deg: float = TURN_DEG
) -> tuple[Integers, Array]:
    """Places along moves, their ends included, no further apart than `sample_mm` and `turn_deg`: move and share."""
    pieces = np.ceil(np.maximum(lengths_mm(path, moves) / sample_mm, axes.turned_deg(moves) / turn_deg))
    pieces = np.maximum(1, pieces).astype(int)
    share = [np.linspace(0.0, 1.0, n + 1) for n in pieces]
    return np.repeat(moves, pieces + 1), np.concatenate(share) if share else np.empty(0)


def sampled(program: Program, path: ToolPath, nominal: Surface, corrected: Surface, job: SurfaceJob) -> Samples:
    """Places along all moves at feed, and where the correction takes them. Raises SRF-PROGRAM of `tool_axes`."""
    turning = tool_axes(program, path, job.rotary, job.axis)
    move, share = places(path, turning, np.flatnonzero(np.isin(path.motion, (Motion.LINE, Motion.ARC))), job.sample_mm)
    tips, axes = points_along(path, move, share), turning.directions(move, share)
    moved = moved_locations(nominal, corrected, job.cutter, tips, axes, cuts_mm=job.cuts_mm)
    return Samples(move, share, tips, moved.tips_mm, moved.cutting, turning)
