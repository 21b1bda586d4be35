"""A finishing program moved point by point onto the corrected surface, without any CAM system.

Ends of moves that cut the surface are displaced; where a straight move between displaced ends would deviate from the
displaced path, blocks are put in before it. Feeds and every other word stay. What does not cut stays where it was.

Places where a corrected program, as it is written, would cut into the corrected surface.

Not only the pass: leads, links and rapid moves stay where they were while the surface may have been raised under them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.domain.option import Limits, allowed_by
from trueloop.domain.record import ChangedWord, check_uncorrected, marks_of_record
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.geometry.surface import Surface, closest, near
from trueloop.nc.edit.changes import changes, insert_heading, not_as_intended, require_own_shape, verify_written
from trueloop.nc.edit.edit import (
    Edit,
    apply_edits,
    coordinate_text,
    displace_word,
    insert_blocks_after,
    insert_word,
    line_texts,
)
from trueloop.nc.program.along import points_along, said_ends
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import INVERSE_TIME, NO_COMPENSATION, Motion, ToolPath
from trueloop.nc.program.understood import (
    require_known_frame,
    require_plain_frame,
    require_seen,
    require_sound,
    require_understood,
)
from trueloop.nc.program.unit import unit_of_path
from trueloop.surface.compensation.cutter import Cutter, ToolAxes, check_tool_axes, contacts, edge_centres_mm, tool_axes
from trueloop.surface.compensation.placed import (
    PLACES,
    looked_at,
    on_surface,
    require_one_zero,
    require_same_shifts,
    shifts_mm,
)
from trueloop.surface.compensation.shift import SAME_MM, MovedFace, Samples, SurfaceJob, places, sampled
from trueloop.surface.on_face import NextFace, Trim
from trueloop.units import UM_PER_MM

WIDE_MM: Final = 0.1
"""Over this length a step counts as a slope: the correction ends at one place, wherever the blocks around it end."""
LEVEL: Final = 1e-3
"""Slope, mm/mm, up to which a step is not reported: 0.1 µm over `WIDE_MM`."""
ALIKE: Final = 0.8
"""Cosine between the normals of two faces from which a cutter runs on from one to the other: not around an edge."""


@dataclass(frozen=True)
class Steps:
    """The other faces of the part, `beside` the corrected one, and the limits of the correction."""

    beside: tuple[NextFace, ...]
    limits: Limits

    def check(
        self, path: ToolPath, samples: Samples, faces: Sequence[MovedFace], job: SurfaceJob
    ) -> tuple[Finding, ...]:
        """Returns a warning of the steps at places where the tool leaves or enters the faces while it cuts one beside
        them, which stays as it is. Raises CMP-SLOPE where the largest is steeper than the limit.
        """
        last, after = _changes(path, samples)
        moved_mm = np.linalg.norm(samples.after_mm[last] - samples.before_mm[last], axis=1)
        slope = moved_mm / WIDE_MM
        some = np.flatnonzero(slope > LEVEL)
        if not len(some) or not self.beside:
            return ()
        move, share = samples.move[last[some]], samples.share[last[some]]
        foot, normal, away_mm = np.empty((len(some), 3)), np.empty((len(some), 3)), np.empty(len(some))
        directions = samples.axes.directions(move, share)
        for k, face in enumerate(faces):
            of = np.flatnonzero(samples.face[last[some]] == k)
            touch = contacts(face.nominal, job.cutter, samples.before_mm[last[some[of]]], directions[of])
            foot[of], normal[of], away_mm[of] = touch.feet.point_mm, touch.feet.normal, touch.gap_mm
        centre = foot + (away_mm + job.cutter.corner_mm)[:, None] * normal
        centre = centre + samples.before_mm[after[some]] - samples.before_mm[last[some]]
        onto = np.zeros(len(some), int)
        for other in self.beside:
            onto[(onto == 0) & _cuts(other, centre, normal, job)] = other.number
        if not np.any(onto):
            return ()
        worst = int(np.argmax(np.where(onto > 0, slope[some], 0.0)))
        x, y, z = foot[worst]
        um, reached, limit = (
            value * UM_PER_MM for value in (moved_mm[some[worst]], slope[some[worst]], self.limits.slope)
        )
        step = Finding(
            Severity.WARNING,
            Code.CMP_SLOPE,
            f"the correction ends with a step of up to {um:.1f} µm, at x {x:.3f}, y {y:.3f}, z {z:.3f} mm, where the "
            f"program cuts on from or into face {onto[worst]}, which stays as it is: {reached:.1f} µm/mm over "
            f"{WIDE_MM:g} mm, at {np.count_nonzero(onto)} places; the limit is {limit:.1f} µm/mm",
            hint=f"name face {onto[worst]} in surface.face too: one job corrects all faces that a program cuts; "
            "compensation.weight makes the step smaller",
            values=dict(zip(Code.CMP_SLOPE.values, (reached, limit), strict=True)),
        )
        if slope[some[worst]] > self.limits.slope:
            raise Code.CMP_SLOPE.refusal(step.message, hint=step.hint, override=allowed_by("slope"), values=step.values)
        return (step,)


def _changes(path: ToolPath, samples: Samples) -> tuple[Integers, Integers]:
    """Returns pairs of neighbouring places along the path of which one cuts and one does not: the cutting one first."""
    same = np.diff(samples.move) == 0
    joined = np.linalg.norm(np.diff(samples.before_mm, axis=0), axis=1) <= SAME_MM
    joined &= np.diff(samples.move) == 1
    first = np.flatnonzero((same | joined) & (samples.cutting[:-1] != samples.cutting[1:]))
    begins = samples.cutting[first + 1]
    return np.where(begins, first + 1, first), np.where(begins, first, first + 1)


def _cuts(face: NextFace, centre_mm: Array, normal: Array, job: SurfaceJob) -> np.ndarray:
    """Returns at which centres (n, 3) of the cutter's corner a face is cut that runs on from one with `normal` (n, 3).

    Which side of it the file takes for the outer one does not matter: models come with normals that point inwards.
    """
    found = np.zeros(len(centre_mm), bool)
    try:
        surface = face.surface
    except TrueloopError:  # the kernel makes no surface of it: a face beside must not be in the way
        return found
    some = near(surface, centre_mm, job.cutter.corner_mm + job.cuts_mm)
    if not len(some):
        return found
    feet = closest(surface, centre_mm[some])
    alike = np.einsum("nk,nk->n", feet.normal, normal[some])
    away_mm = np.sign(alike) * feet.distance_mm - job.cutter.corner_mm
    here = (np.abs(away_mm) <= job.cuts_mm) & (feet.beyond_mm <= SAME_MM) & (np.abs(alike) >= ALIKE)
    here[here] = ~face.trimmed_away(feet.u[here], feet.v[here]).astype(np.bool_)
    found[some[here]] = True
    return found


AROUND: Final = 12
"""Places around a cutter's edge that are searched for gouges."""


def check_gouges(
    program: Program, path: ToolPath, axes: ToolAxes, passes: tuple[Flags, Flags], face: MovedFace, job: SurfaceJob
) -> None:
    """Refuses moves, at feed or rapid, that take the cutter into the corrected surface by more than `job.gouge_mm`.

    Looked at are the moves of the pass, the first of `passes` (n,), of which the second cut this face, and all others
    of its tool and work offset that begin and end where the program says, without G41 or G42. Chords within
    `job.tolerance_mm` of what they stand for are allowed that much more. A place beside the pass that lay deeper than
    `job.cuts_mm` in the nominal surface already is left alone: it is on the other side of a wall, or as deep as its
    programmer meant. Raises SRF-GOUGE.
    """
    cutting, of_face = passes
    before, after = said_ends(program, path)
    like = np.isin(path.tool, path.tool[cutting]) & np.isin(path.work_offset, path.work_offset[cutting])
    beside = np.all(before & after, axis=1) & like & (path.compensation == NO_COMPENSATION) & ~axes.unsaid
    move, share = places(path, axes, np.flatnonzero(cutting | beside), job.sample_mm)
    tips, directions = points_along(path, move, share), axes.directions(move, share)
    depth_mm, points = depths_mm(face.corrected, job.cutter, tips, directions)
    deep = np.flatnonzero(depth_mm > job.gouge_mm + job.tolerance_mm)
    own_mm, feet_mm = depths_mm(face.nominal, job.cutter, tips[deep], directions[deep])
    real = of_face[move[deep]] | (own_mm <= job.cuts_mm)
    if face.trim is not None and len(deep):
        at = closest(face.nominal, feet_mm)
        real &= ~face.trim(at.u, at.v).astype(np.bool_)
    deep = deep[real]
    if len(deep):
        worst = deep[np.argmax(depth_mm[deep])]
        x, y, z = points[worst]
        what = "a rapid move" if path.rapid[move[worst]] else "the cutter"
        raise Code.SRF_GOUGE.refusal(
            f"{what} would cut {depth_mm[worst] * UM_PER_MM:.1f} µm into the corrected surface at x {x:.3f}, "
            f"y {y:.3f}, z {z:.3f} mm; {job.gouge_mm * UM_PER_MM:.1f} µm is allowed, exceeded at {len(deep)} places",
            hint="the cutter is too large for a hollow there, a lead or link runs too near to the surface, or the "
            "program belongs to another surface or tool",
            values={
                "depth_um": float(depth_mm[worst]) * UM_PER_MM,
                "limit_um": job.gouge_mm * UM_PER_MM,
                "x_mm": float(x),
                "y_mm": float(y),
                "z_mm": float(z),
            },
        )


def depths_mm(surface: Surface, cutter: Cutter, tips_mm: Array, axes: Array) -> tuple[Array, Array]:
    """How deep a cutter at (n, 3) is in the surface at the most, (n,), −∞ beside the patch; and where, (n, 3).

    The nearest point of the surface is looked for afresh for each, wherever on the patch it is: a ball in a hollow
    narrower than itself is nearest to a rim it was not meant to touch. So it is for places all around the edge of a
    bull-nose or flat cutter, which in a hollow cuts where it does not lean.
    """
    if not len(tips_mm):
        return np.empty(0), np.empty((0, 3))
    found = contacts(surface, cutter, tips_mm, axes)
    feet, gap = [found.feet], [found.gap_mm]
    for centres in edge_centres_mm(cutter, tips_mm, axes, AROUND):
        feet.append(closest(surface, centres))
        gap.append(feet[-1].distance_mm - cutter.corner_mm)
    deep = np.where(np.stack([some.beyond_mm for some in feet]) <= SAME_MM, -np.stack(gap), -np.inf)
    most = np.argmax(deep, axis=0), np.arange(len(tips_mm))
    return deep[most], np.stack([some.point_mm for some in feet])[most]


def held_starts(path: ToolPath, ends: Mapping[int, Array]) -> Array:
    """Where each move starts in the written program, (n, 3): coordinates that no word sets stay displaced, and so do
    those that an increment moves.
    """
    held = np.array(path.start_mm)
    for move in range(1, len(path)):
        last = ends.get(move - 1)
        if last is None:
            last = _held_end(path, move - 1, held)
        held[move] = last + (path.start_mm[move] - path.end_mm[move - 1])
    return held


def _held_end(path: ToolPath, move: int, held: Array) -> Array:
    """Returns where a move that is left alone ends, (3,), when it starts at `held`, (n, 3) for all moves."""
    stays = (path.word[move] < 0) | path.incremental[move]
    end: Array = np.where(stays, held[move] + (path.end_mm[move] - path.start_mm[move]), path.end_mm[move])
    return end


def require_arcs_stay(program: Program, path: ToolPath, ends: Mapping[int, Array]) -> None:
    """Raises SRF-PROGRAM for an arc that starts where a cut left a coordinate displaced: its centre would not fit."""
    off = np.abs(held_starts(path, ends) - path.start_mm).max(axis=1, initial=0.0)
    step_mm = np.where(path.inch, program.dialect.step_mm(True), program.dialect.step_mm(False))
    moved = np.flatnonzero((path.motion == Motion.ARC) & (off > step_mm / 2))
    if len(moved):
        raise Code.SRF_PROGRAM.refusal(
            f"this arc starts {off[moved[0]] * UM_PER_MM:.2f} µm from where it did: its centre would not fit",
            hint="name all axes in the move before it, or lead out by a line",
            place=program.place(program.block(int(path.block[moved[0]])).start),
        )


Waypoint: TypeAlias = tuple[float, Array]
"""Share of a move, and where the tip is to be there."""

AXES: Final = ((0, "X"), (1, "Y"), (2, "Z"))
SWITCHES: Final = frozenset("MST")
ROUNDING_STEPS: Final = 2.0
"""How many steps of the control's resolution rounding may move a point."""


@dataclass(frozen=True, eq=False)
class CorrectedProgram:
    """The corrected source, and in figures: moves that cut, blocks put in, the largest displacement of an end;
    `changes` are for people to read; `unit` as `trueloop.nc.program.unit` has it; `findings` are of the steps towards
    other faces of the part.
    """

    source: bytes
    cutting_moves: int
    new_blocks: int
    largest_mm: float
    changes: list[ChangedWord]
    unit: dict[str, str]
    findings: tuple[Finding, ...] = ()


def corrected_program(
    program: Program,
    nominal: Surface,
    corrected: Surface,
    job: SurfaceJob,
    record_id: str,
    *,
    steps: Steps | None = None,
    trim: Trim | None = None,
    further: Sequence[MovedFace] = (),
    number: int | None = None,
) -> CorrectedProgram:
    """The program for the corrected surface, read back and compared before it is returned; with `further` faces that it
    cuts too, which end, as this one, where they are trimmed. `number`: this face's, where there are several.

    Positions on the surface are those of the program, its own shifts and the job's zero added; the programmed point is
    the tool's tip, however the tool is turned. Raises SRF-PROGRAM for a zero that is not known, a program that cuts
    nothing of the surface, cuts it in arcs, under cutter compensation or in increments,
    CMP-TWICE for one corrected before, CMP-SLOPE for steep `steps` to faces beside, SRF-GOUGE, and CMP-READ-BACK.
    """
    check_uncorrected(program.source)
    if not job.accept_unknown_words:
        require_understood(program, "program.accept_unknown_words")
    path = program.run(job.parameters)
    require_sound(path)
    require_known_frame(path)
    placed, faces = on_surface(path, job), (MovedFace(nominal, corrected, trim, number), *further)
    by_tool = [_of_tool(program, path, placed, faces, of_tool) for of_tool in job.by_tool]
    samples = by_tool[0].joined(by_tool[1:])
    _require_tools_stated(program, path, placed, samples.cutting_moves, (faces, job))
    _check(program, path, samples, job)
    _require_all_cut(program, samples, faces)
    findings = list[Finding]()
    for of_tool, own in zip(job.by_tool, by_tool, strict=True):
        findings += () if steps is None else steps.check(placed, own, faces, of_tool)
    ends, between = _targets(shifts_mm(path, job), samples, job.tolerance_mm)
    touched = {move + step for move in ends for step in (0, 1)} | between.keys()
    require_plain_frame(path, sorted(ends))
    require_seen(program, path, sorted(ends), "XYZ")
    require_own_shape(program, path, sorted(touched & set(range(len(path)))))
    require_arcs_stay(program, path, ends)
    edits = [*_mark(program, record_id), *_edits(program, path, samples.axes, ends, between)]
    source = apply_edits(program, edits)
    written = program.rewritten(source)
    again = written.run(job.parameters)
    axes = [tool_axes(written, again, of_tool.rotary, of_tool.axis) for of_tool in job.by_tool]
    inserted = _inserted(path, between)
    at = np.arange(len(path)) + np.cumsum(inserted)  # what the source's moves have become
    _read_back(program, path, again, ends, between, at)
    if samples.axes.letters and not np.array_equal(axes[0].end[at], samples.axes.end):
        raise not_as_intended("the written program is not what was intended: the tool's direction changed")
    require_same_shifts(path, again.register_mm[at])
    for of_tool, own, turning in zip(job.by_tool, by_tool, axes, strict=True):
        of_pass, *of_faces = (
            np.repeat(np.isin(np.arange(len(path)), moves), 1 + inserted)
            for moves in (own.cutting_moves, *(own.moves_on(k) for k in range(len(faces))))
        )
        for face, of_face in zip(faces, of_faces, strict=True):
            check_gouges(written, on_surface(again, job), turning, (of_pass, of_face), face, of_tool)
    moved = [float(np.linalg.norm(end - path.end_mm[k])) for k, end in ends.items()]
    new_blocks, largest_mm = sum(map(len, between.values())), max(moved, default=0.0)
    return CorrectedProgram(
        source,
        cutting_moves=len(samples.cutting_moves),
        new_blocks=new_blocks,
        largest_mm=largest_mm,
        changes=changes(program, edits[1:]),
        unit=unit_of_path(program.unit, path),
        findings=tuple(findings),
    )


def _of_tool(
    program: Program, path: ToolPath, placed: ToolPath, faces: Sequence[MovedFace], job: SurfaceJob
) -> Samples:
    if job.tool is not None and not np.any(path.tool == job.tool):
        raise Code.SRF_PROGRAM.refusal(
            f"the program has 0 moves of tool T{job.tool}; its tools: {_names(np.unique(path.tool[path.tool >= 0]))}",
            hint="cutter.tool in the job is the number of the T word with which the finishing tool is called",
            place=Place(program.file),
        )
    require_one_zero(program, path, job)
    axes = tool_axes(program, path, job.rotary, job.axis)
    return sampled(placed, np.flatnonzero(looked_at(path, job)), axes, faces, job)


def _names(tools: Integers) -> str:
    return ", ".join(f"T{tool}" for tool in tools.tolist()) or "not called"


def _require_tools_stated(
    program: Program, path: ToolPath, placed: ToolPath, cutting: Integers, of: tuple[Sequence[MovedFace], SurfaceJob]
) -> None:
    """Raises SRF-PROGRAM where the job states no tool and another than the one whose moves are `cutting` comes near the
    faces: with the cutter stated for the first, its own cuts would seem to pass by.
    """
    faces, job = of
    if job.tool is not None or not len(cutting):
        return
    first = path.tool[cutting[0]]
    moves = np.flatnonzero(looked_at(path, job) & (path.tool != first))
    moves = moves[:: max(1, len(moves) // PLACES)]
    close = np.zeros(len(moves), dtype=np.bool_)
    for face in faces:
        some = near(face.nominal, placed.end_mm[moves], job.cutter.radius_mm)
        if len(some):
            feet = closest(face.nominal, placed.end_mm[moves[some]])
            close[some] |= (np.abs(feet.distance_mm) <= job.cutter.radius_mm) & (feet.beyond_mm <= SAME_MM)
    others = np.union1d(moves[close], cutting[path.tool[cutting] != first])
    if len(others):
        tools = np.unique(np.append(path.tool[others], first))
        raise Code.SRF_PROGRAM.refusal(
            f"{len(tools)} tools cut the surface or come within {job.cutter.radius_mm:g} mm of it, {_names(tools)}, "
            "and the job states one cutter",
            hint="state each that finishes it with its number: [[cutter]] with tool = 1, and so on; moves of other "
            "tools stay",
            place=program.place(program.block(int(path.block[others[0]])).start),
        )


def _require_all_cut(program: Program, samples: Samples, faces: Sequence[MovedFace]) -> None:
    """Raises SRF-PROGRAM for a face that the job names and no move cuts: it would stay as it is."""
    uncut = [str(face.number) for k, face in enumerate(faces) if not len(samples.moves_on(k))]
    if uncut:
        raise Code.SRF_PROGRAM.refusal(
            f"0 moves of the program cut face {' and face '.join(uncut)}, of {len(faces)} that the job names",
            hint="name in surface.face the faces that the program cuts; where it cuts this one too, look at "
            "program.zero_mm and the radius of each [[cutter]]",
            place=Place(program.file),
        )


def _check(program: Program, path: ToolPath, samples: Samples, job: SurfaceJob) -> None:
    cutting = samples.cutting_moves
    if not len(cutting):
        hint = "look at program.zero_mm, tool radius and face, and whether the program leaves an allowance on"
        raise Code.SRF_PROGRAM.refusal("0 moves of the program come near the surface", hint=hint)
    compensated = path.compensation[cutting] != NO_COMPENSATION
    arcs, lines = path.motion[cutting] == Motion.ARC, "have the finish pass, and the way in and out, written as lines"
    wrong = [
        (arcs, "arcs begin, end or run on the surface", lines),
        (compensated, "moves cut it under G41 or G42", "write the path of the tool's tip"),
        (path.feed_mode[cutting] == INVERSE_TIME, "moves cut it with inverse-time feed", "write the pass with G94"),
        (path.incremental[cutting], "moves cut it by increments", "write the pass in absolute coordinates"),
    ]
    for here, what, hint in wrong:
        if np.any(here):
            place = program.place(program.block(int(path.block[cutting[here][0]])).start)
            raise Code.SRF_PROGRAM.refusal(f"{np.count_nonzero(here)} {what}", hint=hint, place=place)
    check_tool_axes(program, path, samples.axes, cutting)


def _targets(
    shift_mm: Array, samples: Samples, tolerance_mm: float
) -> tuple[dict[int, Array], dict[int, list[Waypoint]]]:
    """Displaced ends by move, and further points within moves, with the share of the move they stand at, as the program
    calls them: less the shift of the move (n, 3).
    """
    ends: dict[int, Array] = {}
    between: dict[int, list[Waypoint]] = {}
    starts = np.flatnonzero(np.diff(samples.move, prepend=-1))
    for first, after in zip(starts, np.append(starts[1:], len(samples.move)), strict=True):
        move = int(samples.move[first])
        if samples.cutting[after - 1]:
            ends[move] = samples.after_mm[after - 1] - shift_mm[move]
        if np.any(samples.cutting[first:after]):
            points = samples.after_mm[first:after] - shift_mm[move]
            if kept := _needed(points, samples.cutting[first:after], tolerance_mm):
                between[move] = [(float(samples.share[first + k]), points[k]) for k in kept]
    return ends, between


def _needed(points: Array, cutting: np.ndarray, tolerance_mm: float) -> list[int]:
    """Fewest points, first and last aside, whose chords keep to all that cut (Douglas and Peucker)."""
    kept: list[int] = []
    ranges = [(0, len(points) - 1)]
    while ranges:
        first, last = ranges.pop()
        if last - first < 2:
            continue
        chord = points[last] - points[first]
        off = points[first + 1 : last] - points[first]
        along = np.clip(off @ chord / max(float(chord @ chord), 1e-300), 0.0, 1.0)
        distance = np.where(cutting[first + 1 : last], np.linalg.norm(off - along[:, None] * chord, axis=1), 0.0)
        worst = int(np.argmax(distance))
        if distance[worst] > tolerance_mm:
            middle = first + 1 + worst
            kept.append(middle)
            ranges += [(first, middle), (middle, last)]
    return sorted(kept)


def _edits(
    program: Program, path: ToolPath, axes: ToolAxes, ends: dict[int, Array], between: dict[int, list[Waypoint]]
) -> Iterator[Edit]:
    held = held_starts(path, ends)
    for move in range(len(path)):
        if move in between:
            yield _new_blocks(program, path, axes, move, between[move])
        if move in ends:
            before = between[move][-1][1] if move in between else held[move]
            yield from _moved_end(program, path, move, ends[move], before)


def _moved_end(program: Program, path: ToolPath, move: int, wanted: Array, held: Array) -> Iterator[Edit]:
    state = path.coordinate_state(move)
    for axis, letter in AXES:
        word = int(path.word[move, axis])
        if word >= 0:
            delta = float(wanted[axis] - path.end_mm[move, axis])
            if (edit := displace_word(program, program.word(word), delta, state)) is not None:
                yield edit
        else:
            texts = [coordinate_text(program.dialect, letter, float(at[axis]), state) for at in (wanted, held)]
            if texts[0] != texts[1]:
                yield insert_word(program, int(path.block[move]), letter, float(wanted[axis]), state)


def _new_blocks(program: Program, path: ToolPath, axes: ToolAxes, move: int, points: list[Waypoint]) -> Edit:
    """Blocks before the move's own, the tool turning on the way: that one keeps its end, its feed and all else."""
    index = int(path.block[move])
    block, state = program.block(index), path.coordinate_state(move)
    if index == 0 or any(word.letter in SWITCHES for word in block.words):
        raise Code.SRF_PROGRAM.refusal(
            f"{len(points)} blocks have to come before this one, which also switches or is the first",
            hint="write M, S and T words in a block of their own",
            place=program.place(block.start),
        )
    feed = [word.text for word in block.words if word.letter == "F"]
    places = [[coordinate_text(program.dialect, name, float(at[k]), state) for k, name in AXES] for _, at in points]
    texts = [" ".join(place) + axes.text(move, share) for place, (share, _) in zip(places, points, strict=True)]
    texts = line_texts(program.dialect, texts)
    texts[0] = " ".join([texts[0], *feed])
    return insert_blocks_after(program, index - 1, texts)


def _mark(program: Program, record_id: str) -> Iterator[Edit]:
    lines = marks_of_record(record_id, program.source)
    yield insert_heading(program, [program.dialect.comment(line) for line in lines])


def _inserted(path: ToolPath, between: dict[int, list[Waypoint]]) -> Integers:
    """How many moves are put in before each of the source's."""
    return np.array([len(between.get(move, ())) for move in range(len(path))], dtype=np.intp)


def _read_back(
    program: Program,
    path: ToolPath,
    again: ToolPath,
    ends: dict[int, Array],
    between: dict[int, list[Waypoint]],
    at: Integers,
) -> None:
    """The written program run again: every move must end where it was to end, at the feed it had."""
    new = sum(map(len, between.values()))
    allowed = ROUNDING_STEPS * program.dialect.step_mm(bool(np.any(path.inch)))
    if len(again) != len(path) + new:
        raise not_as_intended(f"the written program has {len(again)} moves instead of {len(path) + new}")
    for move, points in between.items():
        found = again.end_mm[at[move] - len(points) : at[move]]
        if (off := float(np.max(np.abs(found - [at for _, at in points])))) > allowed:
            raise not_as_intended(f"a new point of the written program is {off * UM_PER_MM:.2f} µm off")
    held = held_starts(path, ends)
    left_alone = (_held_end(path, move, held) for move in range(len(path)))
    wanted = np.array([ends.get(move, end) for move, end in enumerate(left_alone)]).reshape(-1, 3)
    checked = (path.word >= 0) | np.isin(np.arange(len(path)), list(ends))[:, None]
    verify_written(path, again, (np.arange(len(path)), at), wanted, checked, allowed_mm=allowed)
