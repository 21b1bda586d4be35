"""Is a tool offset enough? Decided on data with a known answer."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.arrays import Array
from trueloop.turned.compensation.decide import decide

CYLINDER, FACE = (1.0, 0.0), (0.0, 1.0)
NORMALS = np.array([CYLINDER] * 6 + [FACE] * 6)
NOISE_MM = np.tile([0.001, -0.001, 0.0005, -0.0005, 0.001, -0.001], 2)
SIGMA_MM = 0.001


def errors(x_mm: float, z_mm: float, x_taper_mm: float = 0.0) -> Array:
    taper = np.concatenate([np.linspace(-0.5, 0.5, 6) * x_taper_mm, np.zeros(6)])
    return np.asarray(NORMALS @ [x_mm, z_mm] + taper + NOISE_MM)


def test_pure_size_error_needs_the_offset_alone() -> None:
    decision = decide(errors(0.020, -0.010), NORMALS, SIGMA_MM, 8, 1e-4, 1.0)
    assert decision.offset_is_enough
    assert decision.offset_mm == pytest.approx((-0.020, 0.010), abs=1e-4)
    assert "offset is enough" in decision.x.words


def test_taper_on_cylinders_changes_x_and_leaves_z() -> None:
    decision = decide(errors(0.020, -0.010, x_taper_mm=0.030), NORMALS, SIGMA_MM, 8, 1e-4, 1.0)
    assert not decision.x.enough
    assert decision.z.enough
    assert not decision.offset_is_enough
    assert decision.x.largest_left_mm == pytest.approx(0.0155, abs=0.002)


def test_expected_errors_of_earlier_parts_are_followed_where_the_contour_is_changed_anyway() -> None:
    """A taper of 2 µm, well below what touches scatter by: no test of touches sees it, and it is known."""
    expected = errors(0.020, -0.010, x_taper_mm=0.002) - NOISE_MM
    by_test, known = (decide(expected, NORMALS, SIGMA_MM, 8, 1e-4, 1.0, "contour", known=k) for k in (False, True))
    assert by_test.offset_is_enough and not known.x.enough and known.z.enough
    assert "earlier parts tell the curve" in known.x.words


def test_weight_scales_the_offset_and_nothing_else() -> None:
    full = decide(errors(0.04, 0.0), NORMALS, SIGMA_MM, 8, 1e-4, 1.0)
    part = decide(errors(0.04, 0.0), NORMALS, SIGMA_MM, 8, 1e-4, 0.75)
    assert part.offset_mm[0] == pytest.approx(0.75 * full.offset_mm[0])
    assert part.x.p_value == full.x.p_value
    assert part.offset_mm[0] == pytest.approx(-0.03, abs=1e-4)  # [4773 Fig. 9]: 50 → 49.97 mm


def test_an_axis_that_no_touch_faces_stays() -> None:
    decision = decide(np.full(6, 0.02), NORMALS[:6], SIGMA_MM, 8, 1e-4, 1.0)
    assert decision.z.offset_mm == 0.0
    assert "no touch faces Z" in decision.z.words
    own = decide(np.full(6, 0.02), NORMALS[:6], SIGMA_MM, 8, 1e-4, 1.0, cuts_zero=True)
    assert own.z.enough and own.z.words.startswith("Z: it counts from a face that the tool itself cuts; an offset")


def test_errors_below_the_control_resolution_never_change_the_contour() -> None:
    tiny = 1e-5 * np.sin(np.arange(12))
    assert decide(tiny, NORMALS, 1e-7, 8, 1e-4, 1.0).offset_is_enough


@pytest.mark.parametrize(("taper_mm", "enough"), [(0.0012, True), (0.0014, False)])
def test_a_contour_is_written_to_half_a_step(taper_mm: float, enough: bool) -> None:
    """A taper of ±t is left by any offset; steps of 0.0001 inch, 2.54 µm, are written to within 1.27 µm."""
    along = taper_mm * np.linspace(-1.0, 1.0, 9)
    normals = np.tile([1.0, 0.0], (9, 1))
    assert decide(0.02 + along, normals, 1e-7, 8, 0.00254, 1.0).offset_is_enough == enough


@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_offset_is_found_on_slanted_features_too(x_mm: float, z_mm: float) -> None:
    angles = np.linspace(0.1, math.pi / 2, 9)
    normals = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    decision = decide(normals @ [x_mm, z_mm], normals, SIGMA_MM, math.inf, 1e-4, 1.0)
    assert decision.offset_mm == pytest.approx((-x_mm, -z_mm), abs=1e-12)
    assert decision.offset_is_enough


def test_the_offset_is_as_uncertain_as_it_scatters() -> None:
    """Leverage × σ² is the variance of the offset along each normal; it sums to the number of axes that are faced."""
    random, angles = np.random.default_rng(1), np.linspace(0.1, math.pi / 2, 9)
    normals = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    found = [decide(random.normal(0, 1.0, 9), normals, 1.0, math.inf, 1e-4, 1.0).offset_mm for _ in range(3000)]
    leverage = decide(np.zeros(9), normals, 1.0, math.inf, 1e-4, 1.0).leverage(normals, np.ones(9))
    assert np.allclose(np.var(np.array(found) @ normals.T, axis=0), leverage, rtol=0.1)
    assert leverage.sum() == pytest.approx(2.0)


def test_an_offset_that_the_job_wants_is_not_said_to_change_the_contour() -> None:
    by_offset, by_test = (
        decide(errors(0.02, -0.01, x_taper_mm=0.03), NORMALS, SIGMA_MM, 8, 1e-4, 1.0, by) for by in ("offset", "auto")
    )
    assert "contour is changed" in by_test.x.words and not by_test.x.enough
    assert "contour is changed" not in by_offset.x.words and by_offset.by_offset


def test_each_touch_counts_by_its_own_uncertainty() -> None:
    """Two good gauges and a bad one on a cylinder: the mean weighted by 1/σ², its variance 1/Σσ⁻²; the test stays one
    of 5 %, and no good reading is called scatter because of the bad one.
    """
    random, normals, sigma = np.random.default_rng(2), np.tile([1.0, 0.0], (4, 1)), np.array([1.0, 1.0, 1.0, 20.0])
    found = [decide(random.normal(0, sigma), normals, sigma, math.inf, 1e-4, 1.0) for _ in range(3000)]
    by_hand = 1.0 / np.sum(sigma**-2)
    assert np.var([one.offset_mm[0] for one in found]) == pytest.approx(by_hand, rel=0.1)
    assert found[0].variance(normals) == pytest.approx(np.full(4, by_hand))
    assert found[0].leverage(normals, sigma) == pytest.approx(by_hand / sigma**2)
    assert np.mean([not one.offset_is_enough for one in found]) == pytest.approx(0.05, abs=0.012)
    contour = decide(np.array([20.0, 20.0, 5.0, 40.0]), normals, sigma, math.inf, 1e-4, 1.0)
    assert not contour.offset_is_enough and contour.offset_mm[0] == pytest.approx(-15.0, abs=0.1)


def test_a_vague_place_on_a_cone_determines_no_offset_along_z() -> None:
    normals = np.array([[1.0, 0.0], [1.0, 0.0], [0.894, 0.447]])
    errors_mm, sigma = np.array([0.0, 0.0, 0.036]), np.array([1e-3, 1e-3, 0.134])
    decision = decide(errors_mm, normals, sigma, math.inf, 1e-4, 1.0, vague_mm=0.01)
    assert decision.offset_mm[0] == pytest.approx(0.0, abs=1e-4)
    assert decision.offset_mm[1] == 0.0 and "does not determine" in decision.z.words


@pytest.mark.parametrize("of_faces", [1.0, 0.14, 0.001])
def test_how_well_faces_are_known_has_no_part_in_whether_diameters_determine_x(of_faces: float) -> None:
    """Diameters off by +15, +15, +10, +10 µm, each to 1 µm: −12.5 µm; χ² = 4 · 2.5² over 7 − 2: 1.96 · √5 · 1/√4 µm."""
    normals = np.array([CYLINDER] * 4 + [FACE] * 3)
    sigma = 1e-3 * np.array([1.0] * 4 + [of_faces] * 3)
    off = 1e-3 * np.array([15.0, 15.0, 10.0, 10.0, -7.0, -7.0, -7.0])
    found = decide(off, normals, sigma, math.inf, 1e-4, 1.0, "contour", vague_mm=0.01)
    assert found.offset_mm == pytest.approx((-0.0125, 0.007), abs=1e-9)
    assert found.x.expanded_u_mm == pytest.approx(1e-3 * 1.959964 * math.sqrt(5.0) / 2.0, rel=1e-6)
    assert not found.x.enough and found.z.enough


@pytest.mark.parametrize(("by", "then"), [("auto", "the contour is changed"), ("offset", "the offset all the same")])
def test_what_deviates_where_no_offset_is_determined_is_the_contours(by: str, then: str) -> None:
    """Two cones 5° apart: 1/sin 5° makes 1 µm into 8 µm along either axis. Of 50 µm left on nothing is called enough,
    of what they scatter by it is.
    """
    leans = np.radians([45.0, 45.0, 50.0, 50.0])
    normals = np.column_stack([np.cos(leans), np.sin(leans)])
    found = decide(np.full(4, 0.05), normals, SIGMA_MM, math.inf, 1e-4, 1.0, by)
    assert found.offset_mm == (0.0, 0.0) and not found.offset_is_enough
    assert "Up to 50.0 µm remain at 4 touches" in found.x.words and then in found.x.words
    assert decide(SIGMA_MM * np.array([1.0, -1.0, 0.5, 0.0]), normals, SIGMA_MM, math.inf, 1e-4, 1.0).offset_is_enough


def test_readings_too_vague_for_an_offset_change_the_contour_where_they_deviate_by_more() -> None:
    """One diameter to 30 µm beside a face: an offset along X is not worth it; 200 µm are, of which U holds nothing."""
    normals, sigma = np.array([CYLINDER, FACE]), np.array([0.030, 0.001])
    near, far = (decide(np.array([x, 0.0]), normals, sigma, math.inf, 1e-4, 1.0, vague_mm=0.01) for x in (0.04, 0.2))
    assert near.offset_mm[0] == far.offset_mm[0] == 0.0
    assert near.x.enough and not far.x.enough
    assert "(± 58.8 µm)" in near.x.words and "(± 58.8 µm)" in far.x.words


def test_false_alarms_are_as_rare_as_promised() -> None:
    """Noise alone changes the contour in about 5 % of parts an axis, the significance of the test."""
    random = np.random.default_rng(6811)
    alarms = [
        not decide(random.normal(0, SIGMA_MM, 12), NORMALS, SIGMA_MM, math.inf, 1e-9, 1.0).x.enough for _ in range(2000)
    ]
    assert 0.03 < np.mean(alarms) < 0.07


def test_the_words_say_the_offset_with_its_sign_on_the_radius() -> None:
    """10 µm left on everywhere: the tool is to go 10 µm towards the axis."""
    normals = np.tile([1.0, 0.0], (6, 1))
    found = decide(np.full(6, 0.010), normals, 0.001, np.inf, 0.0001, 1.0)
    assert found.x.words.startswith("X: a constant offset of −10.0 µm ± 0.8 µm (on the radius) would leave")


def test_an_axis_that_one_touch_leans_towards_a_little_gets_no_offset() -> None:
    """Three touches on cylinders, one on a cone of 11.3 degrees: their noise is five times as large along Z."""
    cone = np.radians(11.3)
    normals = np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [np.cos(cone), np.sin(cone)]])
    errors = normals @ [0.015, 0.0] + [0.002, -0.002, 0.0, 0.004]
    found = decide(errors, normals, 0.002, math.inf, 0.0001, 1.0)
    assert found.z.offset_mm == 0.0 and "does not determine" in found.z.words
    assert found.x.offset_mm == pytest.approx(-0.0160, abs=0.0002)
    steep = np.vstack([normals, [[0.0, 1.0], [0.0, 1.0]]])
    known = decide(steep @ [0.015, -0.004], steep, 0.002, math.inf, 0.0001, 1.0)
    assert known.z.offset_mm == pytest.approx(0.004)


def test_touches_that_have_all_in_common_know_an_offset_no_better_than_one() -> None:
    """By hand: of four on a cylinder, two and two alike, the mean has the variance of two."""
    normals = np.tile([1.0, 0.0], (4, 1))
    pairs = np.repeat(np.repeat(np.eye(2), 2, axis=0), 2, axis=1)
    alone = decide(np.zeros(4), normals, 1.0, math.inf, 1e-4, 1.0)
    common = decide(np.zeros(4), normals, 1.0, math.inf, 1e-4, 1.0, correlated=(np.arange(4), pairs))
    assert alone.variance(normals) == pytest.approx(np.full(4, 0.25))
    assert common.variance(normals) == pytest.approx(np.full(4, 0.5))
    assert common.leverage(normals, np.ones(4)) == pytest.approx(np.full(4, 0.25))


def test_what_was_in_force_is_the_offset_and_the_best_one_of_the_contour() -> None:
    """An offset of (3, −2) µm, and a contour that stood 5 µm out on the cylinder and 7 µm back on the face."""
    contour = NORMALS @ [0.005, -0.007]
    found = decide(
        *(errors(0.02, -0.01), NORMALS, SIGMA_MM, 8, 1e-4, 1.0),
        in_force_mm=(0.003, -0.002),
        contour_in_force_mm=contour,
    )
    assert found.in_force_mm == pytest.approx((0.008, -0.009), abs=1e-12)
    assert found.whole_offset_mm == pytest.approx((0.008 - 0.02, -0.009 + 0.01), abs=1e-4)
    assert decide(errors(0.02, -0.01), NORMALS, SIGMA_MM, 8, 1e-4, 1.0).in_force_mm == (0.0, 0.0)


@pytest.mark.parametrize(("freedom", "student"), [(4.0, 2.776445), (8.0, 2.306004), (math.inf, 1.959964)])
def test_u_of_an_offset_by_the_tables_of_student(freedom: float, student: float) -> None:
    """Six touches of σ = 1 µm a side: t · 1 µm/√6, and 1.96 · 3 µm of what moves the next cut as a whole."""
    alone = decide(NORMALS @ [0.02, -0.01], NORMALS, SIGMA_MM, freedom, 1e-4, 1.0)
    assert alone.expanded_u_mm == pytest.approx([student * SIGMA_MM / math.sqrt(6)] * 2, rel=1e-6)
    both = decide(NORMALS @ [0.02, -0.01], NORMALS, SIGMA_MM, freedom, 1e-4, 1.0, common_u_mm=0.003)
    assert both.expanded_u_mm == pytest.approx(
        [math.hypot(student * SIGMA_MM / math.sqrt(6), 1.96 * 0.003)] * 2, rel=1e-5
    )


def test_u_holds_what_touches_deviate_from_any_offset_by() -> None:
    """Residuals of ±10 µm on both sides, 12 touches less two constants: √(12/10) · 10 µm in place of σ."""
    apart = 0.01 * np.tile([1.0, -1.0], 6)
    found = decide(apart, NORMALS, SIGMA_MM, 8.0, 1e-4, 1.0)
    assert found.expanded_u_mm == pytest.approx([2.306004 * math.sqrt(1.2) * 0.01 / math.sqrt(6)] * 2, rel=1e-6)
    bare = decide(np.array([0.02, -0.01]), np.eye(2), SIGMA_MM, 8.0, 1e-4, 1.0)  # none left over
    assert bare.expanded_u_mm == pytest.approx([2.306004 * SIGMA_MM] * 2, rel=1e-6)
