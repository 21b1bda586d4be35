"""What readings say of errors anywhere: by arithmetic on jointly normal numbers, and by draws of its own."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.support.profiles import polyline
from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.prior.gauged import Places, known
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.seen import Seen

# The stated prior, again: setting, nose, between features, noise (µm); tapers of part and feature (µm a mm of z).
SETTING, NOSE, BETWEEN, NOISE, TAPER, OWN = 20.0, 20.0, 16.0, 1.5, 0.050, 0.030
UM = 1e-3
STEPS = checked_profile(
    polyline([(30.0, -100.0), (30.0, -60.0), (20.0, -60.0), (20.0, 0.0), (0.0, 0.0)], ["wide", "step", "thin", "end"])
)


def vectors_of(profile: Profile, *seen: Seen) -> ErrorVectors:
    """Every reading of one place as a point of its own."""
    points = [one for one in seen if len(one.weight) == 1]
    places = [(profile.features[int(one.feature_index[0])], float(one.arc_length_mm[0])) for one in points]
    return ErrorVectors(
        point=tuple(one.name for one in points),
        feature_index=np.array([one.feature_index[0] for one in points], dtype=np.intp),
        arc_length_mm=np.array([s for _, s in places]),
        error_mm=np.array([one.value_mm for one in points]),
        standard_u_mm=np.array([one.standard_u_mm for one in points]),
        at_reference=np.zeros(len(points), dtype=np.bool_),
        nominal_mm=np.array([feature.point_mm(s) for feature, s in places]),
        outward_normal=np.array([feature.outward_normal(s) for feature, s in places]),
        gauged=tuple(one.name for one in points),
        seen=seen,
    )


def at(profile: Profile, name: str, s: float, error_um: float, u_um: float = 1.0, label: str = "") -> Seen:
    place = ((profile.names.index(name), s, 1.0),)
    return Seen.at(label or f"{name} {s}", place, error_um * UM, u_um * UM)


def said(profile: Profile, vectors: ErrorVectors, name: str, s: float) -> tuple[float, float]:
    """Mean and standard uncertainty at one place, µm."""
    index = np.array([profile.names.index(name)], dtype=np.intp)
    mean, covariance, _ = known(profile, vectors).at(Places.of(profile, index, np.array([s])))
    return float(mean[0]) / UM, math.sqrt(covariance[0, 0]) / UM


@pytest.mark.parametrize("error_um", [25.0, -25.0])
def test_one_diameter_tells_another_by_hand(error_um: float) -> None:
    """Two cylinders that no tangent joins: 15 mm and 30 mm from the part's middle, 5 mm and 0 mm from their own."""
    vectors = vectors_of(STEPS, at(STEPS, "wide", 15.0, error_um))  # z −85: −35 from the middle, −5 from its own
    mean, u = said(STEPS, vectors, "thin", 40.0)  # z −20: +30 and +10
    base = SETTING**2 + NOSE**2 + BETWEEN**2
    seen = base + (TAPER * 35.0) ** 2 + (OWN * 5.0) ** 2 + NOISE**2 + 1.0
    shared = SETTING**2 + NOSE**2 - TAPER**2 * 35.0 * 30.0
    there = base + (TAPER * 30.0) ** 2 + (OWN * 10.0) ** 2
    assert mean == pytest.approx(shared / seen * error_um, rel=1e-9)
    assert u == pytest.approx(math.sqrt(there - shared**2 / seen), rel=1e-9)


def test_two_diameters_show_a_taper_and_a_third_place_follows_it() -> None:
    vectors = vectors_of(STEPS, at(STEPS, "thin", 10.0, 4.0, 0.1), at(STEPS, "thin", 50.0, 8.0, 0.1))
    values = [said(STEPS, vectors, "thin", s)[0] for s in (10.0, 30.0, 50.0)]
    assert values[0] < values[1] < values[2]
    assert values[1] == pytest.approx(0.5 * (values[0] + values[2]), rel=1e-9), "a taper is straight"
    u = [said(STEPS, vectors, "thin", s)[1] for s in (30.0, 60.0)]
    assert u[0] < u[1], "less is known beyond the readings"


def test_faces_are_not_moved_by_diameters_and_their_uncertainty_says_so() -> None:
    vectors = vectors_of(STEPS, *(at(STEPS, "thin", s, 20.0) for s in (10.0, 30.0, 50.0)))
    model = fit_profile(STEPS, vectors)
    face = model.curves[STEPS.names.index("step")]
    assert face.unsupported
    assert face.value_mm(5.0)[0] == 0.0
    prior_um = math.sqrt(SETTING**2 + NOSE**2 + BETWEEN**2)
    assert face.standard_deviation_mm(5.0)[0] / UM == pytest.approx(prior_um, rel=0.01)


def test_a_length_moves_its_faces_apart_from_the_datum() -> None:
    step, end = STEPS.names.index("step"), STEPS.names.index("end")
    length = Seen.at("l", ((end, 10.0, 1.0), (step, 5.0, -1.0)), 12.0 * UM, 0.5 * UM)
    datum = Seen.at("datum", ((end, 10.0, 1.0),), 0.0, 0.0)
    seen = (length, datum, at(STEPS, "thin", 30.0, 5.0))
    vectors = vectors_of(STEPS, *seen)
    mean, u = said(STEPS, vectors, "end", 10.0)
    assert (abs(mean), u) == pytest.approx((0.0, 0.0), abs=1e-3)
    mean, u = said(STEPS, vectors, "step", 5.0)
    assert mean == pytest.approx(-12.0, abs=0.2), "the length is longer: less was left on where it begins"
    assert u == pytest.approx(math.sqrt(2.0 * NOISE**2 + 0.25), rel=0.02)


def test_a_mean_over_a_cylinder_is_the_mean_of_what_is_said_along_it() -> None:
    """A mean of 10 µm over the cylinder, and −3 µm at its start: it is tapered, and the mean is where it was read."""
    places = tuple((STEPS.names.index("thin"), s, 0.2) for s in (6.0, 18.0, 30.0, 42.0, 54.0))
    mean = Seen.at("mean", places, 10.0 * UM, 1e-3 * UM)
    alone = vectors_of(STEPS, at(STEPS, "wide", 20.0, 0.0, 1e3), mean)
    noise2 = NOISE**2 / 5 + 1e-6
    variance = SETTING**2 + NOSE**2 + BETWEEN**2 + (TAPER * 20.0) ** 2
    value, u = said(STEPS, alone, "thin", 30.0)
    assert value == pytest.approx(10.0 * variance / (variance + noise2), rel=1e-4)
    assert u == pytest.approx(math.sqrt(variance * noise2 / (variance + noise2)), rel=1e-3)
    tilted = vectors_of(STEPS, at(STEPS, "thin", 10.0, 7.0, 0.1), mean)
    values = [said(STEPS, tilted, "thin", s)[0] for _, s, _ in places]
    assert all(one < other for one, other in pairwise(values))


def test_a_reading_that_all_others_contradict_is_named() -> None:
    good = [at(STEPS, "thin", s, 10.0, 0.5) for s in range(1, 56, 3)]
    assert known(STEPS, vectors_of(STEPS, *good)).contradicted() == ()
    slip = at(STEPS, "thin", 57.0, 60.0, 0.5, "slip")
    found = known(STEPS, vectors_of(STEPS, *good, slip)).contradicted()
    (words,) = found
    assert words.startswith("slip: an error of +60.0 µm, where")


def joined_shaft() -> Profile:
    return checked_profile(
        [
            Line("wide", (30.0, -100.0), (30.0, -62.0)),
            Line("face", (30.0, -62.0), (22.0, -62.0)),
            Arc("fillet", (22.0, -62.0), (20.0, -60.0), (22.0, -60.0), -math.pi / 2),
            Line("thin", (20.0, -60.0), (20.0, 0.0)),
            Line("end", (20.0, 0.0), (0.0, 0.0)),
        ]
    )


def test_curves_meet_to_the_last_bit_where_features_join_tangentially() -> None:
    profile = joined_shaft()
    model = fit_profile(profile, vectors_of(profile, at(profile, "wide", 5.0, 30.0), at(profile, "thin", 50.0, 22.0)))
    face, fillet, thin = (model.curves[profile.names.index(name)] for name in ("face", "fillet", "thin"))
    assert fillet.value_mm(0.0)[0] == pytest.approx(face.value_mm(face.length_mm)[0], abs=1e-15)
    assert fillet.value_mm(fillet.length_mm)[0] == pytest.approx(thin.value_mm(0.0)[0], abs=1e-15)
    assert fillet.standard_deviation_mm(0.0)[0] > 30 * UM > 10 * UM > fillet.standard_deviation_mm(fillet.length_mm)[0]


def test_bands_hold_errors_drawn_from_the_prior_wherever_they_are() -> None:
    """Errors are drawn as sums of their causes, tool by tool, not from a covariance: 19 in 20 lie inside ±1.96 u."""
    rng = np.random.default_rng(5)
    names, places = ("wide", "thin"), {"wide": (5.0, 20.0, 35.0), "thin": (10.0, 30.0, 55.0)}
    z0 = {"wide": -100.0, "thin": -60.0}
    inside = []
    for _ in range(400):
        common, taper = rng.normal(0.0, math.hypot(SETTING, NOSE)), rng.normal(0.0, TAPER)
        own = {name: (rng.normal(0.0, BETWEEN), rng.normal(0.0, OWN)) for name in names}

        def error(name: str, s: Array) -> Array:
            z, (offset, tilt) = z0[name] + s, own[name]  # noqa: B023
            middle = z0[name] + (20.0 if name == "wide" else 30.0)
            return common + taper * (z + 50.0) + offset + tilt * (z - middle)  # noqa: B023

        seen = [
            at(STEPS, name, s, float(error(name, np.array([s]))[0]) + rng.normal(0.0, math.hypot(1.0, NOISE)))
            for name, s in (("wide", 10.0), ("wide", 30.0), ("thin", 20.0))
        ]
        vectors = vectors_of(STEPS, *seen)
        for name in names:
            for s in places[name]:
                mean, u = said(STEPS, vectors, name, s)
                inside.append(abs(float(error(name, np.array([s]))[0]) - mean) <= 1.96 * u)
    assert 0.94 <= np.mean(inside) <= 0.98, "a little more than 0.95: one factor widens bands where readings surprise"
