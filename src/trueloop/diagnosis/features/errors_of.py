"""Errors of features from points of their surfaces [4773 §4.2 a–d, f]: straightness, waviness, waves around the turn.

The sources do not treat roundness; amplitudes of waves around the turn are those of ISO 12181's harmonics.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.polynomial import legendre, polynomial
from scipy.stats import chi2

from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_error import (
    SMOOTH_PLACES,
    SPAN,
    STRAIGHT,
    WAVES,
    Averaged,
    ErrorKind,
    FeatureError,
    FeaturePlace,
    Form,
    SeenPoints,
    averaged,
    form_of,
)
from trueloop.errors import Code, Finding, Severity
from trueloop.wording import wording

GRID = np.linspace(-1.0, 1.0, 201)
SHAPES = legendre.legvander(GRID, 3)[:, 2:]
"""P₂ and P₃: what a cubic has beside a line; no line over the whole range is left in them."""
DIRECTIONS = 24


def straightness_of(form: Form, name: str) -> tuple[FeatureError, ...]:
    """Peak to valley of the cubic without its line, over what was measured, and the waviness; () below six places.

    A size is never negative, so that noise alone has one: what noise has on average is taken out of its square,
    v² = p² − E[p² of noise], 0 where that is negative. u is that of p linearised, and where noise prevails that of a
    normal size. `more` has the polynomial a₀ … a₃ of the distance from the end that is nearer to the chuck, or to the
    axis. Checked by simulation: value ± 2 u holds the true one in 93 % of cases or more, from straight to much bent,
    where points scatter by no more than the device states; with Student's factor else.
    """
    if form.smooth is None:
        return ()
    bent, covariance = form.smooth.coefficients[2:4], form.smooth.covariance[2:4, 2:4]
    peak_to_valley = float(np.ptp(SHAPES @ bent))
    # Root mean square of the peak to valley of noise: E[R²] = 2 times the mean square over directions
    turn = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
    ways = np.linalg.cholesky(covariance) @ np.stack([np.cos(turn), np.sin(turn)])
    noise = float(np.sqrt(2.0 * np.mean(np.ptp(SHAPES @ ways, axis=0) ** 2)))
    # How the peak to valley changes with the coefficients, (2,)
    shape = SHAPES @ bent
    gradient: Array = SHAPES[int(np.argmax(shape))] - SHAPES[int(np.argmin(shape))]
    u = max(float(np.sqrt(gradient @ covariance @ gradient)), 0.0 if peak_to_valley > noise else noise / np.sqrt(2.0))
    found = FeatureError(
        feature=name,
        kind=ErrorKind.STRAIGHTNESS,
        value_mm=float(np.sqrt(max(peak_to_valley**2 - noise**2, 0.0))),
        standard_u_mm=u,
        points=form.points.readings,
        degrees_of_freedom=form.degrees_of_freedom,
        more=_powers(form),
    )
    return found, _waviness(form, name)


def _powers(form: Form) -> dict[str, float]:
    """a₀ … a₃ in mm of the distance from the first place, mm."""
    assert form.smooth is not None
    low, high = form.ends_mm
    in_t = polynomial.Polynomial(legendre.leg2poly(form.smooth.coefficients[:4]))
    found = in_t(polynomial.Polynomial([-1.0, 2.0 / (high - low)])).coef
    a = np.pad(found, (0, 4 - len(found)))  # coefficients that are zero at the end are left out by the conversion
    names = ("a0_mm", "a1_rad", "a2_per_mm", "a3_per_mm2")
    return {name: float(value) for name, value in zip(names, a, strict=True)} | {"from_mm": low, "to_mm": high}


def _waviness(form: Form, name: str) -> FeatureError:
    """Standard deviation of the points about the smooth form, beyond what the device states.

    u is the largest of s/√(2ν), which a standard deviation s of ν residuals has, and of what makes two of them reach to
    zero as often as noise alone does, and up to τ² + 2 u(τ²). `more` has the interval that χ² gives at 95 %, exact
    where all points are alike: of few residuals it is far from symmetric, and to be preferred.
    """
    smooth, points = form.smooth, form.points
    assert smooth is not None
    spare, tau = max(smooth.spare, 1), smooth.scatter_mm
    device = float(np.mean(points.standard_u_mm**2))
    total = device + tau**2
    low = np.sqrt(max(tau**2 - 2.0 * device * np.sqrt(2.0 / spare), 0.0))
    high = np.sqrt(tau**2 + 2.0 * total * np.sqrt(2.0 / spare))
    u = float(max((tau - low) / 2.0, (high - tau) / 2.0, np.sqrt(total / (2.0 * spare))))
    interval = [np.sqrt(max(spare * total / chi2.ppf(p, spare) - device, 0.0)) for p in (0.975, 0.025)]
    more = {"low_mm": float(interval[0]), "high_mm": float(interval[1])}
    return FeatureError(
        feature=name,
        kind=ErrorKind.WAVINESS,
        value_mm=tau,
        standard_u_mm=u,
        points=points.readings,
        degrees_of_freedom=spare,
        more=more,
    )


KINDS: Final = {1: ErrorKind.ECCENTRICITY, 3: ErrorKind.LOBING}


def roundness_of(form: Form, name: str) -> tuple[FeatureError, ...]:
    """Amplitudes of the waves that the angles determine, as means over the feature; () where they determine none.

    The amplitude A of two fitted coefficients with uncertainties u₁, u₂ follows Rice's distribution, Rayleigh's where
    nothing is there: noise alone has a mean square of u₁² + u₂². That is taken out, a² = A² − u₁² − u₂², 0 where
    negative. u is that of the component along the wave and a quarter of what was taken out, without which ± 2 u would
    miss amplitudes of about 2 u too often. Value ± 2 u holds the true amplitude in 93 % of cases or more, of 0 to 10 u
    (simulated). `more` has the angle of the highest point from the zero of the spindle.
    """
    smooth = form.line if form.smooth is None else form.smooth
    first = len(smooth.coefficients) - 2 * len(form.waves)
    found = []
    for k, waves in enumerate(form.waves):
        pair = slice(first + 2 * k, first + 2 * k + 2)
        parts, covariance = smooth.coefficients[pair], smooth.covariance[pair, pair]
        amplitude = float(np.hypot(*parts))
        way = parts / max(amplitude, 1e-300)
        value = float(np.sqrt(max(amplitude**2 - float(np.trace(covariance)), 0.0)))
        u = float(np.sqrt(way @ covariance @ way)) + (amplitude - value) / 4.0
        more = {"highest_rad": float(np.arctan2(parts[1], parts[0])) / waves}
        found.append(
            FeatureError(
                feature=name,
                kind=KINDS[waves],
                value_mm=value,
                standard_u_mm=u,
                points=form.points.readings,
                degrees_of_freedom=form.degrees_of_freedom,
                more=more,
            )
        )
    return tuple(found)


def errors_of(points: SeenPoints, places: Mapping[str, FeaturePlace]) -> tuple[FeatureError, ...]:
    """The errors that the points determine, feature by feature in the order of `places`, then lengths between faces.

    Of the least-squares line through the errors e of a shaft or a cone (an arc: their mean):

        radius = e at the end near the chuck, taper = e at the free end − e near the chuck

    both of the whole feature, wherever on it the points lie; points of one place, or of less than a third of the
    feature, determine the mean error there, which is the radius, and no taper. Of a face the taper is e at the largest
    radius less that at the smallest. A length between two faces that follow each other along z is that of their z,
    n_z·e of the farther less n_z·e of the nearer, in the middle of their radii. Radius and taper of one feature err
    in opposite directions: `more` of the taper has their correlation.

    Uncertainties hold where points err independently: from the stated ones, from repeats that scatter by more, and from
    what the points deviate from the form by (`averaged`, `fitted`). With three points or fewer a deviation from the
    line is not seen. Nothing is raised: `undetermined` names what the points do not determine. Points of features
    without a place are left out.
    """
    forms = {name: form_of(averaged(points.of(name)), place) for name, place in _seen(points, places)}
    found: list[FeatureError] = []
    for name, form in forms.items():
        found += _line(form, places[name])
        found += straightness_of(form, name)
        found += roundness_of(form, name)
    return (*found, *_lengths(forms, places))


def _seen(points: SeenPoints, places: Mapping[str, FeaturePlace]) -> Iterator[tuple[str, FeaturePlace]]:
    there = set(points.feature)
    return ((name, place) for name, place in places.items() if name in there)


def _line(form: Form, place: FeaturePlace) -> Iterator[FeatureError]:
    """Radius and taper from the line."""
    low, high = form.whole_mm
    near = low if form.degree else float(form.along_mm.mean())
    rise = form.at(high) - form.at(low)
    if place.kind != "face":
        value, u = form.line.of(form.at(near))
        more = {"at_z_mm": near, "normal_x": float(form.points.normal[:, 0].mean())}
        yield _error(form, place, ErrorKind.RADIUS, value, u, more)
    if form.degree:
        value, u = form.line.of(rise)
        kind = ErrorKind.FACE_TAPER if place.kind == "face" else ErrorKind.SHAFT_TAPER
        shared = float(rise @ form.line.covariance @ form.at(near)) / (u * form.line.of(form.at(near))[1])
        more = {"over_mm": high - low} | ({} if place.kind == "face" else {"correlation_with_radius": shared})
        yield _error(form, place, kind, value, u, more)


def _error(
    form: Form, place: FeaturePlace, kind: ErrorKind, value: float, u: float, more: Mapping[str, float]
) -> FeatureError:
    return FeatureError(
        feature=place.name,
        kind=kind,
        value_mm=value,
        standard_u_mm=u,
        points=form.points.readings,
        degrees_of_freedom=form.degrees_of_freedom,
        more=more,
    )


def _lengths(forms: Mapping[str, Form], places: Mapping[str, FeaturePlace]) -> Iterator[FeatureError]:
    """Between faces that follow each other along z."""
    faces = sorted((name for name in forms if places[name].kind == "face"), key=lambda name: sum(places[name].z_mm))
    for nearer, farther in pairwise(faces):
        (value, u), (other, other_u) = (_along_z(forms[name]) for name in (farther, nearer))
        freedom = [f for f in (forms[name].degrees_of_freedom for name in (farther, nearer)) if f is not None]
        readings = forms[farther].points.readings + forms[nearer].points.readings
        yield FeatureError(
            feature=farther,
            kind=ErrorKind.LENGTH,
            value_mm=value - other,
            standard_u_mm=float(np.hypot(u, other_u)),
            points=readings,
            degrees_of_freedom=min(freedom) if freedom else None,
            other=nearer,
        )


def _along_z(form: Form) -> tuple[float, float]:
    """A face's error along z in the middle of its radii."""
    value, u = form.line.of(form.at(0.5 * sum(form.whole_mm)))
    n_z = float(form.points.normal[:, 1].mean())
    return n_z * value, abs(n_z) * u


def undetermined(points: SeenPoints, places: Mapping[str, FeaturePlace]) -> tuple[Finding, ...]:
    """Feature by feature which errors cannot be had from the points, why, and how many points could."""
    found: list[Finding] = []
    for name, place in places.items():
        of_it = points.of(name)
        if not len(of_it.feature):
            why = wording("'{feature}': it was not measured", feature=name)
            found.append(_note(name, why, wording("measure at least one point of it")))
            continue
        once = averaged(of_it)
        found += _of_straight(form_of(once, place), place) if place.kind in STRAIGHT else ()
        found += _around(once, form_of(once, place), name)
    return tuple(found)


def _of_straight(form: Form, place: FeaturePlace) -> Iterator[Finding]:
    along = "radius" if place.kind == "face" else "z"
    count = len(np.unique(np.round(form.along_mm, 6)))
    spans, whole = form.ends_mm[1] - form.ends_mm[0], form.whole_mm[1] - form.whole_mm[0]
    if not form.degree:
        kind = ErrorKind.FACE_TAPER if place.kind == "face" else ErrorKind.SHAFT_TAPER
        why = wording(
            "'{feature}': no {kind}; places in {along}: {count}, which span {spans:.0%} of it",
            feature=place.name,
            kind=str(kind),
            count=count,
            along=along,
            spans=spans / whole if whole else 0.0,
        )
        hint = wording("measure two places at least, which span {share:.0%} of the feature", share=SPAN)
        yield _note(place.name, why, hint)
    elif form.smooth is None:
        why = wording(
            "'{feature}': no straightness; {count} places in {along}", feature=place.name, count=count, along=along
        )
        hint = wording("measure {count} places: up to three waves along the feature", count=SMOOTH_PLACES)
        yield _note(place.name, why, hint)


def _around(points: Averaged, form: Form, name: str) -> Iterator[Finding]:
    """Angles that are known, more than one, and too few or too uneven for waves around the turn."""
    angles = np.mod(points.spindle_rad[~np.isnan(points.spindle_rad)], 2.0 * np.pi)
    different = len(np.unique(np.round(angles, 6)))
    lacking = [(n, needed) for n, needed in WAVES if n not in form.waves]
    if different > 1 and lacking:
        wave, needed = lacking[0]
        kind = ErrorKind.ECCENTRICITY if wave == 1 else ErrorKind.LOBING
        why = wording(
            "'{feature}': no {kind}; {count} angles of the part", feature=name, kind=str(kind), count=different
        )
        hint = wording("measure at {count} angles, evenly around the turn, in each place", count=needed)
        yield _note(name, why, hint)


def _note(feature: str, why: str, hint: str) -> Finding:
    return Finding(Severity.NOTE, Code.DIA_POINTS, why, hint, values={"feature": feature})
