"""The model against itself written apart: every term a vector of its own, conditioned in information form; by hand."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.memory.edge.parts import errors, series
from trueloop.arrays import Array
from trueloop.memory.edge.expect import expect
from trueloop.memory.edge.fit import Badness
from trueloop.memory.edge.hyperparameters import LOG_SD, MEDIAN, NAMES, Hyperparameters
from trueloop.memory.edge.innovation import innovations
from trueloop.memory.edge.observations import observations
from trueloop.memory.edge.options import MemoryOptions
from trueloop.memory.edge.predict import predict, sizes
from trueloop.memory.made_part import ArcErrors, MadePart

FEW = np.radians([8.0, 30.0, 47.0, 80.0])


class Written:
    """The latent terms of some parts at some angles, each with its own prior; what is observed is a sum of them."""

    def __init__(self, parts: list[MadePart], angles: Array, size: Hyperparameters) -> None:
        self.parts, self.angles, self.size = parts, list(angles), size
        self.columns: dict[tuple[object, ...], int] = {}
        blocks: list[Array] = []
        gap = np.abs(angles[:, None] - angles[None, :])

        def form(sd: float, length: float) -> Array:
            r = np.sqrt(5) * gap / length
            return np.asarray(sd**2 * (1 + r + r**2 / 3) * np.exp(-r))

        def add(name: tuple[object, ...], covariance: Array) -> None:
            start = sum(map(len, blocks))
            self.columns[name] = start
            blocks.append(covariance)

        edge, finish = size["angle_rad"], size["finish_angle_rad"]
        add(("w",), form(size["nose_mm"], edge))
        add(("d",), form(size["finish_mm"], finish))
        add(("d offset",), size["finish_mm"] ** 2 * np.eye(2))
        for name in sorted({part.part_type for part in parts}):
            add(("type", name), size["setting_mm"] ** 2 / 2 * np.eye(2))
            add(("d type", name), form(size["finish_type_mm"], finish))
            add(("d type offset", name), size["finish_type_mm"] ** 2 * np.eye(2))
        for name in sorted({part.setting for part in parts}):
            add(("setting", name), size["setting_mm"] ** 2 / 2 * np.eye(2))
        for k in range(len(parts)):
            # Walks are sums of steps: of wear from the part before, of the offset from the part before of the setting.
            add(("wear step", k), form(size["wear_mm"], edge))
            add(("walk step", k), size["walk_mm"] ** 2 * np.eye(2))
            add(("clamping", k), size["clamping_mm"] ** 2 * np.eye(2))
            add(("g", k), form(size["part_mm"], edge))
            add(("d part", k), form(size["finish_part_mm"], finish))
            add(("d part offset", k), size["finish_part_mm"] ** 2 * np.eye(2))
        self.total = sum(map(len, blocks))
        self.precision = np.zeros((self.total, self.total))
        start = 0
        for block in blocks:
            end = start + len(block)
            self.precision[start:end, start:end] = np.linalg.inv(block + 1e-15 * np.eye(len(block)))
            start = end

    def row(self, k: int, finish: bool, angle: float) -> Array:
        """What an error of part k at an angle is the sum of."""
        row, place, part = np.zeros(self.total), self.angles.index(angle), self.parts[k]
        turn = np.array([np.sin(angle), np.cos(angle)])

        def form(*name: object) -> None:
            row[self.columns[name] + place] += 1.0

        def offset(*name: object) -> None:
            row[self.columns[name] : self.columns[name] + 2] += turn

        form("w")
        form("g", k)
        offset("type", part.part_type)
        offset("setting", part.setting)
        offset("clamping", k)
        for earlier in range(1, k + 1):
            form("wear step", earlier)
            if self.parts[earlier - 1].setting == self.parts[earlier].setting == part.setting:
                offset("walk step", earlier)
        if finish:
            form("d")
            offset("d offset")
            form("d type", part.part_type)
            offset("d type offset", part.part_type)
            form("d part", k)
            offset("d part offset", k)
        return row

    def expected(self, angles: Array) -> tuple[Array, Array]:
        """Mean and covariance of the last part's finish errors, given all before and its own touches."""
        rows, values, weights = [], [], []
        noise = self.size["noise_mm"] ** 2 + 1e-10
        for k, part in enumerate(self.parts):
            seen = [(part.semifinish, False, part.semifinish.error_mm)]
            if k < len(self.parts) - 1 and part.finish is not None and part.uncorrected_mm is not None:
                seen.append((part.finish, True, part.uncorrected_mm))
            for of, finish, value in seen:
                for angle, one, u in zip(of.contact_angle_rad, value, of.standard_u_mm, strict=True):
                    rows.append(self.row(k, finish, float(angle)))
                    values.append(one)
                    weights.append(1.0 / (noise + u**2))
        observed, inverse = np.array(rows), np.array(weights)
        covariance = np.linalg.inv(self.precision + observed.T @ (inverse[:, None] * observed))
        mean = covariance @ observed.T @ (inverse * np.array(values))
        asked = np.array([self.row(len(self.parts) - 1, True, float(angle)) for angle in angles])
        return asked @ mean, asked @ covariance @ asked.T + noise * np.eye(len(angles))


def test_expectation_is_that_of_the_model_written_apart() -> None:
    """Two types and two settings, of unequal touches: means to a nanometre, standard uncertainties to one too."""
    rng, parts = np.random.default_rng(4), []
    for k in range(5):
        angle = FEW if k % 2 else FEW[:3]
        touched = 0.01 * np.sin(2 * angle) + 0.003 * rng.normal(size=len(angle))
        finish = errors(0.003 * rng.normal(size=len(angle)), angle)
        parts.append(
            MadePart(
                "AB"[k % 2], str(k), "old" if k < 3 else "new", float(k), errors(touched, angle), finish, touched * 1.1
            )
        )
    today = replace(parts[-1], finish=None, correction_mm=None)
    found = expect(parts[:-1], today, FEW[1:3], MemoryOptions())
    mean, covariance = Written(parts, FEW, sizes(parts[:-1])).expected(FEW[1:3])
    np.testing.assert_allclose(found.mean_mm, mean, atol=1e-6)
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance_mm2)), np.sqrt(np.diag(covariance)), atol=1e-6)
    np.testing.assert_allclose(found.covariance_mm2, covariance, atol=1e-8)


def test_one_touch_by_hand() -> None:
    """With sizes as believed beforehand, on the cylinder, in µm²: w 400, setting 400, clamping 4, g 2.25 are shared by
    both cuts, 806.25; the touch scatters by 2.25 besides, the finish cut by 2.25 and 2 (25 + 1 + 4) = 60.
    """
    touch = ArcErrors(("dome",), ("1",), np.array([np.pi / 2]), np.array([0.040]), np.zeros(1))
    today = MadePart("dome", "1", "1", 0.0, touch)
    found = expect((), today, np.array([np.pi / 2]), MemoryOptions())
    assert 1000 * found.mean_mm[0] == pytest.approx(40 * 806.25 / 808.5, abs=1e-4)
    after = 806.25 + 60 + 2.25 - 806.25**2 / 808.5
    assert 1e6 * found.covariance_mm2[0, 0] == pytest.approx(1.3 * after, abs=1e-3)
    assert found.own_fit and found.memory_mm[0] == 0.0 and found.enough_touches == 1


def normal_logarithm(value: Array, covariance: Array) -> float:
    """Of the normal density, by eigenvalues."""
    values, vectors = np.linalg.eigh(covariance)
    return float(-0.5 * np.sum((vectors.T @ value) ** 2 / values) - 0.5 * np.sum(np.log(2 * np.pi * values)))


def test_innovations_multiply_up_to_the_density_of_all_errors() -> None:
    """log p(S, E | earlier) = log p(S | earlier) + log p(E | S, earlier): both innovations, of the right covariance."""
    parts = series(4)
    before, after = innovations(parts[:-1], parts[-1])
    assert before.stage != after.stage and not np.any(before.correction_mm)
    found, uncorrected = predict(parts[:-1], parts[-1]).before, parts[-1].uncorrected_mm
    assert uncorrected is not None
    together = np.concatenate([parts[-1].semifinish.error_mm, uncorrected]) - found.mean_mm
    whole = normal_logarithm(together, found.covariance_mm2)
    both = sum(normal_logarithm(one.error_mm, one.covariance_mm2) for one in (before, after))
    assert both == pytest.approx(whole, abs=1e-5)


@pytest.mark.parametrize("gain_sd", [0.0, 0.3])
def test_gradient_is_that_of_finite_differences(gain_sd: float) -> None:
    rng, seen = np.random.default_rng(1), observations(series(3))
    badness, at = Badness(seen, gain_sd), MEDIAN + 0.3 * rng.normal(size=len(MEDIAN))
    slope = badness.of(at)[1]
    for k, name in enumerate(NAMES):
        step = 1e-4 * np.eye(len(MEDIAN))[k]
        difference = (badness.of(at + step)[0] - badness.of(at - step)[0]) / 2e-4
        assert slope[k] == pytest.approx(difference, abs=2e-3, rel=1e-4), name


def test_likelihood_is_that_of_the_joint_density() -> None:
    """Up to the constants of the densities: the difference between two sets of sizes."""
    from trueloop.memory.edge.posterior import joint

    seen = observations(series(3))
    values = []
    for at in (MEDIAN, MEDIAN + 0.4):
        covariance = joint(seen, Hyperparameters(at)).covariance_mm2
        prior = -0.5 * float(np.sum(((at - MEDIAN) / LOG_SD) ** 2))
        values.append((Badness(seen, 0.0).of(at)[0], normal_logarithm(seen.error_mm, covariance) + prior))
    assert values[0][0] - values[1][0] == pytest.approx(values[1][1] - values[0][1], rel=1e-6)
