"""Centre, limits and signals beside those of pycontrolcharts, which marks whole runs where ours marks their end."""

import numpy as np
import pytest
from pycontrolcharts import CustomLimits, RunTestConfig, calc_xmr, run_tests_with_custom_limits

from trueloop.arrays import Array
from trueloop.monitoring.charts import RULES, Rule, baseline, individuals, moving_range

TYPES = {2: (3, 4), 5: (7, 8)}
"""Their numbers of what they find of each test, above and below: all parts of the run. Of test 6 they miss runs."""
RNG = np.random.default_rng(7870)
SERIES = [RNG.normal(4.0, 3.0, 40) + shift * (np.arange(40) >= 25) for shift in (0.0, 4.0, -6.0, 12.0)]


def rule_named(number: int) -> Rule:
    return next(rule for rule in RULES if rule.number == number)


@pytest.mark.parametrize("values", SERIES, ids=("0 µm", "4 µm", "-6 µm", "12 µm"))
def test_centre_and_limits(values: Array) -> None:
    theirs, base = calc_xmr(values.tolist()), baseline(values)
    close = 1e-3 * 6.0 * base.sigma  # they take d2 = 1.128 and D4 = 3.267 with four digits
    chart, ranges = individuals(values, base), moving_range(values, base)
    assert chart.centre == pytest.approx(theirs["center_line"].iloc[0])
    assert chart.low[0] == pytest.approx(theirs["lcl"].iloc[0], abs=close)
    assert chart.high[-1] == pytest.approx(theirs["ucl"].iloc[-1], abs=close)
    assert ranges.plotted[1:] == pytest.approx(theirs["variation"].to_numpy(dtype=float)[1:])
    assert ranges.centre == pytest.approx(theirs["variation_cl"].iloc[1], abs=close)
    assert ranges.high[1] == pytest.approx(theirs["variation_ucl"].iloc[1], abs=close)


@pytest.mark.parametrize("values", SERIES, ids=("0 µm", "4 µm", "-6 µm", "12 µm"))
def test_values_beyond_three_sigma(values: Array) -> None:
    only = RunTestConfig(test1=True, test2=None, test3=None, test5=None, test6=None)
    theirs = calc_xmr(values.tolist(), run_tests=only)
    marked = [k for k, found in enumerate(theirs["violations"]) if found]
    assert [alarm.index for alarm in individuals(values, baseline(values)).alarms] == marked


LIMITS = CustomLimits(0.0, 3.0, -3.0, sigma_1_upper=1.0, sigma_1_lower=-1.0, sigma_2_upper=2.0, sigma_2_lower=-2.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("number", TYPES)
def test_runs_on_one_side_are_found_where_theirs_are(number: int, side: float) -> None:
    """On one side of the centre: theirs ends a run at a value on the other side, and begins the next after it."""
    series = [side * np.abs(RNG.normal(size=30) * RNG.uniform(0.3, 1.6)) for _ in range(60)]
    found = []
    for z in series:
        violations = run_tests_with_custom_limits(z.tolist(), limits=LIMITS)["violations"]
        theirs = {k for k, of_it in enumerate(violations) for one in of_it if one["type"] in TYPES[number]}
        ours = np.flatnonzero(rule_named(number).marks(z)).tolist()
        assert bool(ours) == bool(theirs) and set(ours[:1]) <= theirs
        found.append(bool(ours))
    assert any(found)
