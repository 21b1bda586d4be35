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
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.special import chdtrc

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.domain.option import Limits, allowed_by
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.intersection import sign_changes
from trueloop.geometry.profile import FACES_Z, Profile
from trueloop.turned.fit.chain_fit import ROUNDING_MM
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.of_this_part import check_places, check_sizes
from trueloop.turned.touches.error_vectors import Seen
from trueloop.turned.touches.touches import ON_PROFILE_MM, Gauging
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

PLACED_BY_HAND_MM: Final = 0.3
"""Standard uncertainty of the z at which a gauge is held by hand: within half a millimetre, any place alike."""
TAPER: Final = 50e-6
"""Taper of a part, one standard deviation, radius over length: 10 µm on the diameter in 100 mm. Acceptance tests of
lathes allow 20 µm on the diameter in 300 mm when new and warm (ISO 1708, ISO 13041; from memory)."""
ROUND: Final = 33
"""Places on an arc over which its radius is taken."""


@dataclass(frozen=True)
class RepeatedReading:
    """Readings of one characteristic in one place: their mean deviation and its standard uncertainty; mm or degrees."""

    first: MatchedReading
    deviation: float
    standard_u: float
    count: int


def repeated(profile: Profile, readings: Sequence[MatchedReading], gauging: Gauging) -> tuple[RepeatedReading, ...]:
    """Returns readings of the `CORRECTED` kinds, those of one characteristic together.

    What a gauge repeats to is the spread of its repeats, pooled over all characteristics of one unit and one stated
    uncertainty, as another gauge has another: it is in the uncertainty of every such reading, by √n of n repeats,
    beside what is stated for it (`readings_u_mm` where nothing is; of an angle, that over 10 mm). Raises MSR errors
    for what cannot be right.
    """
    check_places(readings)
    nominal = [nominal_of(profile, reading) for reading in readings]
    check_sizes(readings, nominal, gauging.allowance_mm)
    expected = {id(reading): value for reading, value in zip(readings, nominal, strict=True)}
    groups = [
        [(reading, reading.reading.actual - expected[id(reading)]) for reading in group]
        for group in in_one_place(readings)
    ]
    alike: defaultdict[tuple[str, float], list[list[tuple[MatchedReading, float]]]] = defaultdict(list)
    kinds = [_gauge(group, gauging.readings_u_mm) for group in groups]
    for kind, group in zip(kinds, groups, strict=True):
        alike[kind].append(group)
    spread = {kind: _pooled_spread(of) for kind, of in alike.items()}
    return tuple(_together(group, spread[kind], kind[1]) for kind, group in zip(kinds, groups, strict=True))


def _gauge(group: Sequence[tuple[MatchedReading, float]], assumed_u_mm: float) -> tuple[str, float]:
    """Returns the unit and the stated uncertainty of readings, which tell gauges apart."""
    return group[0][0].reading.quantity.unit, stated_u([reading for reading, _ in group], assumed_u_mm)


def in_one_place(readings: Sequence[MatchedReading]) -> list[list[MatchedReading]]:
    """Returns readings of one characteristic in one place together, in the order of the first of each."""
    groups: defaultdict[tuple[object, ...], list[MatchedReading]] = defaultdict(list)
    for reading in readings:
        groups[reading.feature_index, reading.other_index, reading.reading.quantity, reading.reading.place_mm].append(
            reading
        )
    return list(groups.values())


def _pooled_spread(groups: Sequence[Sequence[tuple[MatchedReading, float]]]) -> float:
    """Returns the standard deviation of a single reading; 0 where nothing was read twice."""
    deviations = [np.array([value for _, value in group]) for group in groups]
    spare = sum(len(values) - 1 for values in deviations)
    squares = math.fsum(float(np.sum((values - np.mean(values)) ** 2)) for values in deviations)
    return math.sqrt(squares / spare) if spare else 0.0


def _together(group: Sequence[tuple[MatchedReading, float]], spread: float, stated: float) -> RepeatedReading:
    mean = math.fsum(value for _, value in group) / len(group)
    return RepeatedReading(group[0][0], mean, math.hypot(stated, spread / math.sqrt(len(group))), len(group))


def stated_u(group: Sequence[MatchedReading], assumed_u_mm: float) -> float:
    """Returns the largest standard uncertainty that readings of one kind state, mm or degrees; else the assumed one."""
    assumed = assumed_u_mm if group[0].reading.quantity.unit == "mm" else math.degrees(assumed_u_mm / 10.0)
    return max(assumed if reading.reading.standard_u is None else reading.reading.standard_u for reading in group)


def seen_by(profile: Profile, repeated: RepeatedReading, datum: int | None) -> Seen:
    """Returns the functional of readings of one characteristic; `datum` is the face that is the part's zero."""
    index, reading = repeated.first.feature_index, repeated.first.reading
    feature, name = profile.features[index], reading.characteristic
    if reading.quantity is Quantity.LENGTH:
        return _length(profile, repeated, datum)
    if reading.quantity is Quantity.ANGLE:
        sign, length = math.copysign(1.0, tilt_rad(feature, reading)), feature.length_mm
        ends = ((index, 0.0, -sign / length), (index, length, sign / length))
        turned = Seen.at(name, ends, math.radians(repeated.deviation), math.radians(repeated.standard_u))
        return replace(turned, unit="rad")
    if reading.quantity is Quantity.RADIUS and isinstance(feature, Arc):
        s = np.linspace(0.0, feature.length_mm, ROUND)
        side = math.copysign(1.0, float(feature.curvature_per_mm(0.0)))
        terms = np.column_stack([np.full(ROUND, side), feature.outward_normal(s)])
        weights = np.linalg.pinv(terms, rcond=1e-9)[0]
        places = tuple((index, float(along), float(weight)) for along, weight in zip(s, weights, strict=True))
        return Seen.at(name, places, repeated.deviation, repeated.standard_u)
    at = arc_length_of(feature, reading)
    n_x, n_z = (float(component) for component in feature.outward_normal(at))
    of_error = n_x * (0.5 if reading.quantity is Quantity.DIAMETER else 1.0)
    place_u_mm = abs(n_z) * PLACED_BY_HAND_MM if len(reading.place_mm) == 1 else 0.0
    if not reading.place_mm:
        place_u_mm = TAPER * feature.length_mm / math.sqrt(12.0)
    return Seen.at(
        name, ((index, at, 1.0),), repeated.deviation * of_error, math.hypot(repeated.standard_u * of_error, place_u_mm)
    )


def _length(profile: Profile, reading: RepeatedReading, datum: int | None) -> Seen:
    """Returns the face beyond less the other one; the part's zero does not move."""
    index, other = reading.first.feature_index, reading.first.other_index
    other = datum if other is None else other
    z_mm, n_z, middle = _face(profile, index)
    other_z_mm, other_n_z, other_middle = (0.0, 0.0, 0.0) if other is None else _face(profile, other)
    beyond = math.copysign(1.0, z_mm - other_z_mm)
    places = [(index, middle, beyond * n_z)]
    if other is not None and other != index:
        places.append((other, other_middle, -beyond * other_n_z))
    return Seen.at(reading.first.reading.characteristic, tuple(places), reading.deviation, reading.standard_u)


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
    lengths = [reading for reading in readings if reading.reading.quantity is Quantity.LENGTH]
    if not lengths:
        return None
    if at_zero := profile.faces_at(0.0):
        return at_zero[-1]
    if any(length.other_index is None for length in lengths):
        return None
    counted = Counter(length.other_index for length in lengths if length.other_index is not None)
    return max(counted, key=lambda k: (counted[k], k))


def corrected(readings: Sequence[MatchedReading]) -> tuple[MatchedReading, ...]:
    """Returns those from which errors of the profile follow."""
    return tuple(reading for reading in readings if reading.reading.quantity in CORRECTED)


CORRECTED: Final = (Quantity.DIAMETER, Quantity.RADIUS, Quantity.LENGTH, Quantity.ANGLE)
"""The kinds of reading from which errors of the profile follow; from others none does."""
FACES_X: Final = 0.5
"""A diameter is read where the surface faces the spindle axis by 30° at least: a diameter grows by 2/n_x of the error,
and flatter surfaces no gauge finds the place on."""


def nominal_of(profile: Profile, match: MatchedReading) -> float:
    """Returns the profile's nominal of a reading that is `CORRECTED`. Raises MSR-KIND and MSR-PLACE."""
    feature, reading = profile.features[match.feature_index], match.reading
    if reading.quantity is Quantity.LENGTH:
        other = None if match.other_index is None else profile.features[match.other_index]
        return abs(face_z_mm(feature, reading) - (0.0 if other is None else face_z_mm(other, reading)))
    if reading.quantity is Quantity.ANGLE:
        return math.degrees(abs(tilt_rad(feature, reading)))
    if reading.quantity is Quantity.RADIUS and isinstance(feature, Arc):
        return feature.radius_mm
    radius = float(feature.point_mm(arc_length_of(feature, reading))[0])
    return radius if reading.quantity is Quantity.RADIUS else 2.0 * radius


def arc_length_of(feature: Feature, reading: Reading) -> float:
    """Returns where along its feature a diameter was read; without a place, the middle of a cylinder.

    Raises MSR-PLACE where the place is not on the feature, or is not given and the diameter is not the same all along;
    MSR-KIND where the surface faces z.
    """
    if not reading.place_mm:
        return _anywhere(feature, reading)
    z_mm = reading.place_mm[-1]
    found = _at_place(feature, reading.place_mm) if len(reading.place_mm) > 1 else _at_z(feature, z_mm)
    if len(found) != 1:
        ends, x_mm = sorted((feature.start_mm[1], feature.end_mm[1])), reading.place_mm[0]
        if len(reading.place_mm) > 1 and (hits := _at_z(feature, z_mm)):
            radii = " and ".join(f"{float(feature.point_mm(hit)[0]):.4g}" for hit in hits)
            raise _misplaced(
                reading,
                f"x {x_mm:g} mm, z {z_mm:g} mm is not on {feature.name!r}, whose radius there is {radii} mm",
                "x_mm is the radius of the place, positive on either side of the axis; leave it out where z is there "
                "once",
            )
        raise _misplaced(
            reading,
            f"z {z_mm:g} mm is at {len(found)} places of {feature.name!r}, which goes from {ends[0]:g} to "
            f"{ends[1]:g} mm",
            "z counts from the part's zero, away from the chuck; give x_mm too, a radius, where z is there twice",
        )
    n_x = abs(float(feature.outward_normal(found[0])[0]))
    if n_x < FACES_X:
        faces = f"its surface faces z there (n_x {n_x:.2f}, at least {FACES_X})"
        raise _unseen(feature, reading, faces, "read a diameter where the surface faces the axis; of a face, a length")
    return found[0]


def face_z_mm(feature: Feature, reading: Reading) -> float:
    """Returns z of a face's middle. Raises MSR-KIND for other features."""
    if not isinstance(feature, Line) or abs(float(feature.outward_normal(0.0)[1])) < FACES_Z:
        hint = "name the face at which the length ends, and in `from` the one where it begins (empty: the part's zero)"
        raise _unseen(feature, reading, "it is no face", hint)
    return float(feature.point_mm(0.5 * feature.length_mm)[1])


def tilt_rad(feature: Feature, reading: Reading) -> float:
    """Returns the angle of a line from the spindle axis, towards +x, from −π/2 to π/2. Raises MSR-KIND for an arc."""
    if not isinstance(feature, Line):
        raise _unseen(feature, reading, "it is curved", "read a diameter at a z, or an arc's radius")
    t_x, t_z = (float(component) for component in feature.tangent(0.0))
    return math.atan2(t_x, t_z) if t_z >= 0.0 else math.atan2(-t_x, -t_z)


def _anywhere(feature: Feature, reading: Reading) -> float:
    if not isinstance(feature, Line) or abs(feature.end_mm[0] - feature.start_mm[0]) > 1e-6:
        raise _misplaced(
            reading,
            f"the place is empty, and the diameter of {feature.name!r} changes from {2 * feature.start_mm[0]:.4g} to "
            f"{2 * feature.end_mm[0]:.4g} mm",
            "give z_mm, where it was read",
        )
    return 0.5 * feature.length_mm


def _at_place(feature: Feature, place_mm: tuple[float, ...]) -> list[float]:
    s, off = (float(value) for value in feature.locate((place_mm[0], place_mm[-1])))
    inside = -ROUNDING_MM <= s <= feature.length_mm + ROUNDING_MM and abs(off) <= ON_PROFILE_MM
    return [min(max(s, 0.0), feature.length_mm)] if inside else []


def _at_z(feature: Feature, z_mm: float) -> list[float]:
    """Returns the arc lengths at which a feature has this z, its ends with `ROUNDING_MM`."""
    if isinstance(feature, Curve):
        at = sign_changes(feature, lambda points: points[:, 1] - z_mm)
        places = feature.point_mm(at) if len(at) else np.array([feature.start_mm, feature.end_mm])
        return [s for x, z in places if abs(z - z_mm) <= ROUNDING_MM for s in _at_place(feature, (x, z))]
    if isinstance(feature, Arc):
        (x0, z0), radius = feature.centre_mm, feature.radius_mm
        height = math.sqrt(max(radius**2 - (z_mm - z0) ** 2, 0.0))
        points = [] if abs(z_mm - z0) > radius else sorted({(x0 - height, z_mm), (x0 + height, z_mm)})
        return [s for point in points for s in _at_place(feature, point)]
    rise = feature.end_mm[1] - feature.start_mm[1]
    if abs(rise) < 1e-9:
        return []
    s = (z_mm - feature.start_mm[1]) / rise * feature.length_mm
    return [float(np.clip(s, 0.0, feature.length_mm))] if -ROUNDING_MM <= s <= feature.length_mm + ROUNDING_MM else []


def _misplaced(reading: Reading, why: str, hint: str) -> TrueloopError:
    return Code.MSR_PLACE.refusal(
        f"{reading.characteristic!r}: {why}",
        hint=hint,
        place=Place(line=reading.line),
        values={"feature": reading.feature},
    )


def _unseen(feature: Feature, reading: Reading, why: str, hint: str) -> TrueloopError:
    return Code.MSR_KIND.refusal(
        f"{reading.characteristic!r}, {reading.actual:g} {reading.quantity.unit}: {feature.name!r} has no "
        f"{reading.quantity}: {why}",
        hint=hint,
        place=Place(line=reading.line),
        values={"feature": feature.name, "quantity": str(reading.quantity)},
    )


ROUNDED: Final = {"mm": 0.001, "deg": 0.01}
"""Nominal values differ by no more where one of them was rounded."""
EXACT: Final = 3e-4
"""mm or degrees: what rounding to five decimals of an inch makes of an exact value."""
SHOWN: Final = 4


def other_nominals(profile: Profile, readings: Sequence[MatchedReading]) -> tuple[Finding, ...]:
    """Returns a finding where the file's nominal values differ from the profile's: its deviations are others.

    It is an error where all actual values are the profile's nominal ones instead: the two are exchanged.
    """
    found: list[tuple[Reading, float, float]] = []
    exchanged = 0
    for one in corrected(readings):
        stated, expected = one.reading.nominal, _nominal(profile, one)
        if stated is None or expected is None:
            continue
        exchanged += abs(one.reading.actual - expected) <= EXACT
        if abs(stated - expected) > 1.000001 * ROUNDED[one.reading.quantity.unit]:
            found.append((one.reading, stated, expected))
    if not found:
        return ()
    shown = ", ".join(
        f"{reading.characteristic!r} {stated:.4f} and {expected:.4f} {reading.quantity.unit}"
        for reading, stated, expected in found[:SHOWN]
    )
    more = f", and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    first, stated, expected = found[0]
    other = f"{len(found)} readings have another nominal value in the file than on the part's contour: {shown}{more}; "
    all_exchanged = 1 < len(found) == exchanged == len(corrected(readings))
    finding = Finding(
        Severity.ERROR if all_exchanged else Severity.WARNING,
        Code.MSR_NOMINAL,
        f"{other}the actual ones are the contour's"
        if all_exchanged
        else f"{other}a correction counts from the contour's",
        "are nominal and actual values exchanged? Of a table name the columns: `trueloop measure map FILE "
        "--column nominal=HEADING --column actual=HEADING`"
        if all_exchanged
        else "where the file's is the size to aim at, as the middle of limits: state it in the features of [part]",
        Place(line=first.line),
        values={"feature": first.feature, "actual": stated, "nominal": expected},
    )
    return (finding,)


def _nominal(profile: Profile, reading: MatchedReading) -> float | None:
    """Returns the profile's; None where the reading has none there, which is refused when it is to be used."""
    try:
        return nominal_of(profile, reading)
    except TrueloopError:
        return None


IMPROBABLE: Final = 1e-4
"""Readings that are so far apart less often than this, by their own uncertainty, contradict each other."""


def check_repeats(
    profile: Profile, readings: Sequence[MatchedReading], gauging: Gauging, limits: Limits
) -> tuple[str, ...]:
    """Returns notes on contradictory readings of one place; ±U holds their spread. Raises CMP-SCATTER beyond it."""
    notes = []
    for group in in_one_place(corrected(readings)):
        actual = np.array([reading.reading.actual for reading in group])
        u = stated_u(group, gauging.readings_u_mm)
        spread = float(np.std(actual, ddof=1)) if len(group) > 1 else 0.0
        if not spread or chdtrc(len(group) - 1, (len(group) - 1) * (spread / u) ** 2) > IMPROBABLE:
            continue
        said, first = _words(group, actual, u), group[0]
        scatter_mm = spread * _along_normal(profile, first)
        if scatter_mm > limits.scatter_mm:
            raise Code.CMP_SCATTER.refusal(
                wording(
                    "{said}: {scatter} along the normal (one standard deviation); the limit is {limit}",
                    said=said,
                    scatter=Um(scatter_mm),
                    limit=Um(limits.scatter_mm),
                ),
                hint="read that place again and leave the wrong value out, or give each place its own z_mm",
                override=allowed_by("scatter_mm"),
                place=Place(line=group[int(np.argmax(np.abs(actual - np.median(actual))))].reading.line),
                values={"scatter_um": scatter_mm * UM_PER_MM, "limit_um": limits.scatter_mm * UM_PER_MM},
            )
        notes.append(wording("{said}: their mean is taken, and their spread is part of each ±U.", said=said))
    return tuple(notes)


def _words(group: Sequence[MatchedReading], actual: Array, u: float) -> str:
    reading = group[0].reading
    size = f"{u * UM_PER_MM:.1f} µm" if reading.quantity.unit == "mm" else f"{u:.4f}°"
    unit = "mm" if reading.quantity.unit == "mm" else "°"
    return wording(
        "{n} readings of one place, {name}, from {least:.4f} to {most:.4f} {unit}, are further apart than their "
        "standard uncertainty of {u} allows",
        n=len(group),
        name=repr(reading.characteristic),
        least=float(actual.min()),
        most=float(actual.max()),
        unit=unit,
        u=size,
    )


def _along_normal(profile: Profile, reading: MatchedReading) -> float:
    """Returns the displacement of the surface per unit of a reading, mm; of an angle at the ends of its line."""
    feature, quantity = profile.features[reading.feature_index], reading.reading.quantity
    if quantity is Quantity.ANGLE:
        return math.radians(feature.length_mm / 2.0)
    if quantity is not Quantity.DIAMETER:
        return 1.0
    return abs(float(feature.outward_normal(arc_length_of(feature, reading.reading))[0])) / 2.0
