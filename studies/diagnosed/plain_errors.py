"""Feature errors of simulated parts as plain means and differences, for who needs no more than that."""

from collections.abc import Iterator, Mapping

import numpy as np

from studies.diagnosed.part_types import Gauged
from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, FeaturePlace


def plain_errors(
    places: Mapping[str, FeaturePlace], points: Gauged, error_mm: Array, standard_u_mm: float
) -> tuple[FeatureError, ...]:
    """Radius by the ring near the chuck, tapers by ends, lengths from the face nearest to the chuck, form by waves."""
    found: list[FeatureError] = []
    for name, place in places.items():
        rows = points.is_of([name]).astype(bool)
        at, angle, error = points.at_mm[rows], points.angle_rad[rows], error_mm[rows]
        found += _shaft(name, at, angle, error, standard_u_mm) if place.kind == "shaft" else []
        found += _face(name, at, error, standard_u_mm) if place.kind == "face" else []
    return (*found, *_lengths(places, points, error_mm, standard_u_mm))


def _shaft(name: str, at: Array, angle: Array, error: Array, u: float) -> list[FeatureError]:
    near = at[:, 1] == at[:, 1].min()
    line = angle == 0.0
    z, e = at[line, 1], error[line]
    count = int(near.sum())
    bend = e - np.polynomial.Polynomial.fit(z, e, 1)(z)
    smooth = np.polynomial.Polynomial.fit(z, e, 3)
    waves = [2.0 * float(np.abs(np.mean(error[near] * np.exp(1j * k * angle[near])))) for k in (1, 3)]
    end, u_wave = int(line.sum()), u * float(np.sqrt(2.0 / count))
    return [
        FeatureError(name, ErrorKind.RADIUS, float(error[near].mean()), u / float(np.sqrt(count)), count),
        FeatureError(name, ErrorKind.SHAFT_TAPER, float(e[-1] - e[0]), u * float(np.sqrt(2.0)), 2),
        FeatureError(name, ErrorKind.STRAIGHTNESS, float(np.ptp(smooth(z) - (e - bend))), u, end),
        FeatureError(name, ErrorKind.WAVINESS, _without(e - smooth(z), u), u, end),
        FeatureError(name, ErrorKind.ECCENTRICITY, waves[0], u_wave, count),
        FeatureError(name, ErrorKind.LOBING, waves[1], u_wave, count),
    ]  # fmt: skip


def _without(rest: Array, u: float) -> float:
    """Root mean square of what a polynomial of four coefficients leaves, the noise taken out."""
    return float(np.sqrt(max(float(np.sum(rest**2)) / (len(rest) - 4) - u**2, 0.0)))


def _face(name: str, at: Array, error: Array, u: float) -> list[FeatureError]:
    outer, inner = int(np.argmax(at[:, 0])), int(np.argmin(at[:, 0]))
    return [FeatureError(name, ErrorKind.FACE_TAPER, float(error[outer] - error[inner]), u * float(np.sqrt(2.0)), 2)]


def _lengths(places: Mapping[str, FeaturePlace], points: Gauged, error: Array, u: float) -> Iterator[FeatureError]:
    faces = sorted((place for place in places.values() if place.kind == "face"), key=lambda place: place.z_mm[0])
    means = {place.name: error[points.is_of([place.name]).astype(bool)] for place in faces}
    nearest = faces[0].name
    for place in faces[1:]:
        value = float(means[place.name].mean() - means[nearest].mean())
        u_length = u * float(np.sqrt(1 / len(means[place.name]) + 1 / len(means[nearest])))
        yield FeatureError(place.name, ErrorKind.LENGTH, value, u_length, len(means[place.name]), None, nearest)
