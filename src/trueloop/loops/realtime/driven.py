"""The control's path along a finish pass: its moves, and which of them cut, lead in and lead out.

Without cutter compensation these are the program's moves. Under G41 and G42 the control's own: it shortens moves at
concave corners and turns the nose about convex ones, by an arc that belongs to the block after the corner.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.commanded import Commanded, Run
from trueloop.nc.program.along import lengths_mm, points_along
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath

PLANE = (0, 2)
SAME_MM = 1e-9


@dataclass(frozen=True)
class Driven:
    """The moves as the control makes them; `centre` is the path of the nose's centre, `controlled` of what it controls.

    `cut` says by move which of the cuts of `contour` it makes; `run_out` are moves that only lengthen the contour.
    """

    contour: Commanded
    centre: ToolPath
    controlled: ToolPath
    cut: Mapping[int, int]
    run_out: frozenset[int]

    @cached_property
    def length_mm(self) -> Array:
        """Returns the length of every move, (n,)."""
        return lengths_mm(self.centre)

    @property
    def first(self) -> int:
        """Returns the first move along the contour."""
        return min([*self.cut, *(move for move in self.run_out if move < min(self.cut))])

    @property
    def last(self) -> int:
        """Returns the last move along the contour."""
        return max([*self.cut, *(move for move in self.run_out if move > max(self.cut))])

    @property
    def lead(self) -> int | None:
        """Returns the move that leads to the contour; None: none does, in the frame of the contour."""
        before = [move for move in range(self.first) if self.length_mm[move] > SAME_MM]
        return before[-1] if before and self.in_frame(before[-1]) else None

    def is_rapid(self, move: int) -> bool:
        """Returns whether a move is not at feed."""
        return bool(self.centre.motion[move] == Motion.RAPID)

    def in_frame(self, move: int) -> bool:
        """Returns whether the program's zero and its tool are those of the contour at a move."""
        path, first = self.centre, self.first
        same = np.all(np.abs(path.origin_mm[move] - path.origin_mm[first]) < SAME_MM)
        return bool(same and np.array_equal(path.renamed[move], path.renamed[first]))

    def centre_mm(self, move: int, share: Array) -> Array:
        """Returns the commanded positions of the nose's centre, (n,) → (n, 2), in the program's coordinates."""
        return points_along(self.centre, np.intp(move), share)[:, PLANE]

    def controlled_mm(self, move: int, share: Array) -> Array:
        """Returns the commanded positions of the controlled point, (n,) → (n, 2)."""
        return points_along(self.controlled, np.intp(move), share)[:, PLANE]


def driven(program: Program, contour: Commanded, run: Run, nose_radius_mm: float, tip: int) -> Driven:
    """Returns the control's moves of a program whose contour was matched. `tip`: the controlled point."""
    if not contour.match.on_contour:
        cut = {one.move: k for k, one in enumerate(contour.cuts)}
        run_out = frozenset(move.index for move in contour.match.run_out)
        return Driven(contour, contour.path, contour.path, cut, run_out)
    centre, controlled = (_compensated(program, run, nose_radius_mm, point) for point in (0, tip))
    main = {int(block): move for move, block in enumerate(centre.block)}  # the last of a block: an arc comes before it
    blocks = contour.path.block
    cut = {main[int(blocks[one.move])]: k for k, one in enumerate(contour.cuts)}
    return Driven(
        contour,
        centre,
        controlled,
        cut,
        frozenset(main[int(blocks[move.index])] for move in contour.match.run_out),
    )


def _compensated(program: Program, run: Run, nose_radius_mm: float, tip: int) -> ToolPath:
    return program.run(
        run.parameters,
        skipped_blocks=run.execute_deleted_blocks,
        tools=[CutterTool(nose_radius_mm, tip=tip)],
        strict=False,
        roughing=False,
    )
