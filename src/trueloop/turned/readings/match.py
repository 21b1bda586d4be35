"""An inspection on a turned profile: every value to a feature, by name first, then by geometry; nothing is guessed.

A name is compared without case, blanks and signs, after the user's own list of names. A named feature whose size is
another is not a match. By geometry a size must be that of one feature, or pair of faces (`sizes.py`); where two fit,
none is taken and both are named.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.geometry.feature import Feature, Line, distance_mm
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matches import Axis, By, Left, MatchedReading, MatchedTouch, Matches, feature_named
from trueloop.turned.readings.points import along_and_off, match_points
from trueloop.turned.readings.sizes import (
    Candidate,
    axial_mm,
    candidates,
    differs_from,
    is_face,
    on_other_side,
    size_of,
    within_of,
)
from trueloop.turned.touches.touches import CREDIBLE_ERROR_MM, ON_PROFILE_MM

Outcome: TypeAlias = MatchedReading | MatchedTouch | Left

NO_ERRORS: Final = {
    Quantity.RUNOUT: "runout repeats with the turn of the part: no error of its profile",
    Quantity.FORM: "form is no error of one place of the profile",
    Quantity.POSITION: "a coordinate is no size; only that of a face along the axis is used, where the face is named",
    Quantity.OTHER: "what it is the size of is not known: a column of quantities, the heading of its values or its "
    "name says so, as `Ø`, `Diameter`, `Length`, or a mapping",
}
FROM: Final = " from "
CENTRED_MM: Final = 1.0
"""A circle whose centre is further from the axis is not a section of a turned part."""
ROUND: Final = (Quantity.DIAMETER, Quantity.RADIUS)
FACTORS: Final = (
    (2.0, ROUND, "a radius among diameters?"),
    (0.5, ROUND, "a diameter among radii?"),
    (0.5, (Quantity.ANGLE,), "the included angle of a cone? An angle is counted between surface and axis"),
)
"""What would explain that a size fits no feature: the factor by which it fits, of which quantities, the question."""


def match_inspection(
    profile: Profile, inspection: Inspection, names: Mapping[str, str] | None = None, axis: Axis | None = None
) -> Matches:
    """Matches all values of an inspection with a profile. `names`: the profile's name of a feature, by that in the
    file.

    `axis` is that of the inspection's frame along the spindle; None: found, z where that fits.
    """
    names = names or {}
    points = match_points(profile, inspection, names, axis)
    along = points.axis or axis or "z"
    found: list[Outcome] = [
        _reading(profile, _named(profile, reading, names), inspection, along) for reading in inspection.readings
    ]
    found += [_touch(profile, touch, names, inspection.ball_radius_mm) for touch in inspection.touches]
    return Matches(
        tuple(one for one in found if isinstance(one, MatchedReading)),
        (*(one for one in found if isinstance(one, MatchedTouch)), *points.touches),
        (*(one for one in found if isinstance(one, Left)), *points.left),
        points.axis,
    )


def _named(profile: Profile, reading: Reading, names: Mapping[str, str]) -> Reading:
    """Returns the reading with the profile's names of its features, where the user's list has them."""
    listed = names.get(reading.characteristic) or names.get(reading.feature)
    feature, other = features_listed(profile, listed) if listed else (reading.feature, "")
    return replace(reading, feature=feature, other=other or names.get(reading.other, reading.other))


def features_listed(profile: Profile, listed: str) -> tuple[str, str]:
    """Returns the meaning of a listed name: its feature; `A from B`: a length of A, which counts from B."""
    feature, between, other = listed.partition(FROM)
    return (feature, other) if between and feature_named(profile, listed) is None else (listed, "")


def _reading(profile: Profile, reading: Reading, inspection: Inspection, along: Axis) -> Outcome:
    """Returns a match, or why there is none."""
    off_mm = 0.0
    if len(reading.place_mm) == 3:
        x, y, z = reading.place_mm
        at_mm, off_mm = along_and_off((x, y, z), along)
        reading = replace(reading, place_mm=(at_mm,) if inspection.frame == "part" else ())
    index = feature_named(profile, reading.feature or reading.characteristic)
    if reading.quantity in NO_ERRORS:
        return _no_size(profile, reading, index, along)
    if off_mm > CENTRED_MM:
        return Left(reading, f"its centre is {off_mm:.3f} mm off the axis: no section of the turned part", (), False)
    if index is None:
        return _by_geometry(profile, reading, candidates(profile, reading))
    if reading.quantity is Quantity.LENGTH:
        return _named_length(profile, reading, index)
    return _by_name(profile, reading, index)


def _no_size(profile: Profile, reading: Reading, index: int | None, along: Axis) -> Outcome:
    """A coordinate of a named face along the axis touches its middle: of what is not a size, that alone is used."""
    feature = None if index is None else profile.features[index]
    if index is None or feature is None or not is_face(feature) or reading.axis != along or not reading.axis:
        return Left(reading, NO_ERRORS[reading.quantity], (), False)
    (x, z), s = (feature.start_mm[0] + feature.end_mm[0], feature.start_mm[1]), feature.length_mm / 2
    differs = abs(size_of(reading) - z)
    if differs > within_of(reading):
        return _another(profile, reading, index, z)
    error_mm = float(feature.outward_normal(s)[1]) * (reading.actual - z)
    touch = Touch(
        point=reading.characteristic,
        nominal_mm=(x / 2, z),
        feature=feature.name,
        measured_mm=(x / 2, reading.actual),
        error_mm=error_mm,
        line=reading.line,
    )
    return MatchedTouch(touch, index, "name", differs)


def _by_name(profile: Profile, reading: Reading, index: int) -> Outcome:
    """Matches a size with the feature that is named; left where that has no such size, or another."""
    differs = differs_from(profile, index, reading)
    name = profile.names[index]
    if on_other_side(profile.features[index], reading):
        own = "a bore" if reading.side == "outer" else "an outside"
        return Left(
            reading, f"{name!r} is {own} of the profile, and the file says that an {reading.side} size was read"
        )
    if differs is None:
        return Left(reading, f"{name!r} has no {reading.quantity} of its own: where it was measured is not stated")
    if differs > within_of(reading):
        return _another(profile, reading, index, None, differs)
    return _credible(profile, MatchedReading(reading, index, None, "name", differs))


def _named_length(profile: Profile, reading: Reading, index: int) -> Outcome:
    """Matches a length of a named face: from the other named, else the one face, or zero, whose distance fits."""
    other = feature_named(profile, reading.other) if reading.other else None
    if reading.other and other is None:
        return Left(reading, f"{reading.other!r}, from which it counts, is no feature of the part")
    of_it = [
        candidate
        for candidate in candidates(profile, reading)
        if index in (candidate.feature_index, candidate.other_index)
    ]
    if other is not None:
        of_it = [candidate for candidate in of_it if other in (candidate.feature_index, candidate.other_index)]
    return _by_geometry(profile, reading, [_from(candidate, index) for candidate in of_it], "name")


def _from(candidate: Candidate, index: int) -> Candidate:
    """Returns this length as one of that feature."""
    if candidate.feature_index == index or candidate.other_index is None:
        return candidate
    return Candidate(index, candidate.differs, candidate.feature_index)


def _by_geometry(profile: Profile, reading: Reading, fitting: list[Candidate], by: By = "geometry") -> Outcome:
    fitting = _each_once(profile, fitting)
    if not fitting:
        return Left(reading, f"no feature has {_size(reading)}{_blunder(profile, reading)}")
    if len(fitting) > 1:
        names = tuple(_called(profile, candidate) for candidate in fitting)
        return Left(reading, f"{len(fitting)} features have {_size(reading)}: {', '.join(names)}", names)
    (one,) = fitting
    return _credible(profile, MatchedReading(reading, one.feature_index, one.other_index, by, one.differs))


def _each_once(profile: Profile, fitting: list[Candidate]) -> list[Candidate]:
    """Returns the lengths without those from a face at z = 0 that count from the part's zero as well: both are one."""
    from_zero = {one.feature_index for one in fitting if one.other_index is None}

    def again(candidate: Candidate) -> bool:
        faces = {candidate.feature_index, candidate.other_index} - {None}
        at_zero = faces.intersection(profile.faces_at(0.0))
        return bool(at_zero and (faces - at_zero) & from_zero)

    return [one for one in fitting if one.other_index is None or not again(one)]


def _credible(profile: Profile, match: MatchedReading) -> Outcome:
    """Left where the actual size is too far from the nominal one to be that of a part that was only to be finished."""
    reading, nominal = match.reading, match.reading.nominal
    twice = 2.0 if reading.quantity is Quantity.DIAMETER else 1.0
    if nominal is None or abs(reading.actual - nominal) <= twice * CREDIBLE_ERROR_MM:
        return match
    deviation = f"{reading.actual - nominal:+.4f} {reading.quantity.unit}"
    limit = f"at most {twice * CREDIBLE_ERROR_MM:g} is credible"
    return Left(reading, f"it fits {profile.names[match.feature_index]!r}, and deviates by {deviation}: {limit}")


def _another(profile: Profile, reading: Reading, index: int, size: float | None, differs: float | None = None) -> Left:
    """A name whose feature has another size: of another part, or of another place."""
    name, beside = profile.names[index], _beside(profile.features[index], reading)
    own = f"is at {size:.4f} mm" if size is not None else f"differs from it by {differs:.4f} {reading.quantity.unit}"
    why = f"{name!r} is named, and {_size(reading)} is not its own: it {own}"
    if beside:
        return Left(reading, f"{name!r} is named, and {beside}")
    actual = None if reading.nominal is None else differs_from(profile, index, replace(reading, nominal=reading.actual))
    if actual is not None and actual <= within_of(reading):
        return Left(reading, f"{why}, as the actual one is: are the two exchanged?")
    return Left(reading, why + _blunder(profile, reading))


def _beside(feature: Feature, reading: Reading) -> str:
    """Describes a place along the spindle that is not on the feature; empty where it is, or none is stated."""
    z, (low, high) = axial_mm(reading), sorted((feature.start_mm[1], feature.end_mm[1]))
    if z is None or not isinstance(feature, Line) or low - ON_PROFILE_MM <= z <= high + ON_PROFILE_MM:
        return ""
    sign = f"; z {-z:g} mm is on it: is the sign missing?" if low <= -z <= high else ""
    return f"z {z:g} mm is not on it, which goes from {low:g} to {high:g} mm{sign}"


def _blunder(profile: Profile, reading: Reading) -> str:
    """Describes what a factor of two would explain; it is never applied."""
    for factor, quantities, question in FACTORS:
        nominal = None if reading.nominal is None else reading.nominal * factor
        scaled = replace(reading, nominal=nominal, actual=reading.actual * factor)
        if reading.quantity in quantities and len(candidates(profile, scaled)) == 1:
            return f"; {factor:g} times it fits: {question}"
    return ""


def _size(reading: Reading) -> str:
    kind = "an actual" if reading.nominal is None else "a nominal"
    at = f" at z {reading.place_mm[-1]:.3f} mm" if reading.place_mm else ""
    return f"{kind} {reading.quantity} of {size_of(reading):.4f} {reading.quantity.unit}{at}"


def _called(profile: Profile, candidate: Candidate) -> str:
    name = profile.names[candidate.feature_index]
    return name if candidate.other_index is None else f"{name} to {profile.names[candidate.other_index]}"


def _touch(profile: Profile, touch: Touch, names: Mapping[str, str], ball_mm: float) -> Outcome:
    """Returns a touch on the feature that it names, else on the nearest; left where it is off the profile.

    Where its error is not stated it is n·(measured − nominal) less the ball.
    """
    by: By = "name"
    index = feature_named(profile, names.get(touch.feature or "", touch.feature or ""))
    if index is None:
        by, nearest = "geometry", profile.locate([touch.nominal_mm])
        index = int(nearest.feature_index[0])
    off_mm = distance_mm(profile.features[index], touch.nominal_mm)
    if off_mm > ON_PROFILE_MM:
        return Left(touch, f"its nominal point is {off_mm:.3f} mm from {profile.names[index]!r}")
    feature, error_mm = profile.features[index], touch.error_mm
    if error_mm is None and touch.measured_mm is not None:
        outward = feature.outward_normal(feature.locate(touch.nominal_mm)[0])
        error_mm = float(outward @ np.subtract(touch.measured_mm, touch.nominal_mm)) - ball_mm
    if error_mm is None:
        return Left(touch, "it has neither a measured point nor an error")
    return MatchedTouch(replace(touch, feature=feature.name, error_mm=error_mm), index, by, off_mm)
