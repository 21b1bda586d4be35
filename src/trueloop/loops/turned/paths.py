"""From error curves to the path that is to be driven: the shift of every feature, where an offset will do, and the
nose-centre path as the finish program commands it and as it is to be driven.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.geometry.feature import Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part_on_machine import InMachine, check_composed
from trueloop.nc.match.cutting_edge import CENTRE
from trueloop.nc.program.tool_path import Motion
from trueloop.turned.compensation.contour import CentrePiece, centre_pieces, shifted_contour
from trueloop.turned.compensation.decide import FACES_AXIS, Decision
from trueloop.turned.compensation.displaced import Constant, Displacement, Then, displaced_pieces
from trueloop.turned.compensation.limits import check_limits, check_nose, check_offset
from trueloop.turned.compensation.shift import ZERO, Shift, constant, of_curve, of_slope, to_take_out, weighted_sum
from trueloop.turned.compensation.targets import SAMPLES_OF_LINE, Fitting, cramped_lines
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.options import Options
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
    """Returns the displacement of the whole contour, (x as a radius, z): an offset that is enough and that the contour
    shall carry; else nothing.
    """
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
    contour = tuple(_sum(one, rounding) for one, rounding in zip(correction, matched.rounding, strict=True))
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
