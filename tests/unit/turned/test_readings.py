"""What readings see of the errors of a profile, judged by the displaced contour itself."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.readings.matches import MatchedReading, match_by_name
from trueloop.turned.readings.observed import datum_of, repeated, seen_by
from trueloop.turned.readings.vectors import with_readings
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen
from trueloop.turned.touches.touches import Gauging

PROFILE = checked_profile(
    [
        Line("wide", (22.0, -112.0), (22.0, -80.0)),
        Line("shoulder", (22.0, -80.0), (20.0, -80.0)),
        Arc("fillet", (20.0, -80.0), (18.0, -78.0), (20.0, -78.0), -math.pi / 2),
        Line("seat", (18.0, -78.0), (18.0, -45.0)),
        Line("cone", (18.0, -45.0), (15.0, -30.0)),
        Line("neck", (15.0, -30.0), (15.0, -12.0)),
        Line("step", (15.0, -12.0), (10.0, -12.0)),
        Line("pin", (10.0, -12.0), (10.0, -10.0)),
        Arc("ball", (10.0, -10.0), (0.0, 0.0), (0.0, -10.0), math.pi / 2),
    ]
)
UM = 1e-3
ErrorOf = Callable[[Array], Array]


def reading(feature: str, quantity: Quantity, actual: float, z_mm: float | None = None, other: str = "") -> Reading:
    place = () if z_mm is None else (z_mm,)
    name = f"{feature} {quantity} {other}{z_mm}"
    return Reading(name, quantity, actual, feature=feature, other=other, place_mm=place, standard_u=0.002)


def matched(*readings: Reading) -> tuple[MatchedReading, ...]:
    return named(PROFILE, *readings)


def named(profile: Profile, *readings: Reading) -> tuple[MatchedReading, ...]:
    found = [match_by_name(profile, one) for one in readings]
    assert None not in found
    return tuple(one for one in found if one is not None)


def seen(one: Reading) -> Seen:
    (group,) = repeated(PROFILE, matched(one), Gauging())
    return seen_by(PROFILE, group, None)


def of_errors(sees: Seen, errors: dict[str, ErrorOf]) -> float:
    """What the sum over its places is."""
    pairs = zip(sees.feature_index.tolist(), sees.arc_length_mm, sees.weight, strict=True)
    return math.fsum(weight * errors[PROFILE.names[i]](np.array([s]))[0] for i, s, weight in pairs)


def displaced(feature: str, error: ErrorOf) -> Callable[[Array], Array]:
    """The surface itself: every nominal point moved along its normal."""
    nominal = PROFILE.features[PROFILE.names.index(feature)]
    return lambda s: nominal.point_mm(s) + error(s)[:, None] * nominal.outward_normal(s)


def diameter_of(surface: Callable[[Array], Array], z_mm: float, low: float, high: float) -> float:
    at: float = brentq(lambda s: float(surface(np.array([s]))[0, 1]) - z_mm, low, high, xtol=1e-13)
    radius: float = surface(np.array([at]))[0, 0]
    return 2.0 * radius


@pytest.mark.parametrize(
    ("feature", "z_mm", "nominal"),
    [("wide", -100.0, 44.0), ("cone", -40.0, 34.0), ("ball", -4.0, 16.0), ("fillet", -79.0, 2 * (20 - math.sqrt(3.0)))],
)
def test_a_diameter_sees_the_surface_at_its_z(feature: str, z_mm: float, nominal: float) -> None:
    """The displaced contour is cut at that z by root finding; positive errors make larger diameters."""
    length = PROFILE.features[PROFILE.names.index(feature)].length_mm
    for size_mm in (3 * UM, -3 * UM):

        def error(s: Array, size_mm: float = size_mm, length: float = length) -> Array:
            return size_mm * (1.0 + 0.1 * s / length)

        actual = diameter_of(displaced(feature, error), z_mm, -0.1 * length, 1.1 * length)
        sees = seen(reading(feature, Quantity.DIAMETER, actual, z_mm))
        assert of_errors(sees, {feature: error}) == pytest.approx(sees.value_mm, abs=0.005 * UM)
        assert sees.value_mm * size_mm > 0.0
    assert seen(reading(feature, Quantity.DIAMETER, nominal, z_mm)).value_mm == pytest.approx(0.0, abs=1e-9)


def test_a_diameter_deviates_by_twice_the_error_and_a_radius_by_it() -> None:
    assert seen(reading("wide", Quantity.DIAMETER, 44.020, -100.0)).value_mm == pytest.approx(0.010)
    assert seen(reading("wide", Quantity.DIAMETER, 44.020, -100.0)).standard_u_mm == pytest.approx(0.001)
    assert seen(reading("wide", Quantity.RADIUS, 22.010, -100.0)).value_mm == pytest.approx(0.010)
    assert seen(reading("wide", Quantity.RADIUS, 22.010, -100.0)).standard_u_mm == pytest.approx(0.002)


def test_on_a_cone_the_hand_that_finds_the_place_makes_it_uncertain() -> None:
    """A z that is off by δ reads another diameter, 2·δ·tan of the cone's angle; the error is half of it by n_x."""
    steep = 3.0 / 15.0
    n_x = 1.0 / math.hypot(1.0, steep)
    cone = seen(reading("cone", Quantity.DIAMETER, 34.0, -40.0))
    assert cone.standard_u_mm == pytest.approx(n_x * math.hypot(0.001, 0.3 * steep))
    machine = Reading("c", Quantity.DIAMETER, 34.0, feature="cone", place_mm=(17.0, -40.0), standard_u=0.002)
    assert seen(machine).standard_u_mm == pytest.approx(n_x * 0.001), "a machine that states x and z finds its place"


def test_a_diameter_without_a_place_is_somewhere_on_its_cylinder() -> None:
    sees = seen(reading("wide", Quantity.DIAMETER, 44.020))
    assert sees.arc_length_mm.tolist() == [16.0]
    assert sees.value_mm == pytest.approx(0.010)
    assert sees.standard_u_mm == pytest.approx(math.hypot(0.001, 50e-6 * 32.0 / math.sqrt(12.0)))


@pytest.mark.parametrize(("feature", "other"), [("step", "shoulder"), ("shoulder", "step"), ("step", "")])
def test_a_length_sees_both_of_its_faces(feature: str, other: str) -> None:
    """Both faces look towards the free end: material left on one makes the length longer, on the other shorter."""
    z = {"step": -12.0, "shoulder": -80.0, "": 0.0}
    left_on = {"step": 5 * UM, "shoulder": 2 * UM, "": 0.0}
    actual = abs(z[feature] + left_on[feature] - z[other] - left_on[other])
    sees = seen(reading(feature, Quantity.LENGTH, actual, other=other))
    errors: dict[str, ErrorOf] = {name: lambda s, e=e: np.full(len(s), e) for name, e in left_on.items()}  # type: ignore[misc]
    assert of_errors(sees, errors) == pytest.approx(sees.value_mm, abs=1e-9)


def test_a_collar_between_faces_that_look_apart_grows_by_both_errors() -> None:
    collar = checked_profile(
        [
            Line("rod", (5.0, -30.0), (5.0, -20.0)),
            Line("left", (5.0, -20.0), (9.0, -20.0)),
            Line("rim", (9.0, -20.0), (9.0, -10.0)),
            Line("right", (9.0, -10.0), (0.0, -10.0)),
        ]
    )
    length = Reading("l", Quantity.LENGTH, 10.007, feature="right", other="left", standard_u=0.002)
    (group,) = repeated(collar, named(collar, length), Gauging())
    sees = seen_by(collar, group, None)
    assert sees.weight.tolist() == [1.0, 1.0]
    assert sees.value_mm == pytest.approx(0.007)


@pytest.mark.parametrize("slope_urad", [200.0, -200.0])
def test_an_angle_sees_the_slope(slope_urad: float) -> None:
    def error(s: Array) -> Array:
        return 1e-6 * slope_urad * s

    ends = displaced("cone", error)(np.array([0.0, PROFILE.features[4].length_mm]))
    rise = ends[1] - ends[0]
    sees = seen(reading("cone", Quantity.ANGLE, math.degrees(math.atan2(abs(rise[0]), rise[1]))))
    assert of_errors(sees, {"cone": error}) == pytest.approx(sees.value_mm, rel=1e-3)
    assert sees.value_mm == pytest.approx(-1e-6 * slope_urad, rel=1e-3), "left on at the thin end: a flatter cone"


@pytest.mark.parametrize("feature", ["fillet", "ball"])
def test_the_radius_of_an_arc_is_that_of_a_circle_through_its_errors(feature: str) -> None:
    """Of a wavy error, too: the oracle fits a circle to points of the displaced arc itself."""
    arc = PROFILE.features[PROFILE.names.index(feature)]
    assert isinstance(arc, Arc)

    def error(s: Array) -> Array:
        return UM * (0.4 + 0.2 * np.sin(5.0 * s / arc.length_mm))

    points = displaced(feature, error)(np.linspace(0.0, arc.length_mm, 33))

    def off(p: Array) -> Array:
        return np.asarray(np.hypot(points[:, 0] - p[0], points[:, 1] - p[1]) - p[2])

    fitted = least_squares(off, (*arc.centre_mm, arc.radius_mm), xtol=1e-15, ftol=1e-15)
    sees = seen(reading(feature, Quantity.RADIUS, float(fitted.x[2])))
    assert of_errors(sees, {feature: error}) == pytest.approx(sees.value_mm, abs=0.001 * UM)
    constant = of_errors(sees, {feature: lambda s: np.full(len(s), UM)})
    assert constant == pytest.approx(UM if feature == "ball" else -UM), "a fillet with material left on is tighter"


def test_repeats_share_their_spread_and_the_mean_of_n_has_less_of_it() -> None:
    diameters = [44.010, 44.014, 44.012]
    three = [reading("wide", Quantity.DIAMETER, d, -100.0) for d in diameters]
    once = reading("neck", Quantity.DIAMETER, 30.0, -20.0)
    first, second = repeated(PROFILE, matched(*three, once), Gauging())
    assert first.count == 3
    assert first.deviation == pytest.approx(0.012)
    assert first.standard_u == pytest.approx(math.hypot(0.002, 0.002 / math.sqrt(3.0)))
    assert second.standard_u == pytest.approx(math.hypot(0.002, 0.002)), "the same gauge repeats no better there"


def test_lengths_alone_have_a_datum_whose_error_is_zero() -> None:
    def length(feature: str, other: str) -> MatchedReading:
        return matched(reading(feature, Quantity.LENGTH, 68.0, other=other))[0]

    names: Sequence[str] = PROFILE.names
    assert datum_of(PROFILE, [length("step", "shoulder")]) == names.index("shoulder")
    assert datum_of(PROFILE, [length("step", "")]) is None, "the part's zero is no face here: it is the datum itself"
    assert datum_of(PROFILE, matched(reading("wide", Quantity.DIAMETER, 44.0))) is None
    faced = checked_profile([Line("d", (9.0, -20.0), (9.0, 0.0)), Line("end", (9.0, 0.0), (0.0, 0.0))])
    at_zero = MatchedReading(reading("end", Quantity.LENGTH, 20.0), 1)
    assert datum_of(faced, [at_zero]) == 1


def vectors_of(*readings: Reading, allowance_mm: float = 0.0, profile: Profile = PROFILE) -> ErrorVectors:
    return with_readings(profile, matched(*readings), None, Gauging(allowance_mm=allowance_mm))[0]


def test_readings_become_points_in_order_along_the_profile() -> None:
    vectors = vectors_of(
        reading("neck", Quantity.DIAMETER, 30.008, -20.0),
        reading("wide", Quantity.DIAMETER, 43.990, -85.0),
        reading("wide", Quantity.DIAMETER, 44.020, -100.0),
        reading("cone", Quantity.ANGLE, math.degrees(math.atan2(3.0, 15.0))),
    )
    assert [PROFILE.names[i] for i in vectors.feature_index] == ["wide", "wide", "neck"]
    np.testing.assert_allclose(vectors.error_mm, [0.010, -0.005, 0.004], atol=1e-12)
    np.testing.assert_allclose(vectors.nominal_mm, [[22.0, -100.0], [22.0, -85.0], [15.0, -20.0]])
    assert set(vectors.gauged) == set(vectors.point)
    assert len(vectors.seen) == 4, "the angle is seen and is no point"


def test_faces_tied_to_the_datum_by_lengths_have_errors_of_their_own() -> None:
    """Step from shoulder +6 µm: with the shoulder's error zero, material is left on the step."""
    vectors = vectors_of(reading("step", Quantity.LENGTH, 68.006, other="shoulder"))
    assert [PROFILE.names[i] for i in vectors.feature_index] == ["shoulder", "step"]
    np.testing.assert_allclose(vectors.error_mm, [0.0, 0.006], atol=1e-9)
    np.testing.assert_allclose(vectors.standard_u_mm, [0.0, 0.002], atol=1e-9)


def test_what_the_cut_was_to_leave_on_is_no_error() -> None:
    vectors = vectors_of(
        reading("wide", Quantity.DIAMETER, 44.420, -100.0),
        reading("step", Quantity.LENGTH, 68.006, other="shoulder"),
        allowance_mm=0.2,
    )
    np.testing.assert_allclose(vectors.error_mm, [0.010, 0.0, 0.006], atol=1e-9)


def test_one_characteristic_in_two_places_is_refused() -> None:
    one, other = (reading("wide", Quantity.DIAMETER, 44.0, z) for z in (-100.0, -90.0))
    named = [Reading("D1", r.quantity, r.actual, feature="wide", place_mm=r.place_mm) for r in (one, other)]
    with pytest.raises(TrueloopError) as caught:
        repeated(PROFILE, matched(*named), Gauging())
    assert caught.value.code is Code.MSR_PLACES


@pytest.mark.parametrize(
    ("quantity", "feature", "factor", "code"),
    [
        (Quantity.DIAMETER, "wide", 0.5, Code.MSR_TWICE),
        (Quantity.RADIUS, "wide", 2.0, Code.MSR_TWICE),
        (Quantity.ANGLE, "cone", 2.0, Code.MSR_TWICE),
        (Quantity.DIAMETER, "wide", 1 / 25.4, Code.MSR_SCALE),
        (Quantity.DIAMETER, "wide", 25.4, Code.MSR_SCALE),
        (Quantity.DIAMETER, "wide", 1.1, Code.MSR_NOMINAL),
    ],
)
def test_readings_that_cannot_be_right_are_named(quantity: Quantity, feature: str, factor: float, code: Code) -> None:
    right = {Quantity.DIAMETER: 44.012, Quantity.RADIUS: 22.006, Quantity.ANGLE: 11.312}[quantity]
    z_mm = None if quantity is Quantity.ANGLE else -100.0
    repeated(PROFILE, matched(reading(feature, quantity, right, z_mm)), Gauging())
    with pytest.raises(TrueloopError) as caught:
        repeated(PROFILE, matched(reading(feature, quantity, factor * right, z_mm)), Gauging())
    assert caught.value.code is code


@pytest.mark.parametrize(
    ("quantity", "feature", "z_mm", "code"),
    [
        (Quantity.DIAMETER, "cone", None, Code.MSR_PLACE),
        (Quantity.DIAMETER, "wide", -20.0, Code.MSR_PLACE),
        (Quantity.DIAMETER, "ball", -0.5, Code.MSR_KIND),
        (Quantity.DIAMETER, "step", -12.0, Code.MSR_PLACE),
        (Quantity.LENGTH, "wide", None, Code.MSR_KIND),
        (Quantity.ANGLE, "ball", None, Code.MSR_KIND),
    ],
)
def test_what_a_feature_does_not_have_cannot_be_read_of_it(
    quantity: Quantity, feature: str, z_mm: float | None, code: Code
) -> None:
    with pytest.raises(TrueloopError) as caught:
        repeated(PROFILE, matched(reading(feature, quantity, 10.0, z_mm)), Gauging())
    assert caught.value.code is code


def test_a_place_on_the_far_side_of_the_axis_is_told_the_radius() -> None:
    far = replace(reading("wide", Quantity.DIAMETER, 44.012, -100.0), place_mm=(-22.0, -100.0))
    with pytest.raises(TrueloopError) as caught:
        repeated(PROFILE, matched(far), Gauging())
    assert "x -22 mm, z -100 mm is not on 'wide', whose radius there is 22 mm" in caught.value.message
    repeated(PROFILE, matched(replace(far, place_mm=(22.0, -100.0))), Gauging())


def test_a_length_from_a_touched_face_is_an_error_of_the_other_face() -> None:
    """The collar's shoulder at z −80 is touched 6 µm too far out, the step at −12 is read 68.030 from it: +36 µm."""
    touch = replace(
        with_readings(PROFILE, matched(reading("wide", Quantity.DIAMETER, 44.0, -100.0)), None, Gauging())[0],
        point=("1",),
        feature_index=np.array([1]),
        arc_length_mm=np.array([0.5]),
        error_mm=np.array([0.006]),
        nominal_mm=np.array([[21.5, -80.0]]),
        outward_normal=np.array([[0.0, 1.0]]),
        gauged=(),
        seen=(),
    )
    length = matched(reading("step", Quantity.LENGTH, 68.030, None, "shoulder"))
    vectors, _ = with_readings(PROFILE, length, touch, Gauging())
    assert vectors.point == ("1", "step (lengths)") and vectors.gauged == ("step (lengths)",)
    assert vectors.error_mm.tolist() == pytest.approx([0.006, 0.036])


def test_runout_is_kept_and_no_error_follows() -> None:
    both = matched(
        reading("wide", Quantity.DIAMETER, 44.0, -100.0), reading("wide", Quantity.RUNOUT, 0.004, z_mm=-100.0)
    )
    vectors, notes = with_readings(PROFILE, both, None, Gauging())
    assert len(vectors.seen) == 1
    assert any("runout" in note for note in notes)
    assert not len(with_readings(PROFILE, both[1:], None, Gauging())[0].point)
