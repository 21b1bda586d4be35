"""Roughing cycles that run on the contour: they move with it, which notes say, or stay where they were; then their
passes are compared, and what they leave to be cut.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Place, TrueloopError
from trueloop.loops.turned.commanded import Run
from trueloop.nc.edit.changes import composed
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.expand.expand import WrittenOut, require_same_path, written_out
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.compensation.contour import CentrePiece
from trueloop.turned.program.contour_cycles import finishing_cycle, own_contour, roughed_by, roughing_cycles
from trueloop.units import UM_PER_MM
from trueloop.wording import wording


def shared_contour_notes(
    program: Program, path: ToolPath, move: int, x_before_mm: Array, x_after_mm: Array
) -> list[str]:
    """Says which roughing cycle shares the contour that a move is on, and what it may object to.

    The contour's ends in x (n,), before and after correcting.
    """
    cycle = finishing_cycle(program, path, move)
    cycles = [] if cycle is None else roughed_by(program, cycle)
    notes: list[str] = [
        wording(
            "The roughing cycle of line {line} runs on the blocks of the contour: its passes move with it.",
            line=other.block.line,
        )
        for other in cycles
    ]
    if program.dialect.contours_by_number and cycles and _runs_one_way(x_before_mm) and not _runs_one_way(x_after_mm):
        notes.append(
            wording(
                "The corrected contour does not rise throughout in X any more: a control that demands this of G71 "
                'refuses to rough on it. `programs.roughing = "stays"` leaves the roughing on the given one.'
            )
        )
    return notes


def roughing_stays_notes(program: Program, path: ToolPath, move: int) -> list[str]:
    """Says which roughing cycle cuts as before, where the one that finishes has a contour of its own."""
    cycle = finishing_cycle(program, path, move)
    cycles = [] if cycle is None else roughed_by(program, cycle)
    return [
        wording(
            "The roughing cycle of line {line} cuts what it cut before; the finish pass has a contour of its own.",
            line=other.block.line,
        )
        for other in cycles
    ]


def _runs_one_way(x: Array) -> bool:
    return bool(np.all(np.diff(x) >= 0) or np.all(np.diff(x) <= 0))


SAME_MM: Final = 1e-6
"""The distance that a pass of the roughing may lie from where it was."""
SAMPLES: Final = 401
SAMPLES_OF_MOVE: Final = 33
_WAYS: Final = ("start_mm", "end_mm", "centre_mm", "sweep_rad")


def with_own_contour(program: Program, path: ToolPath, cut: int, run: Run) -> WrittenOut:
    """Returns the program in which no roughing cycle runs on the contour that this move cuts.

    Raises NC-EDIT where that cannot be done without changing the path.
    """
    edits = tuple(own_contour(program, path, cut))
    if not edits:
        return WrittenOut(program, path, ())
    apart = program.rewritten(apply_edits(program, edits))
    own = WrittenOut(apart, run.of(apart), edits)
    require_same_path(program, path, own)
    return own


def then_written_out(program: Program, own: WrittenOut, moves: range, run: Run) -> WrittenOut:
    """Returns `written_out` of a program that was edited before, with the edits of both."""
    with own.in_lines_of(program):
        explicit = written_out(own.program, own.path, moves, run.of)
    return WrittenOut(explicit.program, explicit.path, tuple(composed(program.source, own.edits, explicit.edits)))


def require_roughing_stays(
    run: Run,
    programs: tuple[Program, Program],
    pieces: tuple[Sequence[CentrePiece], Sequence[CentrePiece]],
    tolerance_mm: float,
) -> None:
    """Compares programs before and after, and contours (paths of the nose's centre) before and after.

    Raises NC-EDIT where a pass of the roughing lies elsewhere, and CMP-STOCK where one that stays lies below the
    corrected contour by more than the tolerance, and further than it lay below the given one.
    """
    before, after = (run.with_roughing(program) for program in programs)
    was, now = (_passes(program, path) for program, path in zip(programs, (before, after), strict=True))
    if not _same(before, was, after, now):
        raise _moved(programs[0])
    cuts = np.flatnonzero(now & (after.motion != Motion.RAPID))
    if not cuts.size:
        return
    shares = np.linspace(0.0, 1.0, SAMPLES_OF_MOVE)
    points = np.concatenate([points_along(after, np.intp(k), shares) for k in cuts])[:, [0, 2]]
    given, corrected = (_above_mm(points, of) for of in pieces)
    below = np.where(corrected < given, -corrected, 0.0)
    worst = int(np.argmax(below))
    if below[worst] > tolerance_mm:
        line = int(after.line[cuts[worst // SAMPLES_OF_MOVE]])
        point = points[worst]
        below_um = float(below[worst]) * UM_PER_MM
        raise Code.CMP_STOCK.refusal(
            f"the roughing of line {line} of the corrected program stays, and would cut {below_um:.2f} µm below the "
            f"corrected contour at x {point[0]:.4f} mm (radius), z {point[1]:.4f} mm",
            hint='leave more on with U and W of the roughing cycle, or have `programs.roughing = "moves"`',
            place=Place(programs[1].file),
            values={"below_um": below_um},
        )


def _passes(program: Program, path: ToolPath) -> Flags:
    """Returns whether each move is one of a roughing cycle."""
    return np.isin(path.block, [cycle.block.index for cycle in roughing_cycles(program)])


def _same(before: ToolPath, was: Flags, after: ToolPath, now: Flags) -> bool:
    if not np.array_equal(before.motion[was], after.motion[now]):
        return False
    pairs = ((getattr(before, name)[was], getattr(after, name)[now]) for name in _WAYS)
    return all(np.allclose(one, other, rtol=0.0, atol=SAME_MM, equal_nan=True) for one, other in pairs)


def _above_mm(points: Array, pieces: Sequence[CentrePiece]) -> Array:
    """Returns how far points (n, 2) lie outside of a path of the nose's centre; infinitely beyond its ends."""
    from scipy.spatial import KDTree  # slow to import

    places, normals = [], []
    for piece in pieces:
        s = np.linspace(piece.start_mm, piece.end_mm, SAMPLES)
        tangent = piece.shifted.tangent(s)
        places.append(piece.shifted.centre_mm(s))
        normals.append(np.stack([tangent[:, 1], -tangent[:, 0]], axis=-1))
    way, normal = np.concatenate(places), np.concatenate(normals)
    nearest = np.asarray(KDTree(way).query(points)[1])
    inside = (nearest > 0) & (nearest < len(way) - 1)
    return np.where(inside, np.sum((points - way[nearest]) * normal[nearest], axis=1), np.inf)


def _moved(program: Program) -> TrueloopError:
    cycle = roughing_cycles(program)[0]
    return Code.NC_EDIT.refusal(
        "roughing shall stay where it is, and its passes hang on blocks of the contour that the finishing cycle cuts",
        hint='write the contour between P and Q without calls, or have `programs.roughing = "moves"`',
        place=program.place(cycle.block.start),
    )
