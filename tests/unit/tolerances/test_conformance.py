"""Verdicts and probabilities by ISO 14253-1, against distributions of another library and by hand."""

from statistics import NormalDist

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.tolerances.conformance import guard_band, judge


@pytest.mark.parametrize("value", [-3.0, -0.4, 0.0, 0.7, 1.0, 2.5])
def test_the_probability_of_a_known_uncertainty_is_the_normal_one(value: float) -> None:
    normal = NormalDist(value, 0.5)

    assert judge(value, 0.5, None, -1.0, 1.0).probability_in == pytest.approx(normal.cdf(1.0) - normal.cdf(-1.0))
    assert judge(value, 0.5, None, None, 1.0).probability_in == pytest.approx(normal.cdf(1.0))
    assert judge(value, 0.5, None, -1.0, None).probability_in == pytest.approx(1.0 - normal.cdf(-1.0))


def test_few_degrees_of_freedom_have_students_tails() -> None:
    # Student's t with 1 degree of freedom is Cauchy's: P(|t| ≤ 1) = 1/2; 6.3138 is its printed quantile of 95 %.
    assert judge(0.0, 1.0, 1, -1.0, 1.0).probability_in == pytest.approx(0.5)
    assert guard_band(1.0, 1) == pytest.approx(6.3138, abs=1e-4)
    assert guard_band(2.0, 10) == pytest.approx(2 * 1.8125, abs=2e-4)
    assert guard_band(1.0) == pytest.approx(NormalDist().inv_cdf(0.95))


@pytest.mark.parametrize(
    ("value", "verdict", "margin"),
    [
        (10.0, "in", 0.02),
        (10.0115, "in", 0.0085),
        (10.0119, "undecided", 0.0081),
        (10.0205, "undecided", -0.0005),
        (10.0281, "undecided", -0.0081),
        (10.0285, "out", -0.0085),
        (9.9715, "out", -0.0085),
        (9.9885, "in", 0.0085),
    ],
)
def test_the_guard_band_is_inside_and_outside_both_limits(value: float, verdict: str, margin: float) -> None:
    found = judge(value, 0.005, None, 9.98, 10.02)  # g = 1.645 · 5 µm = 8.22 µm

    assert found.verdict == verdict
    assert found.margin == pytest.approx(margin)


def test_a_zone_narrower_than_two_guard_bands_proves_nothing_to_be_in() -> None:
    found = judge(10.0, 0.005, None, 9.992, 10.008)

    assert found.verdict == "undecided"
    assert found.probability_in == pytest.approx(0.8904, abs=1e-4)  # P(|z| ≤ 1.6)


def test_a_zone_without_width_holds_nothing_that_is_uncertain() -> None:
    assert judge(10.0, 0.001, None, 10.0, 10.0).probability_in == 0.0
    assert judge(10.0, 0.0, None, 10.0, 10.0).probability_in == 1.0
    assert judge(10.1, 0.0, None, 10.0, 10.0).verdict == "out"


def test_without_limits_there_is_no_verdict() -> None:
    found = judge(10.0, 0.005)

    assert (found.verdict, found.probability_in, found.margin) == (None, None, None)


@given(value=st.floats(-5.0, 5.0), u=st.floats(1e-3, 3.0), freedom=st.one_of(st.none(), st.integers(1, 50)))
def test_a_proven_verdict_has_its_probability(value: float, u: float, freedom: int | None) -> None:
    found = judge(value, u, freedom, None, 1.0)

    assert found.probability_in is not None
    assert (found.verdict == "in") == (found.probability_in >= 0.95 - 1e-9) or abs(found.probability_in - 0.95) < 1e-6
    assert (found.verdict == "out") == (found.probability_in <= 0.05 + 1e-9) or abs(found.probability_in - 0.05) < 1e-6
