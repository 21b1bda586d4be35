"""Indices and their intervals by hand arithmetic, and by how often an interval holds the true index."""

import numpy as np
import pytest
from scipy import stats

from trueloop.errors import Code, TrueloopError
from trueloop.monitoring.capability import capability, nearer_limit
from trueloop.monitoring.charts import Baseline, baseline


def test_bissell_s_interval_by_hand() -> None:
    """n = 50, ν = 49, P = (10 − 4) / (3 · 1) = 2: 1.959964 √(1/450 + 4/98) = 0.406609."""
    index = nearer_limit("P", 0.5, 10.0, 5.0, 1.0, 50, 49.0, 0.95)
    assert index.name == "Ppk" and index.value == pytest.approx(1.5)  # the lower limit is nearer: 4.5 / 3
    index = nearer_limit("C", None, 10.0, 4.0, 1.0, 50, 49.0, 0.95)
    assert index.name == "Cpk" and index.value == pytest.approx(2.0)
    assert (index.low, index.high) == pytest.approx((2.0 - 0.406609, 2.0 + 0.406609), abs=1e-6)
    at_90 = nearer_limit("C", -2.0, None, 4.0, 1.0, 50, 49.0, 0.90)
    assert at_90.high == pytest.approx(2.0 + 0.406609 * 1.644854 / 1.959964, abs=1e-6)


def test_bissell_s_interval_holds_the_true_index_as_often_as_it_says() -> None:
    """Normal values of σ 1 whose nearer limit is 4 σ off: Ppk 4/3. Twice the variance would hold it in 99.4 %."""
    values = np.random.default_rng(1990).normal(0.0, 1.0, (2000, 50))
    found = [
        nearer_limit("P", None, 4.0, mean, s, 50, 49.0, 0.95)
        for mean, s in zip(values.mean(axis=1), values.std(axis=1, ddof=1), strict=True)
    ]
    held = np.mean([index.low < 4.0 / 3.0 < index.high for index in found if index.low and index.high])
    assert len(found) == 2000 and 0.935 < held < 0.965


def test_all_indices_of_four_values() -> None:
    """3, 5, 5, 7: mean 5, s = √(8/3) by n − 1; moving ranges 2, 0, 2, whose mean 4/3 over 1.128379 is short-term."""
    found = capability(np.array([3.0, 5.0, 5.0, 7.0]), 0.0, 12.0, base=Baseline(5.0, 4.0 / 3.0 / 1.128379, 4))
    s, short = np.sqrt(8.0 / 3.0), 4.0 / 3.0 / 1.128379
    assert (found.count, found.mean, found.sigma, found.short_sigma) == pytest.approx((4, 5.0, s, short))
    values = {index.name: index for index in found.indices}
    expected = {"Pp": 12 / (6 * s), "Ppk": 5 / (3 * s), "Cp": 12 / (6 * short), "Cpk": 5 / (3 * short)}
    assert {name: index.value for name, index in values.items()} == pytest.approx(expected)
    for name, freedom in (("P", 3.0), ("C", 0.62 * 3)):
        low, high = (np.sqrt(stats.chi2.ppf(p, freedom) / freedom) for p in (0.025, 0.975))
        index = values[f"{name}p"]
        assert (index.low, index.high) == pytest.approx((low * expected[f"{name}p"], high * expected[f"{name}p"]))
        nearer = values[f"{name}pk"]
        assert nearer.value is not None and nearer.high is not None
        half = 1.959964 * np.sqrt(1.0 / 36.0 + nearer.value**2 / (2.0 * freedom))
        assert nearer.high - nearer.value == pytest.approx(half, rel=1e-6)


def test_chi_squared_is_that_of_tables() -> None:
    """ν = 24: 12.4012 and 39.3641. With s = 1 over limits 12 apart Pp = 2 lies in 1.4377 … 2.5614."""
    values = np.array([-1.0, 1.0] * 12 + [0.0])
    pp = capability(values, -6.0, 6.0).indices[0]
    assert pp.name == "Pp" and pp.value == pytest.approx(2.0)
    assert (pp.low, pp.high) == pytest.approx((2 * np.sqrt(12.4012 / 24), 2 * np.sqrt(39.3641 / 24)), abs=2e-5)


def test_without_a_limit_there_is_no_index_of_both() -> None:
    values = np.array([1.0, 2.0, 1.5, 1.0, 2.5, 1.0, 2.0, 1.5])
    found = {index.name: index.value for index in capability(values, None, 4.0).indices}
    assert found["Pp"] is None and found["Cp"] is None
    assert found["Ppk"] == pytest.approx((4.0 - values.mean()) / (3 * values.std(ddof=1)))
    assert found["Cpk"] == pytest.approx((4.0 - values.mean()) / (3 * baseline(values).sigma))


@pytest.mark.parametrize(("lower", "upper"), [(None, None), (3.0, 3.0), (4.0, 3.0)])
def test_limits_that_say_nothing_are_refused(lower: float | None, upper: float | None) -> None:
    with pytest.raises(TrueloopError) as refusal:
        capability(np.arange(9.0), lower, upper)
    assert refusal.value.code is Code.MON_LIMITS
