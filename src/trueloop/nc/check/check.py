"""Findings about a program: in its text, in its run, and in its geometry. Nothing here refuses the program."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.nc.check.rapid import cutting_rapids, open_run
from trueloop.nc.program.along import PLANE_AXES, PathMode
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.parts import PART, Lines, parts
from trueloop.nc.program.program import BLOCK_LIMIT, Program, Unit
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.units import MM_PER_INCH

_ROUNDING_STEPS: Final = 3.0
"""Rounding of end point and centre by half a step an axis each adds up to 4·√2/2 ≈ 2.8 steps between the radii."""
SMALLEST_KINK_RAD: Final = math.radians(0.1)
"""A jump of direction below this is taken for tangent."""
LARGEST_KINK_RAD: Final = math.radians(5.0)
"""A jump of direction above this is taken for a corner that was meant."""
_COARSEST_MM: Final = 0.001
"""The coarsest step assumed, mm: programs of round numbers do not show their rounding."""
_ENOUGH: Final = 1 << 20
_COORDINATE: Final = re.compile(rb"[XYZ][ \t]*[-+]?\d*\.(\d+)", re.IGNORECASE)
_COLUMNS: Final = (
    *("motion", "start_mm", "end_mm", "centre_mm", "sweep_rad", "programmed_radius_mm"),
    *("block", "column", "word", "state", "call"),
)


@dataclass(frozen=True)
class _Feeds:
    """Cuts, those without a feed, and the first of these."""

    cuts: int = 0
    without: int = 0
    first: Place | None = None

    def and_then(self, path: ToolPath) -> "_Feeds":
        cutting: NDArray[Any] = np.isin(path.motion, [Motion.LINE, Motion.ARC, Motion.PROBE])
        without = np.flatnonzero(cutting & ~(path.feed > 0.0))
        first = _place(path, int(without[0])) if without.size and not self.without else self.first
        return _Feeds(self.cuts + int(cutting.sum()), self.without + without.size, first)

    def findings(self) -> Iterator[Finding]:
        if self.first is not None:
            message = f"a cut without a feed: {self.without} of {self.cuts} cuts have none"
            hint = "write an F word, unless the program that calls this one does; a change between feed a minute and "
            yield Finding(Severity.WARNING, Code.NC_FEED, message, hint + "feed a revolution needs one", self.first)


@dataclass(frozen=True)
class _Rapids:
    """Rapid moves through material; the moves of the last run, which the next ones may go on with, and its lines."""

    found: tuple[Finding, ...] = ()
    path: ToolPath | None = None
    lines: tuple[Lines, ...] = ()

    def and_then(self, path: ToolPath, lines: Lines) -> "_Rapids":
        moves, those = _chained(self.path, path), (*self.lines, lines)
        found = tuple(_cuts_on_rapid(moves, those, goes_on=True))
        kept = _picked(moves, open_run(moves))
        first = int(kept.block.min()) if len(kept) else lines.first + lines.until
        return _Rapids((*self.found, *found), kept, tuple(one for one in those if one.first + one.until > first))

    def findings(self) -> Iterator[Finding]:
        yield from self.found
        if self.path is not None:
            yield from _cuts_on_rapid(self.path, self.lines)


@dataclass(frozen=True)
class Geometry:
    """Findings in the moves so far, and the state by which the next ones are judged.

    `source` is the whole program, which shows in what steps it is written; `step_mm` None before the first move.
    """

    source: bytes
    arc_tolerance_mm: float | None = None
    step_mm: float | None = None
    arcs: tuple[Finding, ...] = ()
    tangents: tuple[Finding, ...] = ()
    last: ToolPath | None = None
    feeds: _Feeds = _Feeds()
    rapids: _Rapids = _Rapids()
    mode: PathMode = field(default_factory=PathMode)

    def and_then(self, path: ToolPath, lines: Lines) -> "Geometry":
        """Returns the state with these moves after its own."""
        mode = self.mode.and_then(path, lines)
        if not len(path):
            return replace(self, mode=mode)
        step_mm = self.step_mm
        if step_mm is None:
            step_mm = _written_step_mm(self.source, lines.program.dialect, path.coordinate_state(0).inch)
        joint = _chained(self.last, _picked(path, np.arange(1)))
        return replace(
            self,
            step_mm=step_mm,
            arcs=(*self.arcs, *_arcs_that_do_not_fit(path, step_mm, self.arc_tolerance_mm)),
            tangents=(*self.tangents, *_broken_tangents(joint, step_mm), *_broken_tangents(path, step_mm)),
            last=_picked(path, np.array([len(path) - 1])),
            feeds=self.feeds.and_then(path),
            rapids=self.rapids.and_then(path, lines),
            mode=mode,
        )

    def findings(self) -> Iterator[Finding]:
        """Yields all findings, after the last moves."""
        for found in (self.arcs, self.tangents, self.feeds.findings(), self.rapids.findings(), self.mode.findings()):
            yield from found


def _place(path: ToolPath, move: int) -> Place:
    return Place(None, int(path.line[move]), int(path.column[move]))


def _finding(
    path: ToolPath, move: int, severity: Severity, code: Code, message: str, hint: str, **values: float
) -> Finding:
    return Finding(severity=severity, code=code, message=message, hint=hint, place=_place(path, move), values=values)


def _in_plane(path: ToolPath, points: Array, moves: Integers) -> Array:
    """(n, 3) → (k, 2): the coordinates of some moves (k,), in each one's plane."""
    axes = np.array([PLANE_AXES[plane] for plane in range(17, 20)])[path.plane[moves] - 17]
    in_plane: Array = np.take_along_axis(points[moves], axes, axis=1)
    return in_plane


def arc_misfit_mm(path: ToolPath) -> Array:
    """Returns the distance of the end of each arc from its circle, (n,), NaN for other moves.

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


def _arcs_that_do_not_fit(path: ToolPath, step_mm: float, tolerance_mm: float | None) -> Iterator[Finding]:
    severity = Severity.WARNING if tolerance_mm is None else Severity.ERROR
    tolerance_mm = _ROUNDING_STEPS * step_mm if tolerance_mm is None else tolerance_mm
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
        yield _finding(path, joint + 1, Severity.WARNING, Code.NC_TANGENT, message, hint, turn_deg=math.degrees(jump))


def _cuts_on_rapid(path: ToolPath, lines: tuple[Lines, ...], *, goes_on: bool = False) -> Iterator[Finding]:
    for move, depth_mm in cutting_rapids(path, goes_on=goes_on):
        if _homes(lines, int(path.block[move])):
            continue
        message = f"a rapid move goes {depth_mm:.3f} mm (on the radius) below what was cut there"
        if depth_mm == 0.0:
            message = f"a rapid move of {np.linalg.norm(path.end_mm[move] - path.start_mm[move]):.3f} mm bridges a cut"
        hint = "write G01 if it is a cut; else retract before it"
        yield _finding(path, move, Severity.WARNING, Code.NC_RAPID, message, hint)


def _homes(lines: tuple[Lines, ...], block: int) -> bool:
    """Returns whether a block goes to machine coordinates: where these are in the part is seldom known."""
    of = next(line for line in lines if block < line.first + line.until)
    words = of.program.block(block - of.first).words
    meanings = (of.program.core.meaning(word.index) or "" for word in words)
    return any(meaning.startswith(("MachineCoordinates", "Home")) for meaning in meanings)


def _written_step_mm(source: bytes, dialect: Dialect, inch: bool) -> float:
    """Returns one unit of the last decimal that the program's coordinates use, in mm; at most `_COARSEST_MM`.

    Never finer than the control's resolution. inch: the unit of the first move. The program's first megabyte is
    searched with its comments: a coordinate in a comment has the program's decimals too.
    """
    decimals = max((len(found) for found in _COORDINATE.findall(source, 0, _ENOUGH)), default=0)
    return min(max(10.0**-decimals, dialect.step(inch)) * (MM_PER_INCH if inch else 1.0), _COARSEST_MM)


def _picked(path: ToolPath, moves: Integers) -> ToolPath:
    """Returns some moves (k,) of a path with their states, copied, without dwells and findings."""
    columns: dict[str, Any] = {name: getattr(path, name)[moves] for name in _COLUMNS}
    used, columns["state"] = np.unique(columns["state"], return_inverse=True)
    return _without_dwells(path, columns, {name: values[used] for name, values in path.states.items()})


def _chained(before: ToolPath | None, path: ToolPath) -> ToolPath:
    """Returns the moves of both, one after the other, without dwells and findings; neither is made in a call."""
    if before is None or not len(before):
        return path
    both: dict[str, Any] = {name: np.concatenate([getattr(before, name), getattr(path, name)]) for name in _COLUMNS}
    both["state"][len(before) :] += len(before.states["tool"])
    states = {name: np.concatenate([values, path.states[name]]) for name, values in before.states.items()}
    return _without_dwells(path, both, states)


def _without_dwells(path: ToolPath, columns: dict[str, Any], states: dict[str, NDArray[Any]]) -> ToolPath:
    return ToolPath(
        **columns, states=states, calls=path.calls, unit_stated=None,
        dwell_before=np.empty(0, dtype=np.int64), dwell_s=np.empty(0),
    )  # fmt: skip


_ENDLESS_BLOCKS = 10_000
"""Of a program that does not end so many blocks are looked at as geometry, or twice as many as it has."""


@dataclass(frozen=True)
class ProgramCheck:
    """The findings of a program, in order of place, and the number of its blocks."""

    findings: list[Finding]
    block_count: int


def check(
    program: Program,
    parameters: Mapping[str, float] | None = None,
    *,
    skipped_blocks: bool = False,
    tools: Sequence[CutterTool] = (),
    arc_tolerance_mm: float | None = None,
    block_limit: int = BLOCK_LIMIT,
) -> list[Finding]:
    """Returns every finding, in order of place.

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
    of_moves = Geometry(program.source, arc_tolerance_mm).and_then(path, Lines(program, program.block_count, 0))
    of_run = [found for found in driven.findings if arc_tolerance_mm is None or found.code is not Code.NC_ARC_FIT]
    return _in_order([*program.findings, *of_run], of_moves, program.file)


def check_in_parts(
    source: bytes,
    dialect: str,
    file: str | None,
    unit: Unit | None,
    parameters: Mapping[str, float],
    *,
    skipped_blocks: bool = False,
    size: int = PART,
) -> ProgramCheck | None:
    """Checks a long program in parts of `size` bytes, without tools; None where it must be run as a whole."""
    of_text: list[Finding] = []
    of_run: list[Finding] = []
    of_moves, count = Geometry(source), 0
    for part in parts(source, dialect, file, unit, parameters, skipped_blocks=skipped_blocks, size=size):
        if part is None:
            return None
        of_text += part.of_text
        of_run += part.path.findings
        of_moves, count = of_moves.and_then(part.path, part.lines), count + part.lines.until
    return ProgramCheck(_in_order([*of_text, *of_run], of_moves, file), count)


def _in_order(findings: Sequence[Finding], of_moves: Geometry, file: str | None) -> list[Finding]:
    located = (finding.in_file(file) for finding in of_moves.findings())
    once = {
        (finding.place, finding.code): finding for finding in reversed([*findings, *located])
    }  # a loop comes by often
    return sorted(once.values(), key=lambda finding: (finding.place.line or 0, finding.place.column or 0))
