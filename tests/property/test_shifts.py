"""Shifts are data: sums, products and slopes of any of them hold at any arc length, and JSON changes no number."""

import pickle
from collections.abc import Callable

import numpy as np
from hypothesis import assume, example, given
from hypothesis import strategies as st

from tests.support.touched import touched
from trueloop.arrays import Array
from trueloop.domain.codec import Codec
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.validate import checked_profile
from trueloop.turned.compensation.displaced import Constant, Then
from trueloop.turned.compensation.shift import ZERO, Shift, constant, of_curve, product, sampled, weighted_sum
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.options import FitOptions

CODEC = Codec.of(Shift, Constant, Then)
PLACES = np.linspace(-25.0, 25.0, 401)
lengths = st.floats(-20.0, 20.0)
sizes = st.floats(-0.1, 0.1)
weights = st.floats(-2.0, 2.0)
seeds = st.integers(0, 2**32 - 1)


@st.composite
def shifts(draw: st.DrawFn) -> Shift:
    """Of up to five polynomials of up to third degree."""
    breaks = np.array(sorted(draw(st.lists(st.integers(-80, 80), max_size=4, unique=True))), dtype=float) / 4
    degree = draw(st.integers(0, 3))
    rows = draw(st.lists(sizes, min_size=(len(breaks) + 1) * (degree + 1), max_size=(len(breaks) + 1) * (degree + 1)))
    return Shift(breaks, np.reshape(rows, (len(breaks) + 1, degree + 1)) / 20.0 ** np.arange(degree + 1))


def near_break(shift: Shift, s: float, within_mm: float) -> bool:
    return bool(np.any(np.abs(shift.breaks_mm - s) < within_mm))


@given(shifts(), st.lists(lengths, min_size=1))
def test_json_and_pickle_give_equal_shifts_with_the_same_numbers(shift: Shift, places: list[float]) -> None:
    for back in (CODEC.from_json(CODEC.to_json(shift), Shift), pickle.loads(pickle.dumps(shift))):
        assert back == shift
        np.testing.assert_array_equal(back.value_mm(places), shift.value_mm(places))
        np.testing.assert_array_equal(back.slope(places), shift.slope(places))


@given(shifts(), shifts())
def test_shifts_of_other_content_differ(one: Shift, other: Shift) -> None:
    if one == other:
        np.testing.assert_array_equal(one.value_mm(PLACES), other.value_mm(PLACES))
    assert weighted_sum(((1.0, one), (1.0, constant(1.0)))) != one


@given(st.lists(st.tuples(weights, shifts()), min_size=1, max_size=4))
def test_a_weighted_sum_is_the_sum_of_its_parts(parts: list[tuple[float, Shift]]) -> None:
    whole = weighted_sum(tuple(parts))
    values = sum(weight * part.value_mm(PLACES) for weight, part in parts)
    slopes = sum(weight * part.slope(PLACES) for weight, part in parts)
    np.testing.assert_allclose(whole.value_mm(PLACES), values, atol=1e-13)
    np.testing.assert_allclose(whole.slope(PLACES), slopes, atol=1e-13)


@given(shifts(), shifts())
def test_a_product_is_the_product_of_both(one: Shift, other: Shift) -> None:
    expected = one.value_mm(PLACES) * other.value_mm(PLACES)
    np.testing.assert_allclose(product(one, other).value_mm(PLACES), expected, atol=1e-13)


@given(shifts(), lengths)
def test_the_slope_is_the_finite_difference_away_from_breaks(shift: Shift, s: float) -> None:
    step = 1e-4
    assume(not near_break(shift, s, 2 * step))
    difference = (shift.value_mm(s + step) - shift.value_mm(s - step)) / (2 * step)
    np.testing.assert_allclose(shift.slope(s), difference, atol=1e-9)
    np.testing.assert_array_equal(shift.slope(PLACES), shift.derivative().value_mm(PLACES))


@given(shifts(), st.floats(1e-4, 0.05))
@example(Shift(np.zeros(0), np.array([[0.0625, 5e-29]])), 0.03125)  # it reaches the limit 10^26 mm away
@example(Shift(np.zeros(1), np.array([[0.0, 0.0, 0.0], [0.0, 3.125e-3, 3.5e-28]])), 0.03125)  # twice: 10 mm and 10^25
def test_clipped_it_is_what_clipping_its_numbers_gives(shift: Shift, most_mm: float) -> None:
    expected = np.clip(shift.value_mm(PLACES), -most_mm, most_mm)
    np.testing.assert_allclose(shift.clipped(most_mm).value_mm(PLACES), expected, atol=1e-9)


@given(shifts(), st.floats(-20.0, 0.0), st.floats(0.1, 20.0))
def test_carried_straight_it_goes_on_along_its_tangents(shift: Shift, start_mm: float, length_mm: float) -> None:
    end_mm = start_mm + length_mm
    carried = shift.carried_straight(start_mm, end_mm)
    inside = PLACES[(start_mm < PLACES) & (end_mm > PLACES)]
    np.testing.assert_allclose(carried.value_mm(inside), shift.value_mm(inside), atol=1e-13)
    for edge, before in ((start_mm, 0.0), (end_mm, 1e-9)):
        if near_break(shift, edge, 2e-9):
            continue
        beyond = np.array([-3.0, 0.0] if edge == start_mm else [0.0, 3.0])
        straight = shift.value_mm(edge - before) + shift.slope(edge - before) * (beyond + before)
        np.testing.assert_allclose(carried.value_mm(edge + beyond), straight, atol=1e-9)


@given(st.lists(st.tuples(st.integers(-80, 80), sizes), min_size=1, max_size=9, unique_by=lambda pair: pair[0]))
def test_sampled_it_is_linear_between_the_samples(pairs: list[tuple[int, float]]) -> None:
    s, values = np.array(sorted(pairs), dtype=float).T / [[4.0], [1.0]]
    inside = np.linspace(s[0], s[-1], 50)
    np.testing.assert_allclose(sampled(s, values).value_mm(inside), np.interp(inside, s, values), atol=1e-15)


LINE_AND_ARCS = checked_profile(
    [
        Line("cone", (30.0, -20.0), (20.0, 0.0)),
        Arc("dome", (20.0, 0.0), (14.142135623730951, 14.142135623730951), (0.0, 0.0), np.pi / 4),
        Arc("cap", (14.142135623730951, 14.142135623730951), (0.0, 20.0), (0.0, 0.0), np.pi / 4),
    ]
)


def rough(seed: int) -> Callable[[Array, Array], Array]:
    return lambda points, normals: np.random.default_rng(seed).normal(0.0, 0.02, len(points))


@given(seeds, st.sampled_from(TangentPolicy), st.integers(2, 5))
def test_an_error_curve_is_the_same_as_polynomials(seed: int, policy: TangentPolicy, knot_every: int) -> None:
    """On features, beyond their ends, and where one curve runs over two arcs: to a picometre, far below the 1 nm that
    any program resolves."""
    vectors = touched(LINE_AND_ARCS, [3, 9, 7], rough(seed))
    model = fit_profile(LINE_AND_ARCS, vectors, FitOptions(policy, knot_every))
    for curve in model.curves:
        shift = of_curve(curve)
        s = np.linspace(-2.0, curve.length_mm + 2.0, 301)
        np.testing.assert_allclose(shift.value_mm(s), curve.value_mm(s), rtol=0, atol=1e-9)
        np.testing.assert_allclose(shift.slope(s), curve.slope(s), rtol=0, atol=1e-9)


@given(st.tuples(sizes, sizes), st.tuples(sizes, sizes))
def test_displacements_add_and_survive_json_and_pickle(one: tuple[float, float], other: tuple[float, float]) -> None:
    both = Then(Constant(one), Constant(other))
    at = np.array([[20.0, 3.0], [0.0, -4.0]])
    np.testing.assert_allclose(both.displacement_mm(at), np.tile(np.add(one, other), (2, 1)), atol=1e-15)
    assert CODEC.from_json(CODEC.to_json(both), Then) == both == pickle.loads(pickle.dumps(both))


def test_nothing_moves_what_stays() -> None:
    assert weighted_sum(((-1.0, ZERO), (0.5, ZERO))) == ZERO
    assert ZERO.value_mm(3.0).shape == () and not ZERO.value_mm([1.0, 2.0]).any() and not ZERO.slope([1.0]).any()
