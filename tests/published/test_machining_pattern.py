"""M. Poniatowska, Free-form surface machining error compensation applying 3D CAD machining pattern model.

Published, §8 and Tables 1 and 2: of three surfaces cut after correction by the pattern of ten parts, by the
deterministic model of one part, and by that part's raw data, the first is the best and the last the worst; the first
stays within ±8 µm; the random part of the last scatters about twice as much as that of the others.

The process is simulated with the published sizes, limits between parts taken as three standard deviations;
docs/surface-study.md tells of other readings. One experiment is three draws of a largest value out of 625, so the order
cannot hold every time: the tests ask for it in the mean of 20 experiments, and for how often it holds.
"""

from functools import cache

import numpy as np

from studies.surface_experiment import Outcome, experiment

SEEDS = 20


@cache
def outcomes() -> list[Outcome]:
    return [experiment(seed) for seed in range(SEEDS)]


def worst(name: str) -> np.ndarray:
    return np.array([outcome.worst_um[name] for outcome in outcomes()])


def test_pattern_before_model_before_raw_data() -> None:
    pattern, model, raw = (float(np.mean(worst(name))) for name in ("pattern", "model", "raw"))
    assert pattern < model < raw - 1.0


def test_the_order_holds_in_more_than_half_of_single_experiments() -> None:
    """docs/surface-study.md tells how often in 100 others, and why not always: a new part each differs by chance."""
    ordered = (worst("pattern") < worst("model")) & (worst("model") < worst("raw"))
    assert np.mean(ordered) > 0.5
    assert np.mean(worst("raw") > worst("pattern")) > 0.9


def test_the_true_pattern_itself_would_hardly_leave_less() -> None:
    assert np.mean(worst("pattern")) - np.mean(worst("true")) < 0.5


def test_corrected_by_the_pattern_about_half_of_the_parts_stay_within_8_um() -> None:
    """Published: its one sample does. With limits between parts of three standard deviations 46 of 100 other parts did
    (docs/surface-study.md); of 20 that is known to two standard errors of 22 %. By the true pattern no more do, by raw
    data hardly any.
    """
    within = {name: np.mean(worst(name) <= 8.0) for name in ("true", "pattern", "raw")}
    assert abs(within["pattern"] - 0.46) < 0.22
    assert abs(within["pattern"] - within["true"]) < 0.22
    assert within["raw"] < 0.1


def test_raw_data_add_their_random_part_to_that_of_the_new_cut() -> None:
    """Two independent random parts add up to √2 of one. The published sample says about twice; one sample may."""
    scatter = {name: np.mean([o.random_um[name] for o in outcomes()]) for name in ("pattern", "model", "raw")}
    assert abs(scatter["raw"] / scatter["pattern"] - np.sqrt(2)) < 0.06
    assert abs(scatter["model"] / scatter["pattern"] - 1) < 0.05


def test_the_true_pattern_lies_within_the_predicted_uncertainty() -> None:
    """Of 95 % intervals, sizes chosen and not known beforehand, in 20 experiments."""
    assert 0.91 < np.mean([outcome.coverage for outcome in outcomes()]) < 0.98
