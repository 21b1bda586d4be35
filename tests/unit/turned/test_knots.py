"""The knot rule, and what gives way when touches are few."""

import numpy as np
import pytest

from trueloop.turned.fit.chain_fit import Knots, TangentPolicy, candidates, every_rth, fit_determined, joint_repeats
from trueloop.turned.fit.spline import EndConditions

NONE = Knots((), (), 0)


def test_every_rth_point_is_counted_from_the_first() -> None:
    """[6517 Eq. 5]: t_j = x_{jr}."""
    assert every_rth(np.arange(1.0, 12.0), (0.0,), 20.0, 3) == (3.0, 6.0, 9.0)


def test_a_point_on_a_junction_is_no_knot() -> None:
    assert every_rth(np.array([2.0, 4.0, 6.0, 8.0]), (0.0, 4.0), 8.0, 2) == ()


def test_candidates_give_every_number_of_knots_up_to_nine() -> None:
    for points in (2, 5, 20, 100, 1000):
        tried = candidates(points)
        assert tried == sorted(tried, reverse=True)
        assert min(tried) == 2
        assert max(tried) == max(points, 2)
    assert {1000 // r for r in candidates(1000)} >= set(range(1, 10))


def test_joints_are_continuous_or_tangent() -> None:
    assert [joint_repeats(TangentPolicy.PART, degree) for degree in (1, 2, 3)] == [1, 2, 3]
    assert [joint_repeats(TangentPolicy.PATH, degree) for degree in (1, 2, 3)] == [0, 1, 2]


@pytest.mark.parametrize(("touches", "degree"), [(1, 0), (2, 1), (3, 2), (4, 3), (5, 3)])
def test_the_degree_is_lowered_to_what_the_touches_carry(touches: int, degree: int) -> None:
    s = np.linspace(1.0, 9.0, touches)
    fit, kept = fit_determined(s, s**2, NONE, 10.0, 3, EndConditions())
    assert fit.spline.degree == degree
    assert kept == NONE
    if degree == 2:
        np.testing.assert_allclose(fit.residual_mm, 0.0, atol=1e-12)


def test_knots_go_before_the_degree_and_joints_last() -> None:
    """Six touches, all before 4: the knots beyond them cannot be told, the first can; the joint among them stays."""
    s = np.array([0.5, 1.0, 1.5, 2.5, 3.0, 3.5])
    fit, kept = fit_determined(s, np.sin(s), Knots((6.0, 8.0), (2.0,), 1), 10.0, 3, EndConditions())
    assert fit.spline.degree == 3
    assert kept == Knots((), (2.0,), 1)


def test_a_knot_on_the_last_point_goes_unless_the_end_is_prescribed() -> None:
    s = np.arange(1.0, 10.0)
    knots = Knots((9.0,), (), 0)
    free, without = fit_determined(s, np.sin(s), knots, 12.0, 3, EndConditions())
    assert without.at_points_mm == ()
    held, kept = fit_determined(s, np.sin(s), knots, 12.0, 3, EndConditions(end_value_mm=0.0))
    assert kept == knots
    assert len(held.spline.coefficients_mm) == len(free.spline.coefficients_mm) + 1
