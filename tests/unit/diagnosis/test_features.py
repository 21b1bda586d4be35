"""Errors of features from points, against independent least squares and by simulated coverage."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import optimize, stats

from trueloop.arrays import Array
from trueloop.diagnosis.features.errors_of import errors_of, undetermined
from trueloop.diagnosis.features.feature_error import (
    ErrorKind,
    FeatureError,
    FeaturePlace,
    SeenPoints,
    averaged,
    fitted,
)
from trueloop.errors import Code, Finding

U = 0.001
SHAFT = {"shaft": FeaturePlace("shaft", "shaft", (20.0, 20.0), (0.0, 100.0))}


def points(
    nominal: Array, normal: Array, error: Array, u: float | Array = U, angle: Array | None = None, name: str = "shaft"
) -> SeenPoints:
    count = len(error)
    spindle = np.full(count, np.nan) if angle is None else angle
    return SeenPoints(
        (name,) * count, nominal, normal, error, np.broadcast_to(u, count).astype(float), spindle, np.ones(count, int)
    )


def shaft(z: Array, error: Array, u: float | Array = U, angle: Array | None = None) -> SeenPoints:
    nominal = np.column_stack([np.full(len(z), 20.0), z])
    return points(nominal, np.tile([1.0, 0.0], (len(z), 1)), error, u, angle)


def face(name: str, radius: Array, z: float, error: Array, looks: float = 1.0) -> SeenPoints:
    nominal = np.column_stack([radius, np.full(len(radius), z)])
    return points(nominal, np.tile([0.0, looks], (len(radius), 1)), error, U, name=name)


def joined(*parts: SeenPoints) -> SeenPoints:
    arrays = (
        np.concatenate([getattr(p, n) for p in parts])
        for n in ("nominal_mm", "normal", "error_mm", "standard_u_mm", "spindle_rad", "repeat")
    )
    return SeenPoints(tuple(itertools.chain.from_iterable(p.feature for p in parts)), *arrays)


def by_kind(found: tuple[FeatureError, ...]) -> dict[ErrorKind, FeatureError]:
    return {one.kind: one for one in found}


def test_radius_and_taper_are_those_of_polyfit_at_the_ends_of_the_feature() -> None:
    z, u = np.array([12.0, 40.0, 90.0]), np.array([0.001, 0.003, 0.002])
    error = np.array([0.013, 0.012, 0.021])
    (slope, constant), covariance = np.polyfit(z, error, 1, w=1 / u, cov="unscaled")
    found = by_kind(errors_of(shaft(z, error, u), SHAFT))
    radius, taper = found[ErrorKind.RADIUS], found[ErrorKind.SHAFT_TAPER]
    assert radius.value_mm == pytest.approx(constant, rel=1e-9)
    assert radius.standard_u_mm == pytest.approx(np.sqrt(covariance[1, 1]), rel=1e-9)
    assert taper.value_mm == pytest.approx(100 * slope, rel=1e-9)
    assert taper.standard_u_mm == pytest.approx(100 * np.sqrt(covariance[0, 0]), rel=1e-9)
    shared = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert taper.more["correlation_with_radius"] == pytest.approx(shared, rel=1e-9)
    assert radius.degrees_of_freedom is None


def test_scatter_beyond_the_device_is_found_as_by_a_minimiser_of_its_own() -> None:
    rng = np.random.default_rng(5)
    z, u = np.linspace(0, 100, 9), rng.uniform(0.0005, 0.002, 9)
    error = 0.01 + rng.normal(0, 0.004, 9)
    columns = np.column_stack([np.ones(9), z])

    def off(tau: float) -> float:
        weight = 1 / np.sqrt(u**2 + tau**2)
        left = error - np.polyval(np.polyfit(z, error, 1, w=weight), z)
        return float(np.sum((left * weight) ** 2)) - 7

    assert fitted(columns, error, u).scatter_mm == pytest.approx(optimize.bisect(off, 1e-6, 0.1), rel=1e-6)
    assert fitted(columns, error, 20 * u).scatter_mm == 0.0


def test_the_cubic_is_that_of_polyfit() -> None:
    z = np.linspace(10, 90, 8)
    error = 0.003 + 1e-4 * z - 4e-6 * z**2 + 3e-8 * z**3
    more = by_kind(errors_of(shaft(z, error), SHAFT))[ErrorKind.STRAIGHTNESS].more
    expected = np.polynomial.polynomial.polyfit(z - 10, error, 3)
    assert [more[k] for k in ("a0_mm", "a1_rad", "a2_per_mm", "a3_per_mm2")] == pytest.approx(expected, rel=1e-6)


def test_straightness_of_a_bow_is_its_height() -> None:
    z = np.linspace(0, 100, 41)
    bow = 0.02 * (1 - ((z - 50) / 50) ** 2)
    found = by_kind(errors_of(shaft(z, bow + 0.003 - 1e-4 * z, u=1e-5), SHAFT))
    assert found[ErrorKind.STRAIGHTNESS].value_mm == pytest.approx(0.02, abs=1e-5)
    assert found[ErrorKind.WAVINESS].value_mm == pytest.approx(0.0, abs=1e-6)
    assert found[ErrorKind.SHAFT_TAPER].value_mm == pytest.approx(-0.01, abs=1e-5)


def test_a_face_has_a_taper_from_its_smallest_to_its_largest_radius() -> None:
    radius = np.array([8.0, 14.0, 20.0])
    places = {"face": FeaturePlace("face", "face", (5.0, 25.0), (50.0, 50.0))}
    (found,) = errors_of(face("face", radius, 50.0, 0.001 * radius), places)
    assert found.kind is ErrorKind.FACE_TAPER
    assert found.value_mm == pytest.approx(0.020)


@pytest.mark.parametrize(("looks", "length"), [(1.0, 0.008), (-1.0, 0.012)])
def test_a_length_is_too_long_by_what_is_left_on_its_ends(looks: float, length: float) -> None:
    """Material left on a nearer face that looks to −z makes it longer, on one that looks to +z shorter."""
    radius = np.array([10.0, 20.0])
    places = {
        "far": FeaturePlace("far", "face", (10.0, 20.0), (60.0, 60.0)),
        "near": FeaturePlace("near", "face", (10.0, 20.0), (10.0, 10.0)),
    }
    both = joined(
        face("far", radius, 60.0, np.array([0.010, 0.010])), face("near", radius, 10.0, np.full(2, 0.002), looks)
    )
    found = by_kind(errors_of(both, places))[ErrorKind.LENGTH]
    assert (found.feature, found.other) == ("far", "near")
    assert found.value_mm == pytest.approx(length)
    assert found.standard_u_mm == pytest.approx(U)  # two means of two


def test_points_of_one_place_have_a_radius_where_they_are_and_no_taper() -> None:
    found = errors_of(shaft(np.array([80.0, 81.0]), np.array([0.004, 0.006])), SHAFT)
    assert [one.kind for one in found] == [ErrorKind.RADIUS]
    assert found[0].value_mm == pytest.approx(0.005)
    assert found[0].more["at_z_mm"] == pytest.approx(80.5)


def test_repeats_count_by_the_root_of_their_number_and_by_their_scatter() -> None:
    z = np.repeat([10.0, 90.0], 4)
    quiet = averaged(shaft(z, np.full(8, 0.003)))
    assert quiet.standard_u_mm == pytest.approx([U / 2] * 2)
    assert quiet.degrees_of_freedom is None
    error = np.array([-6.0, -2, 2, 6, -6, -2, 2, 6]) * U
    noisy = averaged(shaft(z, error))
    assert noisy.standard_u_mm == pytest.approx([np.std(error[:4], ddof=1) / 2] * 2)
    assert noisy.degrees_of_freedom == 6


def test_eccentricity_and_lobing_have_amplitude_and_direction() -> None:
    angle = np.tile(np.arange(12) * np.pi / 6, 2)
    error = 0.005 + 0.02 * np.cos(angle - 0.7) + 0.01 * np.cos(3 * (angle - 0.2))
    found = by_kind(errors_of(shaft(np.repeat([10.0, 90.0], 12), error, 1e-5, angle), SHAFT))
    assert found[ErrorKind.RADIUS].value_mm == pytest.approx(0.005, abs=1e-7)
    for kind, amplitude, highest in ((ErrorKind.ECCENTRICITY, 0.02, 0.7), (ErrorKind.LOBING, 0.01, 0.2)):
        assert found[kind].value_mm == pytest.approx(amplitude, rel=1e-4)
        assert found[kind].more["highest_rad"] == pytest.approx(highest, abs=1e-4)


def test_angles_on_one_side_say_nothing_of_waves() -> None:
    angle = np.tile(np.linspace(0.0, 0.3, 8), 2)
    found = errors_of(shaft(np.repeat([10.0, 90.0], 8), np.full(16, 0.01), U, angle), SHAFT)
    assert [one.kind for one in found] == [ErrorKind.RADIUS, ErrorKind.SHAFT_TAPER]


@given(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.integers(2, 12))
def test_a_straight_shaft_is_found_exactly_wherever_it_is_measured(radius: float, taper: float, count: int) -> None:
    z = np.linspace(20, 75, count)
    found = by_kind(errors_of(shaft(z, radius + taper * z / 100), SHAFT))
    assert found[ErrorKind.RADIUS].value_mm == pytest.approx(radius, abs=1e-9)
    assert found[ErrorKind.SHAFT_TAPER].value_mm == pytest.approx(taper, abs=1e-9)


def coverage(truth: dict[ErrorKind, float], error: Array, places: int, angles: int, scatter: float, seed: int) -> None:
    """That value ± k·u holds the truth in 95 % of 400 parts, or more, but not much less: 0.92 is 2.7 σ below."""
    rng, parts = np.random.default_rng(seed), 400
    z = np.repeat(np.linspace(0, 100, places), angles)
    angle = np.tile(np.arange(angles) * 2 * np.pi / angles, places) if angles > 1 else None
    held: dict[ErrorKind, list[bool]] = {kind: [] for kind in truth}
    ratio: dict[ErrorKind, list[float]] = {kind: [] for kind in truth}
    for _ in range(parts):
        seen = error + rng.normal(0, np.hypot(U, scatter), len(z))
        for one in errors_of(shaft(z, seen, U, angle), SHAFT):
            if one.kind in truth:
                k = 1.96 if one.degrees_of_freedom is None else stats.t.ppf(0.975, one.degrees_of_freedom)
                off = one.value_mm - truth[one.kind]
                held[one.kind].append(abs(off) <= k * one.standard_u_mm)
                ratio[one.kind].append(off / one.standard_u_mm)
    for kind, inside in held.items():
        assert len(inside) == parts
        assert np.mean(inside) > 0.92, kind
        assert np.std(ratio[kind]) > 0.5, kind  # an uncertainty twice too large holds everything


@pytest.mark.parametrize(("places", "scatter"), [(2, 0.0), (3, 0.0), (8, 0.0), (10, 0.002)])
def test_radius_and_taper_are_covered(places: int, scatter: float) -> None:
    error = np.linspace(0.004, 0.010, places)
    coverage({ErrorKind.RADIUS: 0.004, ErrorKind.SHAFT_TAPER: 0.006}, error, places, 1, scatter, 11)


@pytest.mark.parametrize("bow", [0.0, 0.002, 0.004, 0.02])
def test_straightness_is_covered(bow: float) -> None:
    error = bow * (1 - np.linspace(-1, 1, 8) ** 2)
    coverage({ErrorKind.STRAIGHTNESS: bow}, error, 8, 1, 0.0, 12)


@pytest.mark.parametrize("in_u", [0.0, 1.0, 2.0, 3.0, 10.0])
def test_amplitudes_are_covered(in_u: float) -> None:
    """The uncertainty of a coefficient of 24 points is u·√(2/24)."""
    amplitude = in_u * U * np.sqrt(2 / 24)
    error = amplitude * np.cos(np.tile(np.arange(8) * np.pi / 4, 3) - 1.0)
    coverage({ErrorKind.ECCENTRICITY: amplitude, ErrorKind.LOBING: 0.0}, error, 3, 8, 0.0, 13)


@pytest.mark.parametrize("scatter", [0.0, 0.001, 0.004])
def test_waviness_is_covered_by_its_interval_and_rarely_found_in_noise(scatter: float) -> None:
    rng, z = np.random.default_rng(14), np.linspace(0, 100, 10)
    found = [
        by_kind(errors_of(shaft(z, rng.normal(0, np.hypot(U, scatter), 10)), SHAFT))[ErrorKind.WAVINESS]
        for _ in range(400)
    ]
    inside = np.mean([one.more["low_mm"] <= scatter <= one.more["high_mm"] for one in found])
    assert 0.92 < inside < 0.995
    clear = np.mean([one.value_mm > 2 * one.standard_u_mm for one in found])
    assert clear < 0.08 if scatter == 0.0 else clear > (0.3 if scatter == 0.001 else 0.95)


def lacking(finding: Finding) -> list[ErrorKind]:
    return [kind for kind in ErrorKind if f"no {kind};" in finding.message]


def test_what_points_do_not_determine_is_named() -> None:
    places = SHAFT | {
        "face": FeaturePlace("face", "face", (5.0, 25.0), (50.0, 50.0)),
        "bore": FeaturePlace("bore", "shaft", (4.0, 4.0), (0.0, 30.0)),
    }
    angle = np.tile([0.0, 2.0, 4.0], 2)
    few = shaft(np.repeat([10.0, 90.0], 3), np.zeros(6), U, angle)
    seen = joined(few, face("face", np.array([10.0, 10.0]), 50.0, np.zeros(2)))
    named = [(one.values["feature"], kind) for one in undetermined(seen, places) for kind in lacking(one)]
    assert named == [
        ("shaft", ErrorKind.STRAIGHTNESS),
        ("shaft", ErrorKind.ECCENTRICITY),
        ("face", ErrorKind.FACE_TAPER),
    ]
    assert undetermined(seen, places)[-1].values["feature"] == "bore"
    assert all(one.code is Code.DIA_POINTS for one in undetermined(seen, places))


@pytest.mark.parametrize(("places", "angles"), [(1, 1), (2, 1), (6, 1), (3, 4), (3, 6), (7, 8)])
def test_every_error_is_found_or_named(places: int, angles: int) -> None:
    angle = np.tile(np.arange(angles) * 2 * np.pi / angles, places)
    seen = shaft(np.repeat(np.linspace(0, 100, places), angles), np.zeros(places * angles), U, angle)
    found = {one.kind for one in errors_of(seen, SHAFT)}
    named = {kind for one in undetermined(seen, SHAFT) for kind in lacking(one)}
    assert not found & named
    assert ErrorKind.SHAFT_TAPER in found | named
    assert (ErrorKind.STRAIGHTNESS in found) == (places >= 6)
    assert (ErrorKind.LOBING in found) == (angles >= 7)


def test_noise_alone_has_a_straightness_of_zero_in_63_percent() -> None:
    """The square of two coefficients of noise is below its mean in 1 − 1/e of cases, were their shapes alike."""
    rng, z = np.random.default_rng(15), np.linspace(0, 100, 8)
    found = [
        by_kind(errors_of(shaft(z, rng.normal(0, U, 8)), SHAFT))[ErrorKind.STRAIGHTNESS].value_mm for _ in range(500)
    ]
    assert np.mean(np.array(found) == 0.0) == pytest.approx(1 - np.exp(-1), abs=0.08)
