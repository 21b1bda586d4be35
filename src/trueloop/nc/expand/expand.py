"""Contours programmed with less than every point, written out: what a control computes itself, as explicit blocks.

A corner (`,R` `,C`, RND, CHF …) becomes a line or an arc of its own, after a block that ends where it begins; a line by
its angle or about a pole gets its end; an arc by an angle, a point, a pole or the move before its radius or its centre;
a spline becomes the chords that are cut of it; a loop of which every run cuts another move the moves that it makes.
The tool's path stays: the result is run and compared before anybody sees it.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.nc.edit.changes import ANGLES, asks_every_corner, composed, is_made, is_shaped, is_wordless, otherwise
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.expand.block import chords_of_one, makes_spline
from trueloop.nc.expand.loops import loops_written_out
from trueloop.nc.expand.moves import Explicit
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.nc.program.understood import NOT_UNDERSTOOD
from trueloop.units import UM_PER_MM

SLACK_MM = 1e-6
"""Runner and program may differ by this beside rounding."""
ARC_STEPS = 2.0
"""The steps of the control's resolution that the middle of an arc may move: half a step an axis at either end."""


@dataclass(frozen=True)
class WrittenOut:
    """A program with explicit blocks, its path, and the edits of the source that made it."""

    program: Program
    path: ToolPath
    edits: tuple[Edit, ...]

    @contextmanager
    def in_lines_of(self, source: Program) -> Iterator[None]:
        """Refusals from inside that name a line of the written-out program name that of its source."""
        try:
            yield
        except TrueloopError as error:
            if error.place.line is None or not self.edits:
                raise
            place = replace(error.place, line=self.source_line(source, error.place.line), column=None)
            raise error.code.refusal(
                error.message, hint=error.hint, place=place, override=error.override, values=error.values
            ) from error

    def source_line(self, source: Program, line: int) -> int:
        """Returns the line of the source that a line of the written-out program comes from."""
        added = 0
        for edit in sorted(self.edits, key=lambda edit: edit.start):
            new = edit.text.count("\n")
            at = source.place(edit.start).line or 1
            if line <= at + added:
                break
            if line <= at + added + new:
                return at
            added += new
        return line - added


def written_out(
    program: Program, path: ToolPath, moves: Iterable[int], run: Callable[[Program], ToolPath]
) -> WrittenOut:
    """Writes out those of the moves that other words shape, and those that depend on them.

    path: what `run` makes of the program. Raises NC-EDIT where that cannot be done: beside formulas, in a block
    that is optional or runs several times to different places, and where the result would
    not be the same path.
    """
    chosen = set(moves)
    if loops := loops_written_out(program, path, chosen):
        return _then_the_rest(program, path, loops, chosen, run)
    visits = _visits(program, path, chosen)
    if not visits:
        return WrittenOut(program, path, ())
    explicit = Explicit(program, path)
    _require_cut(program, path, visits)
    if any(asks_every_corner(program, path, k) for visit in visits for k in visit):
        chosen |= {k for k in range(len(path)) if asks_every_corner(program, path, k)}
        visits = _visits(program, path, chosen)
        explicit.end_every_corner()
    for visit in visits:
        explicit.write(visit)
    edits = tuple(edit for block in explicit.edits.values() for edit in block)
    written = program.rewritten(apply_edits(program, edits))
    done = WrittenOut(written, run(written), edits)
    require_same_path(program, path, done)
    return done


def _then_the_rest(
    program: Program, path: ToolPath, loops: Sequence[Edit], moves: set[int], run: Callable[[Program], ToolPath]
) -> WrittenOut:
    """The program with its loops written out, and then with what else is shaped by other words."""
    straight = program.rewritten(apply_edits(program, loops))
    done = WrittenOut(straight, run(straight), tuple(loops))
    require_same_path(program, path, done)
    more = written_out(straight, done.path, moves, run)
    return WrittenOut(more.program, more.path, tuple(composed(program.source, loops, more.edits)))


def _require_cut(program: Program, path: ToolPath, visits: list[list[int]]) -> None:
    """Refuses corners and angles that are said to be left out of the path: a control may make something of them."""
    lines = {int(path.line[k]) for visit in visits for k in visit}
    for found in path.findings:
        if (found.code, found.severity) == (Code.NC_OPAQUE, Severity.WARNING) and found.place.line in lines:
            raise found.as_error()


def _visits(program: Program, path: ToolPath, moves: set[int]) -> list[list[int]]:
    """The moves to be written out, those that one run of a block makes together.

    A corner goes with the moves on both sides of it, a line that ends where it meets the next one with that, and any
    move with the next, which may take over its motion code.
    """
    inside = {k for k in moves if 0 <= k < len(path)}
    wanted = {k for k in inside if _is_drawn(program, path, k) and (is_made(path, k) or not is_wordless(path, k))}
    wanted |= {k - 1 for k in inside if k > 0 and _hangs_on_next(program, path, k - 1)}
    found = set[int]()
    while wanted:
        k = wanted.pop()
        found.add(k)
        before = is_made(path, k) or (k > 0 and _hangs_on_next(program, path, k - 1))
        beside = {j for j in (k - 1, k + 1) if 0 <= j < len(path) and (j > k or before)} - found
        shaped = {j for j in beside if _is_drawn(program, path, j)}
        wanted |= shaped
        found |= beside - shaped
    return _by_visit(program, path, sorted(found))


def _is_drawn(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move is given with less than its points; those of cycles are left alone."""
    if makes_spline(program, path, move):
        return True
    return move in path.corners if is_made(path, move) else is_shaped(program, path, move)


def _by_visit(program: Program, path: ToolPath, moves: Iterable[int]) -> list[list[int]]:
    visits: list[list[int]] = []
    for k in moves:
        goes_on = visits and visits[-1][-1] == k - 1 and path.block[k] == path.block[k - 1]
        whole = goes_on and len(visits[-1]) == chords_of_one(program, int(path.block[k]))  # the next run of a loop
        if goes_on and not whole and (is_made(path, k) or makes_spline(program, path, k)):
            visits[-1].append(k)
        else:
            visits.append([k])
    return visits


def _hangs_on_next(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move ends as the next one has it: a corner, or a line of which only the angle is known."""
    named = [int(word) for word in path.word[move] if word >= 0]
    waits = len(named) == 2 and named[0] == named[1] and program.word(named[0]).letter in ANGLES
    return move in path.corners or waits


def require_same_path(program: Program, path: ToolPath, after: WrittenOut) -> None:
    """Refuses a written-out program that is not the same path within rounding."""
    other = after.path
    unknown = [finding for finding in after.program.findings if finding.code in NOT_UNDERSTOOD]
    if len(unknown) > sum(finding.code in NOT_UNDERSTOOD for finding in program.findings):
        raise _otherwise(program, path, 0, unknown[0].message)
    every = np.arange(min(len(path), len(other)))
    for wrong, what in otherwise(path, other, (every, every)):
        if np.any(wrong):
            raise _otherwise(program, path, int(np.argmax(wrong)), f"one of its moves {what}")
    if len(path) != len(other):
        raise _otherwise(program, path, len(every) - 1, "its moves would be others")
    off, allowed = _off_mm(program, path, other)
    if np.any(off > allowed):
        k = int(np.argmax(off - allowed))
        raise _otherwise(program, path, k, f"its path would be off by {off[k] * UM_PER_MM:.2f} µm")


def _off_mm(program: Program, path: ToolPath, other: ToolPath) -> tuple[Array, Array]:
    """How far each move's end, and an arc's middle, is off along an axis, and how much of it rounding explains."""
    step_mm = np.array([program.dialect.step_mm(inch) for inch in (False, True)])[path.inch.astype(int)]
    off, allowed = np.max(np.abs(path.end_mm - other.end_mm), axis=1, initial=0.0), step_mm / 2 + SLACK_MM
    arcs = np.flatnonzero(path.motion == Motion.ARC)
    middle = np.full(len(arcs), 0.5)
    bulge = np.max(np.abs(points_along(path, arcs, middle) - points_along(other, arcs, middle)), axis=1, initial=0.0)
    excess = bulge - ARC_STEPS * step_mm[arcs]
    off[arcs] = np.where(excess > 0.0, np.maximum(off[arcs], bulge), off[arcs])
    return off, allowed


def _otherwise(program: Program, path: ToolPath, move: int, what: str) -> TrueloopError:
    return Code.NC_EDIT.refusal(
        f"line {path.line[move]} belongs to a contour that cannot be written out as explicit moves: {what}",
        hint="write its corners, angles and arcs as blocks with ends, and arcs with a radius or a centre",
        place=program.place(program.block(int(path.block[move])).start),
    )
