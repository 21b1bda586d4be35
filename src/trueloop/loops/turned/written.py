"""The corrected program, written, read back and compared with what was intended."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.domain.record import ChangedWord, marks_of_record
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.commanded import Commanded, Run
from trueloop.loops.turned.paths import (
    Paths,
    require_roughing_stays,
    roughing_stays_notes,
    shared_contour_notes,
    then_written_out,
    with_own_contour,
)
from trueloop.nc.edit.changes import changes, composed, insert_heading
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.expand.expand import WrittenOut
from trueloop.nc.match.cutters import of_centre
from trueloop.nc.program.called import called
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.compensation.displaced import CentrePiece
from trueloop.turned.compensation.moves import between
from trueloop.turned.compensation.targets import (
    EndShift,
    Fitting,
    Replacement,
    bent_lines,
    end_shifts,
    ends_of,
    replaced_arcs,
    with_edges,
)
from trueloop.turned.program.contour_cycles import finishing_cycle
from trueloop.turned.program.rapids import with_rapids
from trueloop.turned.program.read_back import (
    SourceContour,
    again,
    aligned,
    check_contour,
    check_rapids,
    check_rest,
    check_way,
    farthest_mm,
    joins_mm,
    move_of,
    require_nose_fits,
    unfit,
)
from trueloop.turned.program.write import Displacements, corrected_source, displacements, led_in
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import wording

FOR_CHORDS = 0.5
"""Share of the chord tolerance for the moves themselves, where the control keeps the nose off them: its joins where a
contour turns by some milliradians take the rest (0.1 to 0.2 µm at 15 mrad and a nose of 0.8 mm)."""

ABOUT_MM = 1e-3
"""An arc turns the nose about an edge where its centre is so near to the edge."""

SHARES = (1.0, 0.5, 0.2)
"""Shares of it, tried in turn where moves are seen to leave the path between the places by which they were chosen."""

REACH = 4.0
"""Corrections move the place where a control shortens a way in by some times their size."""

ROUNDING_STEPS = 2.0
"""How many steps of the control's resolution rounding may add: half a step on either axis, at both ends of a move."""


NEARLY_TANGENT = 0.1
"""Two normals count as parallel below this ratio of their singular values, about half the angle between them in rad."""


@dataclass(frozen=True)
class Writing:
    """The source to write into, as run and matched, and its marks; `chords`: the share of their tolerance for moves."""

    program: Program
    matched: Commanded
    run: Run
    record_id: str
    fitting: Fitting
    composed: str = ""
    roughing_stays: bool = False
    chords: float = 1.0

    @property
    def mark(self) -> Edit:
        """Returns the comment block by which a corrected program is known."""
        values = " ".join(f"{name}={value!r}" for name, value in self.run.parameters.items())
        lines = marks_of_record(self.record_id, self.program.source)
        if self.composed:
            lines.append(self.composed)
        if values:
            lines.append(f"holds for {values} only")
        return insert_heading(self.program, [self.program.dialect.comment(line) for line in lines])

    def with_edits(self, edits: Sequence[Edit]) -> bytes:
        """Returns the source with edits and mark."""
        return apply_edits(self.program, [self.mark, *edits])

    def reread(self, source: bytes) -> Program:
        """Reads a written program again, as a control would."""
        return self.program.rewritten(source)


def write_contour(
    writing: Writing, profile: Profile, touches: ErrorVectors, paths: Paths
) -> tuple[bytes, list[ChangedWord], list[str]]:
    """Returns the program with its contour displaced, the changes, and notes on it; by finer moves if it has to be.

    Raises CMP errors if reading it back says so; where the control compensates for the nose, also if compensating it as
    the control does says so.
    """
    *first, last = SHARES
    for share in first:
        try:
            return _contour_written(replace(writing, chords=share), profile, touches, paths)
        except TrueloopError as refused:
            if refused.code is not Code.CMP_READ_BACK:
                raise
    return _contour_written(replace(writing, chords=last), profile, touches, paths)


def _contour_written(
    writing: Writing, profile: Profile, touches: ErrorVectors, paths: Paths
) -> tuple[bytes, list[ChangedWord], list[str]]:
    matched, (before, after) = writing.matched, paths.written
    own = WrittenOut(writing.program, matched.path, ())
    if writing.roughing_stays:
        own = with_own_contour(writing.program, matched.path, matched.cuts[0].move, writing.run)
    targets = _targets(writing, own, profile, touches, before, after)
    targets = _of_own_moves(writing, targets)
    moves = range(targets.first, targets.last + 2)
    explicit = then_written_out(writing.program, own, moves, writing.run)
    targets = targets.off(matched.path.end_mm - explicit.path.end_mm)
    with explicit.in_lines_of(writing.program):
        source_edits = corrected_source(explicit.program, explicit.path, targets)
        edits = composed(writing.program.source, explicit.edits, source_edits)
    source = writing.with_edits(edits)
    program = writing.reread(source)
    path = writing.run.of(program)
    # The moves whose blocks may have become several: arcs, and the rapid that leads to the contour
    rapids = (move for move in targets.ends if explicit.path.motion[move] == Motion.RAPID)
    images = aligned(explicit.program, explicit.path, path, source_edits, [*rapids, *targets.arcs])
    read = _ReadBack(program, path, explicit.path, targets, images)
    corners = _require_intended(writing, profile, read, paths)
    if writing.roughing_stays:
        require_roughing_stays(writing.run, (writing.program, program), paths.written, matched.resolution_mm)
    return source, changes(writing.program, edits), [*_corner_notes(corners), *_notes(writing, read)]


def _of_own_moves(writing: Writing, targets: Displacements) -> Displacements:
    """Drops the moves that other edges make between this edge's cuts. Raises NC-EDIT where one leads to its first."""
    edge, path = writing.run.called, writing.matched.path
    if edge is None:
        return targets
    own = {move for move in targets.ends if called(writing.program.dialect, path, move) == edge}
    if targets.first not in own:
        raise Code.NC_EDIT.refusal(
            f"line {path.line[targets.first + 1]} begins to cut with {edge.words} where the tool before it stopped",
            hint=f"approach the contour by a move of its own after {edge.words} is called",
            place=Place(line=int(path.line[targets.first + 1])),
        )
    return Displacements({move: end for move, end in targets.ends.items() if move in own}, targets.arcs)


@dataclass(frozen=True)
class _ReadBack:
    """A written program, run again, beside the path it was written from and what was intended with that."""

    program: Program
    path: ToolPath
    old: ToolPath
    targets: Displacements
    images: tuple[range, ...]

    @property
    def span(self) -> tuple[int, int]:
        """Returns first and last move of the contour as written, without the one that leads to it."""
        return self.images[self.targets.first].start + 1, self.images[self.targets.last].stop - 1


def _require_intended(writing: Writing, profile: Profile, read: _ReadBack, paths: Paths) -> tuple[int, ...]:
    """The contour is where it shall be, all else is where it was. Lines of the source's own corners that the nose does
    not fit into: with such the contour is compared as programmed alone.
    """
    old, path, targets, span = read.old, read.path, read.targets, read.span
    (before, after), driven = (paths.written[0], _as_far_as_cut(writing.matched, paths.written[1])), paths.driven
    moves = range(targets.first, targets.last + 1)
    check_rest(old, path, read.images, moves, again(old, moves))
    matched = writing.matched
    tolerance_mm = writing.fitting.tolerance_mm + matched.unevenness_mm + ROUNDING_STEPS * matched.resolution_mm
    largest_mm = max(farthest_mm(before, after), *(float(np.linalg.norm(end)) for end in targets.ends.values()))
    reach_mm, cuts = REACH * largest_mm, (matched.cuts[0].move, matched.cuts[-1].move)
    # The program may break an edge that is not drawn
    check_contour(path, span, after, tolerance_mm, SourceContour(old, cuts, _by_name(before), reach_mm))
    cycle = finishing_cycle(writing.program, writing.matched.path, targets.last)
    follows_mm = largest_mm if cycle is not None and cycle.by == "name" else 0.0
    centres = of_centre(old, matched.tip_mm), of_centre(path, matched.tip_mm)
    check_rapids(profile, *centres, read.images, moves, follows_mm)
    check_way(old, path, moves, range(span[0] - 1, span[1] + 1), largest_mm + tolerance_mm)
    if driven is None:
        return ()
    compensated = writing.run.driven(read.program, driven.nose_radius_mm)
    source = writing.run.driven(writing.program, driven.nose_radius_mm)
    given = unfit(source, matched.path)
    own = require_nose_fits(unfit(compensated, path), path.line[[*span]], given, largest_mm + tolerance_mm)
    if not own:
        blocks = matched.path.block[[*cuts]]
        as_given = SourceContour(source, _of_blocks(source, blocks), _by_name(paths.commanded), reach_mm)
        along, where = driven.along(after, largest_mm), _of_blocks(compensated, path.block[[*span]])
        joined_mm = tolerance_mm + joins_mm(path, span, driven.nose_radius_mm)
        check_contour(compensated, where, along, joined_mm, as_given)
    return own


def _by_name(pieces: Sequence[CentrePiece]) -> dict[str, CentrePiece]:
    return {piece.shifted.feature.name: piece for piece in pieces}


def _as_far_as_cut(matched: Commanded, pieces: Sequence[CentrePiece]) -> list[CentrePiece]:
    """Returns the pieces without the parts of the profile's free ends that the given program does not cut."""
    first, last = matched.match.features[0].moves, matched.match.features[-1].moves
    begins_mm = max(0.0, min(min(move.start_mm, move.end_mm) for move in first))
    ends_mm = max(max(move.start_mm, move.end_mm) for move in last)
    cut = list(pieces)
    cut[0] = replace(cut[0], start_mm=max(cut[0].start_mm, begins_mm))
    short_mm = max(0.0, cut[-1].shifted.feature.length_mm - ends_mm)
    cut[-1] = replace(cut[-1], end_mm=cut[-1].end_mm - short_mm)
    return cut


def _corner_notes(lines: Sequence[int]) -> list[str]:
    if not lines:
        return []
    return [
        wording(
            "The nose does not fit into the corners before the moves of lines {lines}, in the given program as in the "
            "corrected one: how the control cuts them is its own, and was not checked.",
            lines=", ".join(map(str, sorted(set(lines)))),
        )
    ]


def _notes(writing: Writing, read: _ReadBack) -> list[str]:
    """Returns notes where a roughing cycle runs on the contour too, and where formulas became numbers."""
    if writing.roughing_stays:
        return roughing_stays_notes(writing.program, writing.matched.path, read.targets.last)
    first, last, span = read.targets.first, read.targets.last, read.span
    x_before, x_after = read.old.end_mm[first : last + 1, 0], read.path.end_mm[span[0] - 1 : span[1] + 1, 0]
    shared = shared_contour_notes(writing.program, writing.matched.path, last, x_before, x_after)
    return [*shared, *_no_longer_computed(writing), *_no_longer_taken_over(writing, read.targets)]


def _no_longer_computed(writing: Writing) -> list[str]:
    """Returns a note on arcs that the program computes from its variables, which numbers replace."""
    path, cuts = writing.matched.path, writing.matched.cuts
    arcs = [cut.move for cut in cuts if path.motion[cut.move] == Motion.ARC]
    blocks = (writing.program.block(int(path.block[move])) for move in arcs)
    lines = sorted({block.line for block in blocks if any(word.is_expression for word in block.data)})
    if not lines:
        return []
    return [
        wording(
            "The arcs of lines {lines} are computed in the given program; in the corrected one they are numbers, which "
            "hold for the present values of its variables alone.",
            lines=", ".join(map(str, lines)),
        )
    ]


def _no_longer_taken_over(writing: Writing, targets: Displacements) -> list[str]:
    """Returns a note on lines that take a computed coordinate over from an earlier block, and now have a number."""
    path, lines = writing.matched.path, set[int]()
    for cut in writing.matched.cuts:
        here, before = targets.ends.get(cut.move), targets.ends.get(cut.move - 1)
        if here is None or before is None or path.motion[cut.move] == Motion.ARC:
            continue
        block = writing.program.block(int(path.block[cut.move]))
        moved = np.abs((here - path.end_mm[cut.move, [0, 2]]) - (before - path.end_mm[cut.move - 1, [0, 2]]))
        for axis, grown_mm in zip((0, 2), moved.tolist(), strict=True):
            setting = np.flatnonzero(path.word[: cut.move + 1, axis] >= 0)
            if not len(setting) or setting[-1] == cut.move or grown_mm <= 0.5 * writing.matched.resolution_mm:
                continue
            if writing.program.word(int(path.word[setting[-1], axis])).is_expression:
                lines.add(block.line)
    if not lines:
        return []
    return [
        wording(
            "In lines {lines} a coordinate that an earlier block of the given program computes has become a number, "
            "which holds for the present values of its variables alone.",
            lines=", ".join(map(str, sorted(lines))),
        )
    ]


def _of_blocks(path: ToolPath, blocks: Integers) -> tuple[int, int]:
    """Returns first and last move of a range of blocks."""
    moves = np.flatnonzero((path.block >= blocks[0]) & (path.block <= blocks[1]))
    return int(moves[0]), int(moves[-1])


def _targets(
    writing: Writing,
    own: WrittenOut,
    profile: Profile,
    touches: ErrorVectors,
    before: Sequence[CentrePiece],
    after: Sequence[CentrePiece],
) -> Displacements:
    matched, cuts = writing.matched, writing.matched.cuts
    is_arc = np.flatnonzero(matched.path.motion == Motion.ARC)
    edges = [move.index for move in matched.match.between if move.index in is_arc]
    corners = np.array([feature.point_mm(feature.length_mm) for feature in profile.features])
    off_mm = np.linalg.norm(matched.path.centre_mm[edges][:, None, [0, 2]] - corners, axis=2)
    about = [k for k, far_mm in zip(edges, off_mm, strict=True) if far_mm.min() < ABOUT_MM]
    moved = with_edges(cuts, before, after, about)
    start, shifts = end_shifts(cuts, moved, before, after)
    start, shifts = _from_where_it_is(matched, before, start, shifts)
    touched = [touches.arc_length_mm[touches.of_feature(i)] for i in range(len(profile.features))]
    share = writing.chords * (FOR_CHORDS if matched.match.on_contour else 1.0)
    fitting = replace(writing.fitting, tolerance_mm=share * writing.fitting.tolerance_mm)
    bent = bent_lines(moved, list(is_arc), after, fitting.tolerance_mm) if fitting.lines else []
    arcs = replaced_arcs(moved, [*is_arc, *bent], after, touched, fitting)
    run_out = [move.index for move in matched.match.run_out]
    targets = displacements(matched.path, start, shifts, arcs, run_out)
    leads = (move for move in targets.ends if not cuts[0].move <= move <= cuts[-1].move)
    meant = {*leads, *(shift.move for shift in shifts), *run_out}
    targets = with_rapids(of_centre(own.path, matched.tip_mm), profile, targets, meant & set(targets.ends))
    arcs_too = Displacements(targets.ends, {**targets.arcs, **_edge_arcs(matched, edges, targets.ends)})
    return led_in(own.program, own.path, arcs_too)


def _from_where_it_is(
    matched: Commanded, before: Sequence[CentrePiece], start: Array, shifts: Sequence[EndShift]
) -> tuple[Array, tuple[EndShift, ...]]:
    """Displacements from where the program puts its ends, where these lie off the commanded contour by over a step.

    Coordinates and centre of an arc are rounded apart: its end may lie off its circle by more than it resolves. An end
    that two features share comes onto both where they meet at an angle, and halfway where they are nearly tangent.
    """
    path, cuts = matched.path, matched.cuts
    places: dict[int, list[tuple[int, float]]] = {}
    for k, cut in enumerate(cuts):
        ends = ends_of(cuts, k, before)
        places.setdefault(cut.move - 1, []).append((cut.feature, ends.start_mm))
        places.setdefault(cut.move, []).append((cut.feature, ends.end_mm))
    off = {
        move: _onto(path.end_mm[move, [0, 2]], [(before[feature], s) for feature, s in at], matched.resolution_mm)
        for move, at in places.items()
    }
    return start + off[cuts[0].move - 1], tuple(
        replace(shift, delta_mm=shift.delta_mm + off.get(shift.move, np.zeros(2))) for shift in shifts
    )


def _onto(at_mm: Array, places: Sequence[tuple[CentrePiece, float]], resolution_mm: float) -> Array:
    """Returns the shortest displacement (2,) that brings a place onto pieces; none where it is within a step of all."""
    tangents = np.array([np.asarray(piece.shifted.tangent(s)) for piece, s in places])
    normals = tangents[:, ::-1] * [1.0, -1.0] / np.linalg.norm(tangents, axis=1, keepdims=True)
    gaps_mm = np.array([
        normal @ (np.asarray(piece.shifted.centre_mm(s)) - at_mm)
        for normal, (piece, s) in zip(normals, places, strict=True)
    ])  # fmt: skip
    if np.max(np.abs(gaps_mm)) <= resolution_mm:
        return np.zeros(2)
    return np.asarray(np.linalg.lstsq(normals, gaps_mm, rcond=NEARLY_TANGENT)[0])


def _edge_arcs(matched: Commanded, edges: Sequence[int], ends: Mapping[int, Array]) -> dict[int, Replacement]:
    """Arcs that turn the nose about an edge, between their neighbours' displaced ends."""
    path = matched.path
    replaced: dict[int, Replacement] = {}
    for k in edges:
        old = move_of(path, k)
        start, end = np.asarray(old.start_mm) + ends[k - 1], np.asarray(old.end_mm) + ends[k]
        moved = between(old, (float(start[0]), float(start[1])), (float(end[0]), float(end[1])))
        replaced[k] = Replacement(k, (moved,))
    return replaced
