"""Implausible touches: off the profile, in the wrong unit, a diameter for a radius, the sign reversed.

Each check compares what was given with what one common blunder would have made of it, and refuses only when the
blunder explains the data much better.
"""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import Touch
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import MM_PER_INCH, UM_PER_MM

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
