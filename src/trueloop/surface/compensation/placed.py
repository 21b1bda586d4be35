"""A program's path in the coordinates of its surface: position + the program's own shift + zero of the work offset.

On which side of a surface a program's tool runs: the outer one, if the surface's normals point out of the part.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.nc.program.called import offset_number
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.surface.compensation.cutter import contacts, tool_axes
from trueloop.surface.compensation.shift import SurfaceJob, is_cutting

SAME_MM = 1e-9


def shifts_mm(path: ToolPath, job: SurfaceJob) -> Array:
    """Returns positions on the surface less those of the program, (n, 3): G52, TRANS, cycle 7 and the job's zero."""
    return np.asarray(path.register_mm + np.asarray(job.zero_mm))


def on_surface(path: ToolPath, job: SurfaceJob) -> ToolPath:
    """Returns the path in the coordinates of the surface."""
    by = shifts_mm(path, job)
    return replace(path, start_mm=path.start_mm + by, end_mm=path.end_mm + by, centre_mm=path.centre_mm + by)


def looked_at(path: ToolPath, job: SurfaceJob) -> Flags:
    """Returns which moves at feed (n,) may cut the surface: those in the job's work offsets and of its tool, all where
    it names none.
    """
    at_feed = np.isin(path.motion, (Motion.LINE, Motion.ARC))
    if job.tool is not None:
        at_feed &= path.tool == job.tool
    if job.work_offsets:
        at_feed &= np.isin(path.work_offset, list(map(_number, job.work_offsets)))
    return at_feed


def _number(name: str) -> int:
    number = offset_number(name)
    if number is None:
        raise Code.SRF_PROGRAM.refusal(
            f"program.work_offsets names {name!r}, which is not a work offset",
            hint='write them as the program does: work_offsets = ["G54"], "G54.1 P1", "G505"',
        )
    return number


def require_one_zero(program: Program, path: ToolPath, job: SurfaceJob) -> None:
    """Raises SRF-PROGRAM where the zero of moves at feed is not known relative to the surface: in several work offsets
    of which the job names none, in one that the program itself changes, or by G92, which names a place of the machine.
    """
    moves = np.flatnonzero(looked_at(path, job))
    if not len(moves):
        return
    offsets = path.work_offset[moves]
    if not job.work_offsets and np.any(other := offsets != offsets[0]):
        raise _refusal(
            program,
            path,
            int(moves[other][0]),
            f"the program cuts in {len(np.unique(offsets))} work offsets: which of their zeros is that of the surface "
            "is not known",
            'name those whose zero lies at program.zero_mm: program.work_offsets = ["G54"]; moves in others stay',
        )
    zero = path.origin_mm[moves] - path.register_mm[moves]
    for offset in np.unique(offsets):
        of = np.flatnonzero(offsets == offset)
        changed = of[np.abs(zero[of] - zero[of[0]]).max(axis=1) > SAME_MM]
        if len(changed):
            raise _refusal(
                program,
                path,
                int(moves[changed[0]]),
                "the program changes the work offset, or the tool's, between its cuts: the place on the surface is "
                "not known",
                "shift the zero by G52, TRANS or cycle 7, which is followed, or set the offsets before the first cut",
            )
    _require_no_probe(program, path, moves)
    _require_no_register(program, path, moves[np.abs(path.register_mm[moves]).max(axis=1) > SAME_MM])


def _require_no_probe(program: Program, path: ToolPath, moves: Integers) -> None:
    """Refuses a probing cycle between the first and the last cut: it may set the zero anew."""
    first, last = int(path.block[moves[0]]), int(path.block[moves[-1]])
    for word in (word for index in range(first, last + 1) for word in program.block(index).words):
        if program.core.meaning(word.index) == "Probe":
            raise Code.SRF_PROGRAM.refusal(
                f"{word.text!r} probes between the cuts of the surface and may set the zero anew: the place on the "
                "surface is not known after it",
                hint="probe before the first cut",
                place=program.place(word.start),
            )


def _require_no_register(program: Program, path: ToolPath, shifted: Integers) -> None:
    words = (word for block in program.blocks for word in block.words if word.letter == "G")
    if len(shifted) and any(program.core.meaning(word.index) == "SetRegister" for word in words):
        raise _refusal(
            program,
            path,
            int(shifted[0]),
            "the zero of this cut is set by G92 at a place that only the control knows",
            "set the zero by the work offset, or shift it by G52, which is followed",
        )


def require_same_shifts(path: ToolPath, written_mm: Array) -> None:
    """Raises SRF-PROGRAM where the written program shifts moves of the source by other amounts, (n, 3), than it: G92 is
    set where a cut left the tool displaced.
    """
    other = np.flatnonzero(np.abs(path.register_mm - written_mm).max(axis=1, initial=0.0) > SAME_MM)
    if len(other):
        raise Code.SRF_PROGRAM.refusal(
            "the position register (G92) is set where a cut left the tool displaced: all after it would be displaced",
            hint="name all axes in a move between the cut and G92, or set the zero by the work offset",
            place=Place(line=int(path.line[other[0]]), column=1),
        )


def _refusal(program: Program, path: ToolPath, move: int, what: str, hint: str) -> TrueloopError:
    return Code.SRF_PROGRAM.refusal(what, hint=hint, place=program.place(program.block(int(path.block[move])).start))


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
