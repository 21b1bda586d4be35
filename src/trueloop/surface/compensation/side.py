"""On which side of a surface a program's tool runs: the outer one, if the surface's normals point out of the part."""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.nc.program.program import Program
from trueloop.surface.compensation.cutter import contacts, tool_axes
from trueloop.surface.compensation.placed import looked_at, on_surface
from trueloop.surface.compensation.shift import SurfaceJob, is_cutting

PLACES: Final = 1000
"""Ends of moves that are looked at, spread over the program."""


def require_outer_side(program: Program, surface: Surface, job: SurfaceJob) -> None:
    """Raises SRF-SIGN where the program's tool cuts the surface from the side that the normals say is material.

    Says nothing of a program that cuts the surface on neither side, or cannot be run: its correction is refused with
    what is wrong with it.
    """
    try:
        path = on_surface(program.run(job.parameters), job)
        axes = tool_axes(program, path, job.rotary, job.axis)
        moves = np.flatnonzero(looked_at(path, job))
    except TrueloopError:
        return
    moves = moves[:: max(1, len(moves) // PLACES)]
    if not len(moves):
        return
    tips, out = path.end_mm[moves], axes.directions(moves, np.ones(len(moves)))
    outer, leaning = _cut_from(surface, job, tips, out)
    inner, _ = _cut_from(surface.turned_over(), job, tips, out)
    # A flat end on a flat face touches it alike from both sides: there its shank is to stand on the outer one.
    if inner > outer or (inner == outer > 0 and leaning < 0):
        raise Code.SRF_SIGN.refusal(
            f"the tool of {program.file or 'the program'!r} cuts the surface from its inner side, at {inner} of "
            f"{len(moves)} ends of moves",
            hint="the normals of the surface point into the material: turn them (surface.flip in the job), or mend "
            "cutter.axis",
        )


def _cut_from(surface: Surface, job: SurfaceJob, tips: Array, out: Array) -> tuple[int, float]:
    """At how many tips the cutter finishes the surface from the side of its normals, and the median cosine there
    between normals and the tool's axis.
    """
    found = contacts(surface, job.cutter, tips, out)
    cutting = is_cutting(found, job.cuts_mm)
    leaning = np.sum(found.feet.normal[cutting] * out[cutting], axis=1)
    return int(np.count_nonzero(cutting)), float(np.median(leaning)) if len(leaning) else 0.0
