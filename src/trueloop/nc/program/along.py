"""Moves of a tool path: places along them, the positions that the program itself states, the feed moves of a lathe as
lines and arcs in the profile plane, and how far the control keeps to the path through corners.

LinuxCNC starts in G64 without a tolerance unless its set-up says otherwise: it keeps up speed and rounds corners as
far as its accelerations ask, tenths of a millimetre at finishing feeds. A contour corrected by micrometres needs G61,
or G64 with P.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop._core import nc_said
from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.geometry.feature import Arc, Line, LineOrArc, Point
from trueloop.nc.program.parts import Lines
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import NO_COMPENSATION, Motion, ToolPath

PLANE_AXES: Final = {17: (0, 1), 18: (2, 0), 19: (1, 2)}
"""First and second axis of each plane: a positive angle turns from the first to the second."""


def points_along(path: ToolPath, move: Integers | np.intp, share: Array) -> Array:
    """Positions (n, 3) at shares (n,), 0 to 1, of moves (n,), or of one.

    On an arc the radius goes evenly from that of the start to that of the end, which rounding makes differ; a helix
    rises evenly.
    """
    move = np.broadcast_to(move, share.shape)
    start, end = path.start_mm[move], path.end_mm[move]
    points: Array = start + share[:, None] * (end - start)
    arcs = path.motion[move] == Motion.ARC
    for plane in np.unique(path.plane[move[arcs]]):
        i, j = PLANE_AXES[int(plane)]
        of = arcs & (path.plane[move] == plane)
        centre = path.centre_mm[move[of]][:, [i, j]]
        before, after = start[of][:, [i, j]] - centre, end[of][:, [i, j]] - centre
        first, last = np.hypot(*before.T), np.hypot(*after.T)
        radius = first + share[of] * (last - first)
        angle = np.arctan2(before[:, 1], before[:, 0]) - share[of] * path.sweep_rad[move[of]]  # sweep is clockwise
        points[of, i], points[of, j] = centre[:, 0] + radius * np.cos(angle), centre[:, 1] + radius * np.sin(angle)
    return points


def lengths_mm(path: ToolPath, move: Integers | None = None) -> Array:
    """Returns lengths of moves (n,), all by default: of an arc along it, of a helix √(arc² + rise²)."""
    move = np.arange(len(path)) if move is None else move
    way, arm = path.end_mm[move] - path.start_mm[move], path.start_mm[move] - path.centre_mm[move]
    length: Array = np.linalg.norm(way, axis=1)
    for plane, (i, j) in PLANE_AXES.items():
        of = (path.motion[move] == Motion.ARC) & (path.plane[move] == plane)
        turned = np.hypot(arm[of, i], arm[of, j]) * path.sweep_rad[move][of]
        length[of] = np.hypot(turned, way[of, 3 - i - j])
    return length


def said_ends(program: Program, path: ToolPath) -> tuple[Flags, Flags]:
    """Returns whether X, Y, Z are at positions that the program states, at start and end of each move, (n, 3) each.

    Before an axis is first named, after a way to a place of the machine (G28, G53) and after a change of tool or
    offset a run only assumes where it is. An increment from such a place leads to another.
    """
    block, word = path.block.astype(np.int32), path.word.astype(np.int32)
    after = nc_said(
        program.core, block, word, path.incremental, path.renamed.astype(np.uint32), path.plane.astype(np.uint8)
    )
    before = np.vstack([np.zeros((1, 3), dtype=np.bool_), after[:-1]])
    return before, after


EXACT, BLENDED = (61.0, 61.1), 64.0
HINT = "write G64 P0.0001 (inch) or G64 P0.002 (mm), or G61, before the first cut"


@dataclass(frozen=True)
class PathMode:
    """The line of a program's first cut, None before it has come, and the last block before it that names a mode."""

    file: str | None = None
    cut: int | None = None
    named: Block | None = None

    def and_then(self, path: ToolPath, lines: Lines) -> "PathMode":
        """Returns the state after these lines and their moves; unchanged for a control that does not blend corners."""
        if self.cut is not None or not lines.program.dialect.blends_corners:
            return self
        cuts = path.line[np.isin(path.motion, [Motion.LINE, Motion.ARC])]
        cut = int(cuts[0]) if cuts.size else None
        before = range(lines.until if cut is None else cut - lines.first)
        named = [block for block in map(lines.program.block, before) if mode_of(block) is not None]
        last = replace(named[-1], line=lines.first + named[-1].line) if named else self.named
        return PathMode(lines.program.file, cut, last)

    def findings(self) -> Iterator[Finding]:
        """Yields NC-BLEND where the first cut runs without a bound on the rounding of corners: a note where the program
        names no path mode, a warning where it names one without a bound. Blocks count in the order they are written.
        """
        if self.cut is None:
            return
        if self.named is None:
            message = "no path mode before the first cut: by its default LinuxCNC rounds corners without a bound"
            yield _finding(Severity.NOTE, message, Place(self.file, self.cut, 1))
        elif mode_of(self.named) == BLENDED and not any(word.letter == "P" for word in self.named.words):
            message = "G64 without P: corners are rounded as far as the machine's accelerations ask"
            yield _finding(Severity.WARNING, message, Place(self.file, self.named.line, 1))


def path_mode_findings(program: Program, path: ToolPath) -> Iterator[Finding]:
    """Yields `PathMode.findings` of a whole program."""
    return PathMode().and_then(path, Lines(program, program.block_count, 0)).findings()


def mode_of(block: Block) -> float | None:
    """Returns the path mode that a block names: `BLENDED`, or one of `EXACT`; None: it names none, or is skipped."""
    codes = [word.value for word in block.words if word.letter == "G" and not block.skipped]
    return next((code for code in codes if code in (*EXACT, BLENDED)), None)


def _finding(severity: Severity, message: str, place: Place) -> Finding:
    return Finding(severity, Code.NC_BLEND, message, HINT, place)


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
