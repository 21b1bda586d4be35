"""What is odd about a program: read as text, run, and looked at as geometry. Nothing here refuses the program."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.nc.check.rapid import cutting_rapids
from trueloop.nc.check.written_step import written_step_mm
from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.program.cutter_tool import CutterTool
from trueloop.nc.program.path_mode import path_mode_findings
from trueloop.nc.program.program import BLOCK_LIMIT, Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.units import MM_PER_INCH

_ROUNDING_STEPS = 3.0
"""Rounding of end point and centre by half a step an axis each adds up to 4·√2/2 ≈ 2.8 steps between the radii."""
_ENDLESS_BLOCKS = 10_000
"""Of a program that does not end so many blocks are looked at as geometry, or twice as many as it has."""
SMALLEST_KINK_RAD = math.radians(0.1)
"""A jump of direction below this is taken for tangent."""
LARGEST_KINK_RAD = math.radians(5.0)
"""A jump of direction above this is taken for a corner that was meant."""


def check(
    program: Program,
    parameters: Mapping[str, float] | None = None,
    *,
    skipped_blocks: bool = False,
    tools: Sequence[CutterTool] = (),
    arc_tolerance_mm: float | None = None,
    block_limit: int = BLOCK_LIMIT,
) -> list[Finding]:
    """Every finding, in order of place.

    Text: NC-WORD, NC-CODE, NC-DUPLICATE, NC-NUMBER. Run: NC-DUPLICATE and NC-FEED (two codes of one group, a feed or
    speed below zero), NC-PARAMETER (every parameter without a value), NC-EXPRESSION, NC-FLOW, NC-LIMIT, NC-UNIT,
    NC-DIAMETER, NC-MISPLACED, NC-OPAQUE, NC-ARC; with `tools`, what keeps them from the contour under G41 and G42:
    NC-TOOL, NC-ENTRY, NC-GOUGE. Geometry, of the programmed contour:
    NC-ARC-FIT (an arc whose end is not on the circle about its centre, or whose chord is longer than its diameter, by
    more than `arc_tolerance_mm`; without it, by more than the rounding of the program's own decimals explains),
    NC-TANGENT (a joint of an arc that is neither tangent nor a corner: a jump of direction of 0.1° to 5°, beyond what
    rounding makes of short moves), NC-FEED (a cut without a feed), NC-RAPID (a rapid move through material, on a
    lathe), NC-BLEND (the control may round corners without a bound).

    >>> program = trueloop.read_program(trueloop.example("linuxcnc/finish.ngc"))
    >>> for finding in trueloop.check(program):
    ...     print(finding.severity, finding.code, finding.message)
    note NC-OPAQUE G43: the tool table's length offset is taken as zero
    """
    path = program.run(parameters, skipped_blocks=skipped_blocks, block_limit=block_limit, strict=False)
    driven = program.run(
        parameters, skipped_blocks=skipped_blocks, block_limit=block_limit, tools=tools, strict=False
    ) if tools else path  # fmt: skip
    if any(finding.code is Code.NC_LIMIT for finding in driven.findings):  # endless: every turn is odd alike
        once_round = min(block_limit, max(2 * program.block_count, _ENDLESS_BLOCKS))
        path = program.run(parameters, skipped_blocks=skipped_blocks, block_limit=once_round, strict=False)
    step_mm = written_step_mm(program, path)
    tolerance_mm = _ROUNDING_STEPS * step_mm if arc_tolerance_mm is None else arc_tolerance_mm
    geometry = [
        *_arcs_that_do_not_fit(path, tolerance_mm, Severity.WARNING if arc_tolerance_mm is None else Severity.ERROR),
        *_broken_tangents(path, step_mm),
        *_cuts_without_feed(path),
        *_cuts_on_rapid(program, path),
        *path_mode_findings(program, path),
    ]
    located = (finding.in_file(program.file) for finding in geometry)
    of_run = [found for found in driven.findings if arc_tolerance_mm is None or found.code is not Code.NC_ARC_FIT]
    found = [*program.findings, *of_run, *located]
    once = {(finding.place, finding.code): finding for finding in reversed(found)}  # a loop comes by many times
    return sorted(once.values(), key=lambda finding: (finding.place.line or 0, finding.place.column or 0))


def _finding(path: ToolPath, move: int, severity: Severity, code: Code, message: str, hint: str) -> Finding:
    return Finding(severity, code, message, hint, Place(None, int(path.line[move]), int(path.column[move])))


def _in_plane(path: ToolPath, points: Array, moves: Integers) -> Array:
    """(n, 3) → (k, 2): the coordinates of some moves (k,), in each one's plane."""
    axes = np.array([PLANE_AXES[plane] for plane in range(17, 20)])[path.plane[moves] - 17]
    in_plane: Array = np.take_along_axis(points[moves], axes, axis=1)
    return in_plane


def arc_misfit_mm(path: ToolPath) -> Array:
    """How far the end of each arc lies off its circle, (n,), NaN but for arcs.

    Distance of the end from the centre minus that of the start; with R, half the chord minus R where the chord is too
    long (else the circle fits).
    """
    arcs = np.flatnonzero(path.motion == Motion.ARC)
    centre = _in_plane(path, path.centre_mm, arcs)
    start_radius = np.linalg.norm(_in_plane(path, path.start_mm, arcs) - centre, axis=1)
    end_radius = np.linalg.norm(_in_plane(path, path.end_mm, arcs) - centre, axis=1)
    programmed = path.programmed_radius_mm[arcs]
    too_long = np.maximum(start_radius - programmed, 0.0)
    misfit_mm = np.full(len(path), np.nan)
    misfit_mm[arcs] = np.where(np.isnan(programmed), end_radius - start_radius, too_long)
    return misfit_mm


def _arcs_that_do_not_fit(path: ToolPath, tolerance_mm: float, severity: Severity) -> Iterator[Finding]:
    misfit_mm = arc_misfit_mm(path)
    for move in np.flatnonzero(np.abs(misfit_mm) > tolerance_mm):
        off_mm = float(misfit_mm[move])
        message = f"the arc's end is {off_mm:+.5f} mm ({off_mm / MM_PER_INCH:+.6f} in) off its circle"
        hint = "check the end point and I, J, K or R: one of them was changed without the others"
        yield _finding(path, int(move), severity, Code.NC_ARC_FIT, message, hint)


def _tangents(path: ToolPath, moves: Integers, at_end: bool) -> Array:
    """Unit direction of travel at the start or end of some moves, (k, 2), in their planes; NaN where there is none."""
    start, end, centre = (_in_plane(path, points, moves) for points in (path.start_mm, path.end_mm, path.centre_mm))
    radial = (end if at_end else start) - centre
    turned = np.sign(path.sweep_rad[moves])[:, None] * np.stack([radial[:, 1], -radial[:, 0]], axis=1)
    direction = np.where((path.motion[moves] == Motion.ARC)[:, None], turned, end - start)
    with np.errstate(invalid="ignore"):
        unit: Array = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return unit


def _straightness_mm(path: ToolPath, moves: Integers) -> Array:
    """The length that rounding acts over in a move's direction: of a line its own, of an arc radius or chord."""
    start, end, centre = (_in_plane(path, points, moves) for points in (path.start_mm, path.end_mm, path.centre_mm))
    chord = np.linalg.norm(end - start, axis=1)
    curved = np.fmin(np.linalg.norm(start - centre, axis=1), chord)
    length_mm: Array = np.where(path.motion[moves] == Motion.ARC, curved, chord)
    return length_mm


def _joints_of_arcs(path: ToolPath) -> Integers:
    """Moves at feed that the next one, at feed too, goes on from in the same plane; one of both is an arc."""
    arc, feed = path.motion == Motion.ARC, path.motion != Motion.RAPID
    joints = np.flatnonzero(feed[1:] & feed[:-1] & (arc[1:] | arc[:-1]) & (path.plane[1:] == path.plane[:-1]))
    met: Integers = joints[(path.start_mm[joints + 1] == path.end_mm[joints]).all(axis=1)]
    return met


def _broken_tangents(path: ToolPath, step_mm: float) -> Iterator[Finding]:
    joints = _joints_of_arcs(path)
    before, after = _tangents(path, joints, at_end=True), _tangents(path, joints + 1, at_end=False)
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    jump_rad = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    with np.errstate(divide="ignore"):
        rounding_rad = [_ROUNDING_STEPS * step_mm / _straightness_mm(path, moves) for moves in (joints + 1, joints)]
    explained_rad = np.maximum(SMALLEST_KINK_RAD, rounding_rad[0] + rounding_rad[1])
    broken = (jump_rad > explained_rad) & (jump_rad < LARGEST_KINK_RAD)
    for joint, jump in zip(joints[broken].tolist(), jump_rad[broken].tolist(), strict=True):
        message = f"the direction jumps by {math.degrees(jump):.3f}° where this move joins the one before"
        hint = "if the joint is meant to be tangent, compute end point and centre anew; a corner needs no mending"
        yield _finding(path, joint + 1, Severity.WARNING, Code.NC_TANGENT, message, hint)


def _cuts_without_feed(path: ToolPath) -> Iterator[Finding]:
    cutting: NDArray[Any] = np.isin(path.motion, [Motion.LINE, Motion.ARC, Motion.PROBE])
    without = np.flatnonzero(cutting & ~(path.feed > 0.0))
    if without.size:
        message = f"a cut without a feed: {without.size} of {int(cutting.sum())} cuts have none"
        hint = "write an F word, unless the program that calls this one does; a change between feed a minute and feed "
        yield _finding(path, int(without[0]), Severity.WARNING, Code.NC_FEED, message, hint + "a revolution needs one")


def _cuts_on_rapid(program: Program, path: ToolPath) -> Iterator[Finding]:
    for move, depth_mm in cutting_rapids(path):
        if _homes(program, int(path.block[move])):
            continue
        message = f"a rapid move goes {depth_mm:.3f} mm (on the radius) below what was cut there"
        if depth_mm == 0.0:
            message = f"a rapid move of {np.linalg.norm(path.end_mm[move] - path.start_mm[move]):.3f} mm bridges a cut"
        hint = "write G01 if it is a cut; else retract before it"
        yield _finding(path, move, Severity.WARNING, Code.NC_RAPID, message, hint)


def _homes(program: Program, block: int) -> bool:
    """Whether a block goes to machine coordinates: where these are in the part is seldom known."""
    meanings = (program.core.meaning(word.index) or "" for word in program.block(block).words)
    return any(meaning.startswith(("MachineCoordinates", "Home")) for meaning in meanings)
