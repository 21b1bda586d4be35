"""A program's path in the coordinates of its surface: position + the program's own shift + zero of the work offset."""

from dataclasses import replace

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.program.called import offset_number
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.surface.compensation.shift import SurfaceJob

SAME_MM = 1e-9


def shifts_mm(path: ToolPath, job: SurfaceJob) -> Array:
    """Returns positions on the surface less those of the program, (n, 3): G52, TRANS, cycle 7 and the job's zero."""
    return np.asarray(path.register_mm + np.asarray(job.zero_mm))


def on_surface(path: ToolPath, job: SurfaceJob) -> ToolPath:
    """Returns the path in the coordinates of the surface."""
    by = shifts_mm(path, job)
    return replace(path, start_mm=path.start_mm + by, end_mm=path.end_mm + by, centre_mm=path.centre_mm + by)


def looked_at(path: ToolPath, job: SurfaceJob) -> Flags:
    """Returns which moves at feed (n,) may cut the surface: those in the job's work offsets, all where it has none."""
    at_feed = np.isin(path.motion, (Motion.LINE, Motion.ARC))
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
