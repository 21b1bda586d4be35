"""Readings as functionals of the error curves, and as errors at places where one reading determines one.

With the error e along the outward normal n, to first order in e:

- A diameter at z sees the surface at that z: it deviates by 2e/n_x. Exact on cylinders and cones; on an arc of radius R
  it neglects e²/R. The gauge must touch at that z alone: on a cone, balls or edges, no flat anvils. A hand finds the z
  to `PLACED_BY_HAND_MM`. Without a z it is of an unknown place of a cylinder.
- A radius of a line is half of that. The radius of an arc is that of a circle through its error: the constant of
  e = δR·side + a·n_x + b·n_z by least squares, for the circle's centre is the reading's own.
- A length moves with both its faces: by (e·n_z) of the one beyond less that of the other. Lengths say nothing of where
  z is counted from. A face is the datum, and its error is zero by definition: the one at the part's zero, else the one
  that most lengths count from. Lengths from the part's zero count from it.
- An angle turns with the slope of e.
- Runout and form repeat with the turn of the part: no error of its profile follows.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.domain.characteristic import Quantity
from trueloop.geometry.feature import Arc
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matched import MatchedReading
from trueloop.turned.readings.nominal import CORRECTED, FACES_Z, arc_length_of, nominal_of, tilt_rad
from trueloop.turned.readings.plausibility import check_places, check_sizes
from trueloop.turned.touches.seen import Seen
from trueloop.turned.touches.touches import Gauging

PLACED_BY_HAND_MM: Final = 0.3
"""Standard uncertainty of the z at which a gauge is held by hand: within half a millimetre, any place alike."""
TAPER: Final = 50e-6
"""Taper of a part, one standard deviation, radius over length: 10 µm on the diameter in 100 mm. Acceptance tests of
lathes allow 20 µm on the diameter in 300 mm when new and warm (ISO 1708, ISO 13041; from memory)."""
ROUND: Final = 33
"""Places on an arc over which its radius is taken."""
AT_ZERO_MM: Final = 1e-6


@dataclass(frozen=True)
class Repeated:
    """Readings of one characteristic in one place: their mean deviation and its standard uncertainty; mm or degrees."""

    first: MatchedReading
    deviation: float
    standard_u: float
    count: int


def repeated(profile: Profile, readings: Sequence[MatchedReading], gauging: Gauging) -> tuple[Repeated, ...]:
    """Returns readings of the `CORRECTED` kinds, those of one characteristic together.

    What a gauge repeats to is the spread of its repeats, pooled over all characteristics of one unit: it is in the
    uncertainty of every reading, by √n of n repeats, beside what is stated for it (`readings_u_mm` where nothing is;
    of an angle, that over 10 mm). Raises MSR errors for what cannot be right.
    """
    check_places(readings)
    nominal = [nominal_of(profile, one) for one in readings]
    check_sizes(readings, nominal, gauging.allowance_mm)
    groups: defaultdict[tuple[object, ...], list[tuple[MatchedReading, float]]] = defaultdict(list)
    for one, expected in zip(readings, nominal, strict=True):
        place = (one.feature_index, one.other_index, one.reading.quantity, one.reading.place_mm)
        groups[place].append((one, one.reading.actual - expected))
    spread = {unit: _pooled_spread(unit, list(groups.values())) for unit in ("mm", "deg")}
    return tuple(_together(group, spread, gauging.readings_u_mm) for group in groups.values())


def _pooled_spread(unit: str, groups: Sequence[Sequence[tuple[MatchedReading, float]]]) -> float:
    """Returns the standard deviation of a single reading; 0 where nothing was read twice."""
    deviations = [np.array([value for _, value in g]) for g in groups if g[0][0].reading.quantity.unit == unit]
    spare = sum(len(values) - 1 for values in deviations)
    squares = math.fsum(float(np.sum((values - np.mean(values)) ** 2)) for values in deviations)
    return math.sqrt(squares / spare) if spare else 0.0


def _together(group: Sequence[tuple[MatchedReading, float]], spread: dict[str, float], assumed_u_mm: float) -> Repeated:
    unit = group[0][0].reading.quantity.unit
    assumed = assumed_u_mm if unit == "mm" else math.degrees(assumed_u_mm / 10.0)
    stated = max(assumed if one.reading.standard_u is None else one.reading.standard_u for one, _ in group)
    mean = math.fsum(value for _, value in group) / len(group)
    return Repeated(group[0][0], mean, math.hypot(stated, spread[unit] / math.sqrt(len(group))), len(group))


def seen_by(profile: Profile, one: Repeated, datum: int | None) -> Seen:
    """Returns the functional of readings of one characteristic; `datum` is the face that lengths from the part's zero
    count from.
    """
    index, reading = one.first.feature_index, one.first.reading
    feature, name = profile.features[index], reading.characteristic
    if reading.quantity is Quantity.LENGTH:
        return _length(profile, one, datum)
    if reading.quantity is Quantity.ANGLE:
        sign, length = math.copysign(1.0, tilt_rad(feature, reading)), feature.length_mm
        ends = ((index, 0.0, -sign / length), (index, length, sign / length))
        return Seen.at(name, ends, math.radians(one.deviation), math.radians(one.standard_u))
    if reading.quantity is Quantity.RADIUS and isinstance(feature, Arc):
        s = np.linspace(0.0, feature.length_mm, ROUND)
        side = math.copysign(1.0, float(feature.curvature_per_mm(0.0)))
        terms = np.column_stack([np.full(ROUND, side), feature.outward_normal(s)])
        weights = np.linalg.pinv(terms, rcond=1e-9)[0]
        places = tuple((index, float(along), float(weight)) for along, weight in zip(s, weights, strict=True))
        return Seen.at(name, places, one.deviation, one.standard_u)
    at = arc_length_of(feature, reading)
    n_x, n_z = (float(component) for component in feature.outward_normal(at))
    of_error = n_x * (0.5 if reading.quantity is Quantity.DIAMETER else 1.0)
    place_u_mm = abs(n_z) * PLACED_BY_HAND_MM if len(reading.place_mm) == 1 else 0.0
    if not reading.place_mm:
        place_u_mm = TAPER * feature.length_mm / math.sqrt(12.0)
    return Seen.at(
        name, ((index, at, 1.0),), one.deviation * of_error, math.hypot(one.standard_u * of_error, place_u_mm)
    )


def _length(profile: Profile, one: Repeated, datum: int | None) -> Seen:
    """Returns the face beyond less the other one; the part's zero does not move."""
    index, other = one.first.feature_index, one.first.other_index
    other = datum if other is None else other
    z_mm, n_z, middle = _face(profile, index)
    other_z_mm, other_n_z, other_middle = (0.0, 0.0, 0.0) if other is None else _face(profile, other)
    beyond = math.copysign(1.0, z_mm - other_z_mm)
    places = [(index, middle, beyond * n_z)]
    if other is not None and other != index:
        places.append((other, other_middle, -beyond * other_n_z))
    return Seen.at(one.first.reading.characteristic, tuple(places), one.deviation, one.standard_u)


def _face(profile: Profile, index: int) -> tuple[float, float, float]:
    """Returns z, n_z and arc length of the middle of a face."""
    feature = profile.features[index]
    s = 0.5 * feature.length_mm
    return float(feature.point_mm(s)[1]), float(feature.outward_normal(s)[1]), s


def datum_of(profile: Profile, readings: Sequence[MatchedReading]) -> int | None:
    """Returns the face whose error is zero by definition: the one at the part's zero, else the one most lengths count
    from.

    None without lengths, and where lengths count from a zero at which the profile has no face.
    """
    lengths = [one for one in readings if one.reading.quantity is Quantity.LENGTH]
    if not lengths:
        return None
    faces = [k for k, feature in enumerate(profile.features) if abs(float(feature.outward_normal(0.0)[1])) > FACES_Z]
    at_zero = [k for k in faces if abs(_face(profile, k)[0]) < AT_ZERO_MM]
    if at_zero:
        return at_zero[-1]
    if any(one.other_index is None for one in lengths):
        return None
    counted = Counter(one.other_index for one in lengths if one.other_index is not None)
    return max(counted, key=lambda k: (counted[k], k))


def corrected(readings: Sequence[MatchedReading]) -> tuple[MatchedReading, ...]:
    """Returns those from which errors of the profile follow."""
    return tuple(one for one in readings if one.reading.quantity in CORRECTED)
