"""Errors of features from points of their surfaces [4773 §4.2 a–d, f]."""

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from trueloop.diagnosis.features.averaged import averaged
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError
from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.form import Form, form_of
from trueloop.diagnosis.features.roundness import roundness_of
from trueloop.diagnosis.features.seen_points import SeenPoints
from trueloop.diagnosis.features.straightness import straightness_of


def errors_of(points: SeenPoints, places: Mapping[str, FeaturePlace]) -> tuple[FeatureError, ...]:
    """What the points determine, feature by feature in the order of `places`, then lengths between faces.

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
    return FeatureError(place.name, kind, value, u, form.points.readings, form.degrees_of_freedom, more=more)


def _lengths(forms: Mapping[str, Form], places: Mapping[str, FeaturePlace]) -> Iterator[FeatureError]:
    """Between faces that follow each other along z."""
    faces = sorted((name for name in forms if places[name].kind == "face"), key=lambda name: sum(places[name].z_mm))
    for nearer, farther in pairwise(faces):
        (value, u), (other, other_u) = (_along_z(forms[name]) for name in (farther, nearer))
        freedom = [f for f in (forms[name].degrees_of_freedom for name in (farther, nearer)) if f is not None]
        readings = forms[farther].points.readings + forms[nearer].points.readings
        yield FeatureError(
            farther,
            ErrorKind.LENGTH,
            value - other,
            float(np.hypot(u, other_u)),
            readings,
            min(freedom) if freedom else None,
            nearer,
        )


def _along_z(form: Form) -> tuple[float, float]:
    """A face's error along z in the middle of its radii."""
    value, u = form.line.of(form.at(0.5 * sum(form.whole_mm)))
    n_z = float(form.points.normal[:, 1].mean())
    return n_z * value, abs(n_z) * u
