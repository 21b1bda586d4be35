"""What readings say of errors anywhere on a part."""

import math

import numpy as np
import pytest

from tests.support.profiles import polyline
from trueloop.arrays import Array
from trueloop.domain.inspection import Touch
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.prior.part_state import part_state
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.touches import Gauging, error_vectors

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
    found = part_state(profile, vectors).at(np.array([profile.names.index(name)]), np.array([s]))
    return float(found.mean_mm[0]) / UM, float(found.standard_u_mm[0]) / UM


@pytest.mark.parametrize("error_um", [25.0, -25.0])
def test_one_diameter_tells_another(error_um: float) -> None:
    """Two cylinders that no tangent joins share setting and nose: most of the error, by its sign, with its doubt."""
    mean, u = said(STEPS, vectors_of(STEPS, at(STEPS, "wide", 15.0, error_um)), "thin", 40.0)
    assert 0.6 < mean / error_um < 1.0
    assert 4.0 < u < 20.0


def test_two_diameters_show_a_taper_and_less_is_known_beyond_them() -> None:
    vectors = vectors_of(STEPS, at(STEPS, "thin", 10.0, 4.0, 0.1), at(STEPS, "thin", 50.0, 12.0, 0.1))
    values, u = zip(*(said(STEPS, vectors, "thin", s) for s in (10.0, 30.0, 50.0, 60.0)), strict=True)
    assert values[0] < values[1] < values[2]
    assert u[2] < u[3]


def test_a_length_moves_its_faces_apart_from_the_datum() -> None:
    step, end = STEPS.names.index("step"), STEPS.names.index("end")
    length = Seen.at("l", ((end, 10.0, 1.0), (step, 5.0, -1.0)), 12.0 * UM, 0.5 * UM)
    datum = Seen.at("datum", ((end, 10.0, 1.0),), 0.0, 0.0)
    vectors = vectors_of(STEPS, length, datum, at(STEPS, "thin", 30.0, 5.0))
    assert said(STEPS, vectors, "end", 10.0) == pytest.approx((0.0, 1.0), abs=0.4)
    mean, u = said(STEPS, vectors, "step", 5.0)
    assert mean == pytest.approx(-12.0, abs=0.4), "the length is longer: less was left on where it begins"
    assert 0.8 < u < 2.5


def test_a_mean_over_a_cylinder_is_the_mean_of_what_is_known_along_it() -> None:
    """A mean of 10 µm over the cylinder, and 7 µm near its start: it is tapered, and the mean is where it was read."""
    places = tuple((STEPS.names.index("thin"), s, 0.2) for s in (6.0, 18.0, 30.0, 42.0, 54.0))
    mean = Seen.at("mean", places, 10.0 * UM, 1e-3 * UM)
    tilted = part_state(STEPS, vectors_of(STEPS, at(STEPS, "thin", 10.0, 7.0, 0.1), mean))
    index = np.full(5, STEPS.names.index("thin"))
    values_um = tilted.at(index, np.array([s for _, s, _ in places])).mean_mm / UM
    assert np.mean(values_um) == pytest.approx(10.0, abs=0.3)
    assert values_um[0] < values_um[-1]


def test_a_reading_that_all_others_contradict_is_named() -> None:
    good = [at(STEPS, "thin", s, 10.0, 0.5) for s in range(1, 56, 3)]
    assert part_state(STEPS, vectors_of(STEPS, *good)).contradicted() == ()
    slip = at(STEPS, "thin", 57.0, 60.0, 0.5, "slip")
    (words,) = part_state(STEPS, vectors_of(STEPS, *good, slip)).contradicted()
    assert words.startswith("slip: an error of +60.0 µm, where")


def test_curves_meet_to_the_last_bit_where_features_join_tangentially() -> None:
    profile = checked_profile(
        [
            Line("wide", (30.0, -100.0), (30.0, -62.0)),
            Line("face", (30.0, -62.0), (22.0, -62.0)),
            Arc("fillet", (22.0, -62.0), (20.0, -60.0), (22.0, -60.0), -math.pi / 2),
            Line("thin", (20.0, -60.0), (20.0, 0.0)),
            Line("end", (20.0, 0.0), (0.0, 0.0)),
        ]
    )
    model = fit_profile(profile, vectors_of(profile, at(profile, "wide", 5.0, 30.0), at(profile, "thin", 50.0, 22.0)))
    face, fillet, thin = (model.curves[profile.names.index(name)] for name in ("face", "fillet", "thin"))
    assert fillet.value_mm(0.0)[0] == pytest.approx(face.value_mm(face.length_mm)[0], abs=1e-15)
    assert fillet.value_mm(fillet.length_mm)[0] == pytest.approx(thin.value_mm(0.0)[0], abs=1e-15)
    assert fillet.standard_deviation_mm(0.0)[0] > fillet.standard_deviation_mm(fillet.length_mm)[0]


def test_faces_are_not_moved_by_diameters_and_their_uncertainty_says_so() -> None:
    vectors = vectors_of(STEPS, *(at(STEPS, "thin", s, 20.0) for s in (10.0, 30.0, 50.0)))
    face = fit_profile(STEPS, vectors).curves[STEPS.names.index("step")]
    assert face.unsupported
    assert face.value_mm(5.0)[0] == 0.0
    assert face.standard_deviation_mm(5.0)[0] > 15.0 * UM


def test_a_bow_that_five_diameters_show_is_followed() -> None:
    """20 µm in the middle of a cylinder, read to half a micrometre: at most 2.5 µm are left."""
    places = np.array([3.0, 16.0, 30.0, 44.0, 57.0])
    vectors = vectors_of(STEPS, *(at(STEPS, "thin", s, 20.0 * math.sin(math.pi * s / 60.0), 0.5) for s in places))
    curve = fit_profile(STEPS, vectors).curves[STEPS.names.index("thin")]
    s = np.linspace(0.0, 60.0, 25)
    assert np.max(np.abs(curve.value_mm(s) / UM - 20.0 * np.sin(np.pi * s / 60.0))) < 2.5


def test_bands_hold_errors_of_shafts_drawn_cause_by_cause() -> None:
    """Tool, taper, a figure and a bow of each cylinder, three readings of the shaft: 19 in 20 lie inside ±1.96 u."""
    rng, z0, inside = np.random.default_rng(5), {"wide": -100.0, "thin": -60.0}, []
    for _ in range(150):
        common, taper = rng.normal(0.0, 20.0), rng.normal(0.0, 0.04)
        own = {name: rng.normal(0.0, 4.0) for name in z0}
        bow = {name: rng.normal(0.0, 5.0) for name in z0}
        true = {name: common + own[name] + taper * (z0[name] + 50.0) for name in z0}

        def bowed(name: str, s: Array | float) -> Array:
            return np.asarray(bow[name] * np.sin(np.pi * s / (40.0 if name == "wide" else 60.0)))  # noqa: B023

        seen = [
            at(STEPS, name, s, true[name] + taper * s + float(bowed(name, s)) + rng.normal(0.0, math.hypot(1.0, 1.0)))
            for name, s in (("wide", 10.0), ("wide", 30.0), ("thin", 20.0))
        ]
        state = part_state(STEPS, vectors_of(STEPS, *seen))
        for name, at_mm in (("wide", (5.0, 35.0)), ("thin", (10.0, 30.0, 55.0))):
            s = np.array(at_mm)
            found = state.at(np.full(len(s), STEPS.names.index(name)), s)
            off = true[name] + taper * s + bowed(name, s) - found.mean_mm / UM
            inside.append(np.abs(off) <= 1.96 * found.standard_u_mm / UM)
    assert 0.94 <= np.mean(np.concatenate(inside)) <= 0.98


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_errors_count_from_the_face_that_z_was_taken_from(sign: float) -> None:
    """Steps of 8 µm more or less than the end, from which z was taken: the part has them, and the end has no error."""
    places = [("wide", 30.0, 0.0), ("step", 3.0, 8.0), ("step", 7.0, 8.0), ("end", 10.0, 0.0)]
    touches = [
        Touch(f"{name} {s}", (float(x), float(z)), error_mm=sign * error_um * UM)
        for name, s, error_um in places
        for x, z in [STEPS.features[STEPS.names.index(name)].point_mm(s)]
    ]
    vectors = error_vectors(STEPS, touches, Gauging(z_reference="end 10.0"))
    assert said(STEPS, vectors, "step", 5.0)[0] == pytest.approx(sign * 8.0, abs=1.5)
    assert said(STEPS, vectors, "end", 10.0) == pytest.approx((0.0, 0.0), abs=0.01)
