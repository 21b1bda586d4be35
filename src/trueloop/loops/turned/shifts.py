"""From error curves to the shift of every feature's contour: what to take out, and where an offset will do."""

from dataclasses import dataclass

import numpy as np

from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.loops.turned.commanded import Commanded
from trueloop.turned.compensation.decide import FACES_AXIS, Decision
from trueloop.turned.compensation.lean import of_curve, of_slope, to_take_out
from trueloop.turned.compensation.shift import ZERO, Shift, constant, weighted_sum
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.options import Options


@dataclass(frozen=True)
class Shifts:
    """By feature: `correction` = −w × process error, and `contour`, where the contour then deviates from the nominal.

    `by_offset` says for which features the correction is the fitted constant offset instead of their own curve.
    `unasked` is what the slopes ask for besides where nobody says whether errors follow the nose (`lean.of_slope`).
    """

    correction: tuple[Shift, ...]
    contour: tuple[Shift, ...]
    by_offset: tuple[bool, ...]
    unasked: tuple[Shift, ...]


def whole_mm(decision: Decision) -> tuple[float, float]:
    """What the whole contour is displaced by, (x as a radius, z): an offset that is enough and that the contour shall
    carry; else nothing.
    """
    return decision.offset_mm if decision.offset_is_enough and not decision.by_offset else (0.0, 0.0)


def corrected_shifts(
    profile: Profile, model: ProfileErrorModel, decision: Decision, matched: Commanded, options: Options
) -> Shifts:
    """`contour` = correction + the rounding of the program; a slip of the program is corrected away with the rest.

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
    by_offset = _by_offset(profile, decision)
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


def _sum(one: Shift, other: Shift) -> Shift:
    return weighted_sum(((1.0, one), (1.0, other)))


def _by_offset(profile: Profile, decision: Decision) -> tuple[bool, ...]:
    """A feature follows the offset when no axis it faces needs a contour, and its tangent neighbours follow it too."""
    needs = np.array([not decision.x.enough, not decision.z.enough])
    follows = [not np.any(_faces(feature) & needs) for feature in profile.features]
    for _ in profile.junctions:
        for i, junction in enumerate(profile.junctions):
            if junction.kind is JunctionKind.TANGENT:
                follows[i] = follows[i + 1] = follows[i] and follows[i + 1]
    return tuple(follows)


def _faces(feature: Feature) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    normals = feature.outward_normal(np.linspace(0.0, feature.length_mm, 17))
    return np.asarray(np.any(np.abs(normals) > FACES_AXIS, axis=0))


def _constant(feature: Feature, decision: Decision) -> Shift:
    """The offset seen along the feature's normal: constant on a line, and only lines face a single axis."""
    return constant(float(feature.outward_normal(0.0) @ np.array(decision.offset_mm)))
