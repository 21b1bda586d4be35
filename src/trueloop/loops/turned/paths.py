"""From error curves to the path that is to be driven: the shift of every feature, where an offset will do, and the
nose-centre path as the finish program commands it and as it is to be driven.

Roughing cycles that run on the contour: they move with it, which notes say, or stay where they were; then their
passes are compared, and what they leave to be cut.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.loops.turned.commanded import Commanded, Run
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part_on_machine import InMachine, check_composed
from trueloop.nc.edit.changes import composed
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.expand.expand import WrittenOut, require_same_path, written_out
from trueloop.nc.match.cutters import CENTRE
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.compensation.decide import FACES_AXIS, Decision
from trueloop.turned.compensation.displaced import (
    CentrePiece,
    Constant,
    Displacement,
    Then,
    centre_pieces,
    displaced_pieces,
    shifted_contour,
)
from trueloop.turned.compensation.limits import check_limits, check_nose, check_offset
from trueloop.turned.compensation.shift import ZERO, Shift, constant, of_curve, of_slope, to_take_out, weighted_sum
from trueloop.turned.compensation.targets import SAMPLES_OF_LINE, Fitting, cramped_lines
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.options import Options
from trueloop.turned.program.contour_cycles import finishing_cycle, own_contour, roughed_by, roughing_cycles
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording


@dataclass(frozen=True)
class Shifts:
    """The shifts by feature: `correction` = −w × process error, and `contour`, the resulting deviation of the contour
    from the nominal.

    `by_offset` says for which features the correction is the fitted constant offset instead of their own curve.
    `unasked` is what the slopes ask for besides where nobody says whether errors follow the nose (`lean.of_slope`).
    """

    correction: tuple[Shift, ...]
    contour: tuple[Shift, ...]
    by_offset: tuple[bool, ...]
    unasked: tuple[Shift, ...]


def whole_mm(decision: Decision) -> tuple[float, float]:
    """Returns the displacement of the whole contour, (x as a radius, z), where an offset is enough; else nothing."""
    return decision.offset_mm if decision.offset_is_enough and not decision.by_offset else (0.0, 0.0)


def corrected_shifts(
    profile: Profile, model: ProfileErrorModel, decision: Decision, matched: Commanded, options: Options
) -> Shifts:
    """Returns shifts with `contour` = correction + the rounding of the program; a slip of the program is corrected away
    with the rest.

    With `errors_follow` = "nose" the correction holds on arcs what the error's slope asks for besides
    (`compensation.lean`). When the tool offset does it all nothing is shifted; when it could but the contour shall
    carry it, only slips of the program are: `whole_mm` is then what the contour is displaced by as a whole. The contour
    of a corrected program in force is kept, and the correction comes on top of it.
    """
    count = len(profile.features)
    if decision.by_offset:
        return Shifts((ZERO,) * count, matched.finish, (True,) * count, (ZERO,) * count)
    if decision.offset_is_enough:
        contour = matched.in_force or matched.rounding
        return Shifts(matched.in_force or (ZERO,) * count, contour, (True,) * count, (ZERO,) * count)
    # For each feature whether it follows the offset: it is a line (its shift is constant), no axis it faces needs a
    # contour, no reading of it that no offset changes does, and its tangent neighbours follow it too.
    needs = np.array([not decision.x.enough, not decision.z.enough])
    seen = () if decision.unmoved is None else decision.unmoved.features
    follows = [
        isinstance(one, Line) and k not in seen and not np.any(_faces(one) & needs)
        for k, one in enumerate(profile.features)
    ]
    for _ in profile.junctions:
        for i, junction in enumerate(profile.junctions):
            if junction.kind is JunctionKind.TANGENT:
                follows[i] = follows[i + 1] = follows[i] and follows[i + 1]
    by_offset = tuple(follows)
    nose = options.errors_follow == "nose"
    curves = list(enumerate(model.curves))
    errors = [to_take_out(profile, i, curve) if nose else of_curve(curve) for i, curve in curves]
    unasked = (ZERO if nose or by_offset[i] else of_slope(profile, i, curve) for i, curve in curves)
    correction = tuple(
        _constant(feature, decision) if by_one else weighted_sum(((-options.weight, error),))
        for feature, error, by_one in zip(profile.features, errors, by_offset, strict=True)
    )
    if matched.in_force:
        correction = tuple(map(_sum, correction, matched.in_force))
        return Shifts(correction, correction, by_offset, tuple(unasked))
    contour = tuple(_sum(shift, rounding) for shift, rounding in zip(correction, matched.rounding, strict=True))
    return Shifts(correction, contour, by_offset, tuple(unasked))


def _sum(shift: Shift, other: Shift) -> Shift:
    return weighted_sum(((1.0, shift), (1.0, other)))


def _faces(feature: Feature) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    normals = feature.outward_normal(np.linspace(0.0, feature.length_mm, 17))
    return np.asarray(np.any(np.abs(normals) > FACES_AXIS, axis=0))


def _constant(feature: Feature, decision: Decision) -> Shift:
    """Returns the offset seen along the feature's normal: constant on a line."""
    return constant(float(feature.outward_normal(0.0) @ np.array(decision.offset_mm)))


@dataclass(frozen=True)
class Driven:
    """The contour as the control drives it under G41 or G42: the nose radius, and the intended path of its centre."""

    nose_radius_mm: float
    pieces: Sequence[CentrePiece]

    def along(self, contour: Sequence[CentrePiece], largest_mm: float) -> list[CentrePiece]:
        """Returns the pieces as far as the nose touches their own feature of the contour, corners of the contour being
        turned.

        Without the last nose radius at the profile's free ends, where ways in and out have a say, and as much of it as
        a correction of `largest_mm` may move it by.
        """
        pieces = [
            replace(piece, start_mm=max(piece.start_mm, own.start_mm), end_mm=min(piece.end_mm, own.end_mm))
            for piece, own in zip(self.pieces, contour, strict=True)
        ]
        short_mm = self.nose_radius_mm + largest_mm
        pieces[0] = replace(pieces[0], start_mm=pieces[0].start_mm + short_mm)
        pieces[-1] = replace(pieces[-1], end_mm=pieces[-1].end_mm - short_mm)
        return [piece for piece in pieces if piece.end_mm > piece.start_mm]


@dataclass(frozen=True)
class Paths:
    """Paths of the finish pass before and after the correction, one piece a feature.

    `commanded` and `corrected` are of the nose centre, `written` what the program spells for them, before and after:
    the same, or those of the tip that it moves, or, where the control itself keeps the nose off, the contour; then
    `driven` says what it makes of that.
    """

    commanded: tuple[CentrePiece, ...]
    corrected: tuple[CentrePiece, ...]
    written: tuple[tuple[CentrePiece, ...], tuple[CentrePiece, ...]]
    driven: Driven | None


def corrected_paths(
    inputs: Inputs, matched: Commanded, shifts: Shifts, decision: Decision, machine: InMachine | None
) -> Paths:
    """Returns the paths with every feature shifted, then displaced by an offset that the contour carries and, on a
    known machine, by COMP_MTG. An offset that was in force is carried by the contour too, but for what of it stands in
    the control's wear table: that moves the tool anyhow.

    Raises GEO-NOSE where the nose would not fit, CMP-SIZE and CMP-SLOPE for a correction over the limits.
    """
    profile, nose_radius_mm, limits = inputs.profile, inputs.nose_radius_mm, inputs.options.limits

    def pieces(of: Sequence[Shift], nose_mm: float) -> tuple[CentrePiece, ...]:
        return centre_pieces(profile, shifted_contour(profile, of, nose_mm))

    cut, change_mm = inputs.in_force.cut_with, whole_mm(decision)
    offset_mm = (change_mm[0] + cut.offset_mm[0], change_mm[1] + cut.offset_mm[1])
    check_offset(offset_mm, limits)
    before, after = pieces(matched.finish, nose_radius_mm), pieces(shifts.contour, nose_radius_mm)
    check_nose(after)
    check_limits(after, shifts.correction, limits)
    moved: Displacement = Constant((0.0, 0.0) if decision.by_offset else cut.still_to_do(offset_mm))
    if machine is not None:
        moved = Then(moved, machine.comp_mtg)
        check_composed(after, shifts.correction, (machine.comp_mtg, moved), limits)
    undisplaced, after, driven = after, displaced_pieces(after, moved), None
    written = before, after
    if matched.match.on_contour:
        written = pieces(matched.finish, 0.0), displaced_pieces(pieces(shifts.contour, 0.0), moved)
        driven = Driven(nose_radius_mm, after)
    elif matched.tip_mm != CENTRE:
        to_tip = Constant(matched.tip_mm)
        written = displaced_pieces(before, to_tip), displaced_pieces(undisplaced, Then(moved, to_tip))
    return Paths(before, after, written, driven)


def bends_lines(model: ProfileErrorModel) -> bool:
    """Returns whether the error of a straight feature is not a straight line."""
    curves = zip(model.profile.features, model.curves, strict=True)
    return any(isinstance(feature, Line) and curve.spline.degree > 1 for feature, curve in curves)


def cramped_bows(matched: Commanded, model: ProfileErrorModel, paths: Paths, fitting: Fitting) -> dict[str, str]:
    """Returns the lines whose bow no moves can follow that the control keeps the nose off, each with a note."""
    if not fitting.nose_mm or not bends_lines(model):
        return {}
    is_arc = np.flatnonzero(matched.path.motion == Motion.ARC)
    notes = dict[str, str]()
    for i in cramped_lines(matched.cuts, list(is_arc), paths.written[1], fitting):
        curve = model.curves[i]
        if curve.spline.degree == 1 or curve.feature in model.options.straight:
            continue
        s = np.linspace(0.0, curve.length_mm, SAMPLES_OF_LINE)
        bow = curve.value_mm(s) - np.polyval(np.polyfit(s, curve.value_mm(s), 1), s)
        notes[curve.feature] = wording(
            "{feature}: its error is bent by up to {bow}, which stays: under G41 or G42 the moves next to its corners "
            "are as long as the nose of {nose} mm needs, and cannot follow it. It is corrected by size and taper",
            feature=curve.feature,
            bow=Um(float(np.max(np.abs(bow)))),
            nose=f"{fitting.nose_mm:g}",
        )
    return notes


def shared_contour_notes(
    program: Program, path: ToolPath, move: int, x_before_mm: Array, x_after_mm: Array
) -> list[str]:
    """Notes the roughing cycle that shares a move's contour, by the contour's ends in x (n,), before and after."""
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
    """Returns the program without roughing cycles on this move's contour. Raises NC-EDIT: the path would change."""
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
            wording(
                "the roughing of line {line} of the corrected program stays, and would cut {below_um:.2f} µm below "
                "the corrected contour at x {x_mm:.4f} mm (radius), z {z_mm:.4f} mm",
                line=line,
                below_um=below_um,
                x_mm=point[0],
                z_mm=point[1],
            ),
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
        "roughing is to stay where it is, and its passes follow from blocks of the finishing cycle's contour",
        hint='write the contour between P and Q without calls, or have `programs.roughing = "moves"`',
        place=program.place(cycle.block.start),
    )
