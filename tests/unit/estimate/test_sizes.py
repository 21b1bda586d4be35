"""Sizes of the terms: the gradient by differences, and sizes that data show."""

from time import process_time

import numpy as np
import pytest

from tests.support.cut_places import CYLINDER, FACE, places, touches
from trueloop.estimate import sizes
from trueloop.estimate.catalogue import turned_catalogue
from trueloop.estimate.places import Observed
from trueloop.estimate.sizes import Badness, fitted_sizes
from trueloop.estimate.state import State

CATALOGUE = turned_catalogue()
ANGLES = np.linspace(FACE, CYLINDER, 7)


def parts() -> list[Observed]:
    """Both cuts of three parts, one of them by differences."""
    rng = np.random.default_rng(4)
    cuts = [places(ANGLES, ANGLES, ANGLES / 2, part=k, finish=finish) for k in (1, 2, 3) for finish in (False, True)]
    seen = [touches(at, rng.normal(5, 10, len(at)), 0.5) for at in cuts]
    from_first = np.eye(7)[1:] - np.eye(7)[0]
    return [*seen[:-1], Observed(cuts[-1], rng.normal(0, 0.01, 6), np.full(6, 5e-4), from_first)]


def test_the_gradient_is_that_of_the_value() -> None:
    badness = Badness(CATALOGUE, parts())
    at = CATALOGUE.logarithms(CATALOGUE.medians) + 0.1
    _, gradient = badness.of(at)
    for k in range(len(at)):
        step = np.zeros(len(at))
        step[k] = 1e-4
        slope = (badness.of(at + step)[0] - badness.of(at - step)[0]) / 2e-4
        assert gradient[k] == pytest.approx(slope, abs=2e-4)


def test_the_likelihood_is_that_of_the_state() -> None:
    """−log p of values given in turn, from the innovations of the state, against the batch: the same differences."""
    seen = parts()

    def in_turn(sizes: dict[str, float]) -> float:
        state, total = State.before(CATALOGUE, sizes), 0.0
        for one in seen:
            updated = state.given(one, robust=False)
            off, covariance = updated.innovation.mean_mm, updated.innovation.covariance_mm2
            total += 0.5 * float(off @ np.linalg.solve(covariance, off)) + 0.5 * np.linalg.slogdet(covariance)[1]
            state = updated.state
        return total

    def prior(at: np.ndarray) -> float:
        log_sd = np.array([one.log_sd for one in CATALOGUE.priors.values()])
        return 0.5 * float(np.sum(((at - CATALOGUE.logarithms(CATALOGUE.medians)) / log_sd) ** 2))

    one, other = (CATALOGUE.logarithms(CATALOGUE.medians) + shift for shift in (0.0, 0.3))
    badness = Badness(CATALOGUE, seen)
    batch = badness.of(other)[0] - prior(other) - badness.of(one)[0] + prior(one)
    assert batch == pytest.approx(in_turn(CATALOGUE.sizes(other)) - in_turn(CATALOGUE.sizes(one)), abs=1e-6)


def test_sizes_are_fitted_once_to_the_same_values_and_anew_to_other_uncertainties(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A digit of a value, the uncertainty of the instrument and the name of a feature make other values."""
    fits, search = list[None](), sizes._most_probable

    def counted(*given: object) -> dict[str, float]:
        fits.append(None)
        return search(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(sizes, "_most_probable", counted)

    def seen(u_um: float = 0.5, group: str = "a", more_um: float = 0.0) -> Observed:
        return touches(places(ANGLES, group=group), 30 * np.sin(3 * ANGLES) + more_um, u_um)

    first = fitted_sizes(CATALOGUE, [seen()])
    count = len(fits)
    assert count and fitted_sizes(CATALOGUE, [seen()]) == first and len(fits) == count
    precise, coarse = first["repeatability"], fitted_sizes(CATALOGUE, [seen(u_um=20.0)])["repeatability"]
    assert coarse != precise and len(fits) > count
    for other in (seen(group="b"), seen(more_um=1e-9)):
        count = len(fits)
        fitted_sizes(CATALOGUE, [other])
        assert len(fits) > count


def test_a_large_setting_is_believed_and_nothing_measured_leaves_the_medians() -> None:
    far = [touches(places(ANGLES, part_type=f"t{k}"), 200 * np.sin(ANGLES) * (-1) ** k, 0.5) for k in range(4)]
    assert fitted_sizes(CATALOGUE, far)["setting"] > 0.05
    assert fitted_sizes(CATALOGUE, []) == CATALOGUE.medians


def test_a_value_and_its_gradient_cost_no_more_where_means_of_a_scan_were_measured() -> None:
    """Ten means over 40 or over 2,000 places each: what depends on the number of places is done once."""

    def took_s(each: int) -> float:
        angles = np.linspace(FACE, CYLINDER, 10 * each)
        means = np.kron(np.eye(10), np.full(each, 1.0 / each))
        badness = Badness(CATALOGUE, [Observed(places(angles), np.full(10, 0.01), np.full(10, 5e-4), means)])
        at, times = CATALOGUE.logarithms(CATALOGUE.medians), list[float]()
        for _ in range(9):
            begun = process_time()
            badness.of(at)
            times.append(process_time() - begun)
        return min(times)

    assert took_s(2000) < 3.0 * took_s(40)
