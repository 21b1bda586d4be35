"""The feed moves of a lathe's tool path as lines and arcs in the profile plane."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, Place
from trueloop.geometry.feature import Arc, Line, LineOrArc, Point
from trueloop.nc.program.tool_path import NO_COMPENSATION, Motion, ToolPath

_SAME_PLACE_MM: Final = 1e-9
_X, _Z = 0, 2
_LATHE_PLANE: Final = 18


@dataclass(frozen=True)
class FeedMove:
    """One move at feed: its index in the tool path, its line in the program, its shape in (x, z), x a radius.

    Moves with the same `chain` follow each other without a rapid move or a jump between them. `compensation` is 40 for
    a move of the nose's centre, 41 or 42 for one of the contour, from which the control keeps the nose.
    """

    index: int
    line: int
    chain: int
    path: LineOrArc
    compensation: int = NO_COMPENSATION

    @property
    def on_contour(self) -> bool:
        """Returns whether the move is one of the contour, not of the nose's centre."""
        return self.compensation != NO_COMPENSATION


def feed_moves(tool_path: ToolPath) -> tuple[FeedMove, ...]:
    """Lines and arcs (G01–G03) in program order, those that lead nowhere left out.

    Rapid, probing and threading moves, arcs outside the XZ plane, changes of frame and of compensation end a chain.
    """
    arcs = (tool_path.motion == Motion.ARC) & (tool_path.plane == _LATHE_PLANE)
    travels = np.hypot(*(tool_path.end_mm - tool_path.start_mm)[:, [_X, _Z]].T) > _SAME_PLACE_MM
    cutting = arcs | ((tool_path.motion == Motion.LINE) & travels)
    mode = tool_path.compensation
    kept = np.flatnonzero(cutting | travels)
    chains = np.cumsum(_breaks(tool_path, kept, cutting))
    return tuple(
        FeedMove(int(k), int(tool_path.line[k]), int(chain), _shape(tool_path, int(k)), int(mode[k]))
        for k, chain in zip(kept, chains, strict=True)
        if cutting[k]
    )


def _breaks(tool_path: ToolPath, kept: NDArray[np.intp], cutting: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """For each kept move, whether no chain runs on into it: it or the one before is not a cut, or they do not meet."""
    jump = np.abs(tool_path.start_mm[kept[1:]] - tool_path.end_mm[kept[:-1]]).max(axis=1, initial=0.0)
    same = tool_path.compensation[kept[1:]] == tool_path.compensation[kept[:-1]]
    joined = cutting[kept[1:]] & cutting[kept[:-1]] & (jump <= _SAME_PLACE_MM) & same
    return np.concatenate([np.zeros(min(len(kept), 1), dtype=np.bool_), ~joined])


def _shape(tool_path: ToolPath, k: int) -> LineOrArc:
    start, end = _point(tool_path.start_mm[k]), _point(tool_path.end_mm[k])
    if tool_path.motion[k] == Motion.LINE:
        return Line("", start, end)
    return Arc("", start, end, _point(tool_path.centre_mm[k]), float(tool_path.sweep_rad[k]))


def _point(position_mm: Array) -> Point:
    return float(position_mm[_X]), float(position_mm[_Z])


def moves_of_one_kind(moves: Sequence[FeedMove], nose_radius_mm: float) -> tuple[list[FeedMove], float]:
    """Returns the moves of the contour where the program has any, else all; and their distance from the contour.

    That is the nose radius for moves of the nose's centre, 0 for moves of the contour.
    """
    contour = [move for move in moves if move.on_contour]
    return (contour, 0.0) if contour else (list(moves), nose_radius_mm)


def nose_centre_moves(tool_path: ToolPath) -> tuple[FeedMove, ...]:
    """Returns `feed_moves` of a program without nose compensation. Raises NC-COMPENSATED for one with it."""
    moves = feed_moves(tool_path)
    for move in moves:
        if move.on_contour:
            raise Code.NC_COMPENSATED.refusal(
                f"line {move.line} cuts with nose compensation G{move.compensation}: its path is not the nose centre's",
                hint="write the pass as the path of the nose centre (G40), as a CAM system does without G41/G42",
                place=Place(line=move.line),
                values={"compensation": f"G{move.compensation}"},
            )
    return moves
