"""Touches to error vectors: what the probe reported, as part errors along the nominal normal.

`e = n · (measured − nominal) − ball radius − allowance`, positive = material left on [6876 glossary, PARTERROR]. A
touch that was not exactly along n keeps its normal component only. The part's z is taken from a reference point
[6811 §5.1].

Implausible touches: off the profile, in the wrong unit, a diameter for a radius, the sign reversed.

Each check compares what was given with what one common blunder would have made of it, and refuses only when the
blunder explains the data much better.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import Touch
from trueloop.domain.option import Option
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import COARSEST_U_UM, MM_PER_INCH, UM_PER_MM

ON_PROFILE_MM: Final = 0.5
"""A nominal point further than this from its feature is not on it: ten times what a drawing is rounded to."""

CREDIBLE_ERROR_MM: Final = 1.0
"""A finish allowance is tenths of a millimetre: a larger part error is a mistake in the data."""

SAME_POINT_MM: Final = 1e-3

OPPOSED: Final = 0.2
"""A blunder of sign is what leaves less than this share of what it is to explain."""

LEAST_SCATTER: Final = 0.3
ENOUGH: Final = 6

BLUNDERS: Final[tuple[tuple[Code, str, tuple[float, float], str], ...]] = (
    (Code.TCH_UNIT, "25.4 times too small", (MM_PER_INCH, MM_PER_INCH), "inches in a column named mm?"),
    (Code.TCH_UNIT, "25.4 times too large", (1 / MM_PER_INCH, 1 / MM_PER_INCH), "millimetres in a column named in?"),
    (Code.TCH_DIAMETER, "twice too large in x", (0.5, 1.0), "diameters in a column of radii?"),
    (Code.TCH_DIAMETER, "half of x", (2.0, 1.0), "radii in a column of diameters?"),
)
"""Code, what it looks like, by what (x, z) would have to be multiplied, what may have happened."""


def check_positions(profile: Profile, touches: Sequence[Touch]) -> None:
    """Refuses a feature that is not of the part, wrong units, diameters for radii, and points off their feature."""
    for touch in touches:
        if touch.feature is not None and touch.feature not in profile.names:
            raise Code.TCH_FEATURE.refusal(
                f"touch {touch.point!r} is on feature {touch.feature!r}, which the part does not have",
                hint=f"the part's features are: {', '.join(profile.names)}",
                place=Place(line=touch.line),
                values={"point": touch.point, "feature": touch.feature},
            )
    nominal = np.array([touch.nominal_mm for touch in touches])
    features = [touch.feature for touch in touches]
    away = _distance_mm(profile, features, nominal)
    if np.all(away <= ON_PROFILE_MM):
        return
    _refuse_blunder(lambda scale: _distance_mm(profile, features, nominal * scale) <= ON_PROFILE_MM, touches)
    k = int(np.argmax(away))
    on = f"feature {features[k]!r}" if features[k] else "any feature"
    raise Code.TCH_OFF_PROFILE.refusal(
        f"touch {touches[k].point!r} at x {nominal[k, 0]:.4f} mm (radius), z {nominal[k, 1]:.4f} mm "
        f"lies {away[k]:.3f} mm off {on}; at most {ON_PROFILE_MM} mm is accepted",
        hint="nominal coordinates are the part's, x as a radius, z from the part's origin",
        place=Place(line=touches[k].line),
        values={"point": touches[k].point, "off_mm": float(away[k]), "limit_mm": ON_PROFILE_MM},
    )


def check_sizes(touches: Sequence[Touch], error: Array, measured: Array, expected: Array, normal: Array) -> None:
    """Refuses part errors too large to be true, naming the blunder in the measured points that would explain them.

    `expected` is where a part without error would have been measured: ball and allowance off the nominal points.
    """
    large = np.abs(error) > CREDIBLE_ERROR_MM
    if not np.any(large):
        return

    def credible(scale: Array) -> Flags:
        along_normal: Array = np.sum(normal * (measured * scale - expected), axis=1)
        return np.abs(along_normal) <= CREDIBLE_ERROR_MM

    _refuse_blunder(credible, touches)
    k = int(np.argmax(np.abs(error)))
    raise Code.TCH_OFF_PROFILE.refusal(
        f"touch {touches[k].point!r} has a part error of {error[k]:.3f} mm; at most {CREDIBLE_ERROR_MM} mm is credible",
        hint="check the frame of the measured points, the ball radius and `gauging.measured_allowance_mm`"
        if touches[k].error_mm is None
        else "micrometres in a column of millimetres? The header names the unit: error_um, error_mm, error_in",
        place=Place(line=touches[k].line),
        values={"point": touches[k].point, "off_mm": float(error[k]), "limit_mm": CREDIBLE_ERROR_MM},
    )


def check_stated_sign(touches: Sequence[Touch], stated: Array, measured: Array) -> None:
    """Refuses stated errors, (n,), that are the opposite of those from the measured points of the same touches.

    So look those of a bore that was taken for an outside: there a larger radius is less material, not more.
    """
    both = ~np.isnan(stated) & ~np.isnan(measured)
    agrees, opposed = (rms(stated[both] - sign * measured[both]) for sign in (1.0, -1.0))
    if not np.any(both) or not opposed < OPPOSED * agrees:
        return
    raise Code.TCH_SIGN.refusal(
        f"the stated errors of {np.count_nonzero(both)} touches are the opposite of their measured points: "
        f"{rms(stated[both]) * UM_PER_MM:.1f} µm RMS, and {opposed * UM_PER_MM:.1f} µm RMS with the sign reversed",
        hint="an error is positive where material is left on: in a bore where the radius is too small",
        place=Place(line=touches[int(np.argmax(both))].line),
        values={"ratio": -1.0, "correlation": -1.0},
    )


def check_ball_side(touches: Sequence[Touch], error: Array, ball_radius_mm: float) -> None:
    """Refuses ball centres on the material's side of the surface: a bore touched as an outside, or the other way."""
    size = np.abs(error)
    if ball_radius_mm <= 0 or not np.all(np.abs(error + 2.0 * ball_radius_mm) < OPPOSED * size):
        return
    raise Code.TCH_SIGN.refusal(
        f"the {len(touches)} ball centres lie {np.mean(-error) - ball_radius_mm:.4f} mm inside the material, about the "
        f"ball's radius of {ball_radius_mm:.4f} mm",
        hint="was a bore touched as an outside? `part.side` says which it is; measured points are ball centres",
        place=Place(line=touches[0].line),
        values={"ratio": -1.0, "correlation": -1.0},
    )


def check_scale(touches: Sequence[Touch], error: Array, standard_u: Array) -> None:
    """Refuses stated errors far below what the probe repeats by: millimetres in a column named µm?

    Touches of a perfect part scatter by the probe's own uncertainty: at most `LEAST_SCATTER` of it, root mean square
    over `ENOUGH` touches or more, has a probability of 1 in 370. Errors that are all exactly zero are left alone.
    """
    given = np.array([touch.error_mm is not None for touch in touches])
    size, u = rms(error[given]), rms(standard_u[given])
    if np.count_nonzero(given) < ENOUGH or not 0.0 < size < LEAST_SCATTER * u:
        return
    raise Code.TCH_UNIT.refusal(
        f"the {np.count_nonzero(given)} stated errors are {size * UM_PER_MM:.3f} µm RMS, where the probe alone repeats "
        f"to {u * UM_PER_MM:.2f} µm (standard uncertainty)",
        hint="millimetres in a column named error_um? The header names the unit: error_um, error_mm, error_in",
        place=Place(line=touches[int(np.argmax(given))].line),
        override="gauging.repeatability_diameter_um and gauging.repeatability_face_um in the job, for a finer probe",
    )


def check_order(profile: Profile, vectors: ErrorVectors, lines: Sequence[int | None]) -> None:
    """Refuses names given twice, places touched twice, and points that do not follow each other along the profile."""
    seen: dict[str, int] = {}
    for k, name in enumerate(vectors.point):
        if name in seen:
            raise _duplicate(f"point {name!r} stands twice, first as touch {seen[name] + 1}", name, lines[k])
        seen[name] = k
    along = np.array([profile.start_of(int(i)) for i in vectors.feature_index]) + vectors.arc_length_mm
    for k in range(1, len(along)):
        pair = f"touches {vectors.point[k - 1]!r} and {vectors.point[k]!r}"
        if abs(along[k] - along[k - 1]) < SAME_POINT_MM:
            raise _duplicate(
                f"{pair} are {abs(along[k] - along[k - 1]) * UM_PER_MM:.2f} µm apart", vectors.point[k], lines[k]
            )
        if along[k] < along[k - 1]:
            raise Code.TCH_ORDER.refusal(
                f"{pair} lie {along[k - 1]:.3f} mm and {along[k]:.3f} mm along the profile: not in order",
                hint="list touches from chuck end to free end; if the order is right, the nominal points are not",
                place=Place(line=lines[k]),
                values={"points": list(vectors.point[k - 1 : k + 1]), "along_mm": along[k - 1 : k + 1].tolist()},
            )


def check_loop_sign(before: ErrorVectors, after: ErrorVectors) -> None:
    """Refuses touches after the finish cut that are about twice those before it: the correction was added, not taken.

    The slope of after on before is 0 for a perfect correction, 1 for none, 2 for one of reversed sign.
    """
    common = [(before.point.index(name), k) for k, name in enumerate(after.point) if name in before.point]
    x, y = before.error_mm[[i for i, _ in common]], after.error_mm[[k for _, k in common]]
    if len(common) < 3 or not np.any(x):
        return
    x, y = x / np.max(np.abs(x)), y / np.max(np.abs(x))  # squares of the smallest numbers are zero
    slope = float(x @ y / (x @ x))
    if slope <= 1.5:
        return
    correlation = float(np.corrcoef(x, y)[0, 1]) if np.ptp(x) and np.ptp(y) else 1.0
    if correlation > 0.9:
        raise Code.TCH_SIGN.refusal(
            f"the errors after the finish cut are {slope:.2f} times those before it (correlation {correlation:.2f}): "
            "the correction was applied with its sign reversed",
            hint="check the sign of the error column (positive = material left on) and of the tool offsets",
            values={"ratio": slope, "correlation": correlation},
        )


def _distance_mm(profile: Profile, features: Sequence[str | None], points: Array) -> Array:
    """Returns how far each point is from the feature it names (the nearest where it names none), ends included."""
    nearest = profile.locate(points)
    away = np.empty(len(points))
    for k, name in enumerate(features):
        index = int(nearest.feature_index[k]) if name is None else profile.names.index(name)
        feature = profile.features[index]
        arc_length, distance = feature.locate(points[k])
        beyond = max(-float(arc_length), float(arc_length) - feature.length_mm, 0.0)
        away[k] = np.hypot(float(distance), beyond)
    return away


def _refuse_blunder(accepted_when_scaled: Callable[[Array], Flags], touches: Sequence[Touch]) -> None:
    """Raises the blunder whose undoing makes at least nine of ten touches acceptable."""
    for code, looks, scale, question in BLUNDERS:
        share = float(np.mean(accepted_when_scaled(np.array(scale))))
        if share >= 0.9:
            raise code.refusal(
                f"the points look {looks}: {share:.0%} of {len(touches)} touches fit when x is multiplied by "
                f"{scale[0]:.4g} and z by {scale[1]:.4g}",
                hint=f"{question} The header names the unit: nominal_x_mm, nominal_x_in, nominal_x_diameter_mm",
                place=Place(line=touches[0].line),
                values=dict(zip(code.values, scale, strict=False)),
            )


def _duplicate(message: str, point: str, line: int | None) -> TrueloopError:
    return Code.TCH_DUPLICATE.refusal(
        message,
        hint="keep one row a point; average repeated touches before",
        place=Place(line=line),
        values={"point": point},
    )


REFERENCE_FACES: Final = 0.5
"""A z reference must look along z: |n_z| of at least cos 60°, or its error would be divided by a small number."""


@dataclass(frozen=True)
class Gauging:
    """The conditions of the touches. Ranges are those of repeated probing, along x and along z [6811 §4.1].

    >>> trueloop.Gauging(ball_radius_mm=1.5).range_x_mm
    0.0015
    """

    ball_radius_mm: Annotated[
        float,
        Option(
            "gauging.ball_radius_mm", "Radius of the probe's ball, where measured points are ball centres.", least=0
        ),
    ] = 0.0
    allowance_mm: Annotated[
        float,
        Option(
            "gauging.measured_allowance_mm",
            "What the cut was to leave on, where measured points are of the oversize surface.",
        ),
    ] = 0.0
    range_x_mm: Annotated[
        float,
        Option(
            "gauging.repeatability_diameter_um",
            "Range of repeated touches along x. The standard uncertainty is the range by √12.",
            least=0,
            most=2.0 * COARSEST_U_UM,
        ),
    ] = 1.5 / UM_PER_MM
    range_z_mm: Annotated[
        float, Option("gauging.repeatability_face_um", "The same along z.", least=0, most=2.0 * COARSEST_U_UM)
    ] = 0.5 / UM_PER_MM
    readings_u_mm: Annotated[
        float,
        Option(
            "gauging.readings_u_um",
            "Standard uncertainty of readings that state none, of a diameter on the diameter: a workshop micrometer "
            "in good order and a part within some kelvin of 20 °C.",
            above=0,
            most=COARSEST_U_UM,
        ),
    ] = 2.0 / UM_PER_MM
    z_reference: Annotated[
        str | None,
        Option(
            "gauging.z_reference",
            "The point, on a face, from which the part's z is taken: its error is zero by definition. Left out, z is "
            "as reported.",
        ),
    ] = None


def standard_uncertainty_mm(outward_normal: Array, gauging: Gauging) -> Array:
    """Returns the type B uncertainty of an error along n: u = R/√12 on each axis [6811 §5.1], projected on n. (n, 2) →
    (n,).

    The ranges of 1.5 µm and 0.5 µm give 0.43 µm on a cylinder and 0.14 µm on a face. Valid while repeatability is
    all that matters: temperature and geometry of the machine are left out, as in the report.
    """
    u_x, u_z = gauging.range_x_mm / math.sqrt(12), gauging.range_z_mm / math.sqrt(12)
    normal = np.atleast_2d(outward_normal)
    return np.hypot(normal[:, 0] * u_x, normal[:, 1] * u_z)


def in_order(profile: Profile, touches: Sequence[Touch]) -> list[Touch]:
    """Touches in their order along the profile: each on the feature that it names, else on the nearest."""

    def along_mm(touch: Touch) -> float:
        nearest = int(profile.locate(np.array([touch.nominal_mm])).feature_index[0])
        index = profile.names.index(touch.feature) if touch.feature in profile.names else nearest
        return profile.start_of(index) + float(profile.features[index].locate(touch.nominal_mm)[0])

    return sorted(touches, key=along_mm)


def error_vectors(profile: Profile, touches: Sequence[Touch], gauging: Gauging) -> ErrorVectors:
    """Returns part errors of the touches, ordered along the profile. Raises TCH errors for implausible touches.

    >>> profile = trueloop.read_part(trueloop.example("modbas2/job.toml")).profile
    >>> touches = trueloop.read_touches(trueloop.example("modbas2/touches.csv"))
    >>> errors = trueloop.error_vectors(profile, touches, trueloop.Gauging(z_reference="11"))
    >>> print(errors.error_mm[:2], errors.outward_normal[0].round(3))  # along the outward normal (x, z)
    [0.090297 0.09271 ] [0.875 0.484]
    """
    feature_index, arc_length = _place(profile, touches)
    normal = np.array([profile.features[i].outward_normal(s) for i, s in zip(feature_index, arc_length, strict=True)])
    nominal = np.array([touch.nominal_mm for touch in touches])
    vectors = ErrorVectors(
        point=tuple(touch.point for touch in touches),
        feature_index=feature_index,
        arc_length_mm=arc_length,
        error_mm=_part_error(touches, nominal, normal, gauging),
        standard_u_mm=standard_uncertainty_mm(normal, gauging),
        at_reference=np.zeros(len(touches), dtype=np.bool_),
        nominal_mm=nominal,
        outward_normal=normal,
    )
    check_scale(touches, vectors.error_mm, vectors.standard_u_mm)
    check_order(profile, vectors, [touch.line for touch in touches])
    return vectors if gauging.z_reference is None else _from_reference(vectors, gauging.z_reference)


def _place(profile: Profile, touches: Sequence[Touch]) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], Array]:
    """Returns feature and arc length of each touch: on the feature it names, else on the nearest."""
    if not touches:
        raise Code.TCH_FILE.refusal(
            "there are 0 touches", hint="one row a touch: feature, point, nominal, measured or error"
        )
    check_positions(profile, touches)
    names = profile.names
    nearest = profile.locate(np.array([touch.nominal_mm for touch in touches]))
    index = np.array(
        [
            nearest.feature_index[k] if touch.feature is None else names.index(touch.feature)
            for k, touch in enumerate(touches)
        ],
        dtype=np.intp,
    )
    arc_length = [
        float(profile.features[i].locate(touch.nominal_mm)[0]) for i, touch in zip(index, touches, strict=True)
    ]
    return index, np.array(arc_length)


def _part_error(touches: Sequence[Touch], nominal: Array, normal: Array, gauging: Gauging) -> Array:
    """Returns the stated errors, or n · (measured − nominal) less the ball and the intended allowance."""
    given = np.array([np.nan if touch.error_mm is None else touch.error_mm for touch in touches])
    measured = np.array([(np.nan, np.nan) if t.measured_mm is None else t.measured_mm for t in touches])
    along_normal = np.einsum("ij,ij->i", normal, measured - nominal)
    found = along_normal - gauging.ball_radius_mm - gauging.allowance_mm
    check_stated_sign(touches, given, found)
    error = np.where(np.isnan(given), found, given)
    check_ball_side(touches, error, gauging.ball_radius_mm)
    expected = nominal + (gauging.ball_radius_mm + gauging.allowance_mm) * normal
    check_sizes(touches, error, measured, expected, normal)
    return error


def no_reference(point: str, touches: int) -> TrueloopError:
    """Returns the error for a z reference that was not touched."""
    return Code.TCH_REFERENCE.refusal(
        f"the z reference {point!r} is not one of the {touches} touches",
        hint="`gauging.z_reference` names a point as it stands in the touches' column `point`; readings need none: "
        "they count from a face of their own",
        values={"point": point},
    )


def _from_reference(vectors: ErrorVectors, point: str) -> ErrorVectors:
    """Shifts the part frame along z so that the error at the reference point is zero [6811 §5.1]."""
    if point not in vectors.point:
        raise no_reference(point, len(vectors.point))
    k = vectors.point.index(point)
    facing = float(vectors.outward_normal[k, 1])
    if abs(facing) < REFERENCE_FACES:
        raise Code.TCH_REFERENCE.refusal(
            f"the z reference {point!r} faces x: its normal is ({vectors.outward_normal[k, 0]:.3f}, {facing:.3f})",
            hint="take z from a point on a face",
            values={"point": point},
        )
    share = vectors.outward_normal[:, 1] / facing
    u_shared = np.hypot(vectors.standard_u_mm, np.abs(share) * vectors.standard_u_mm[k])
    at_reference = np.arange(len(vectors.point)) == k
    return replace(
        vectors,
        error_mm=np.where(at_reference, 0.0, vectors.error_mm - share * vectors.error_mm[k]),
        standard_u_mm=np.where(at_reference, vectors.standard_u_mm, u_shared),
        at_reference=at_reference,
    )
