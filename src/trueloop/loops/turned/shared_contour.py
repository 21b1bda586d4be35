"""A contour that a roughing cycle runs on as well: what a user should know before it is corrected."""

import numpy as np

from trueloop.arrays import Array
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.contour_cycles import finishing_cycle, roughed_by
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
