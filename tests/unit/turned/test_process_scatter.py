"""The process's share of the scatter, against brute integration, limits that are known, and drawn samples."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from tests.support.profiles import facetst
from tests.support.touched import noise, touched
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.error_curve.uncertainty import Spread, far_apart, process_scatter
from trueloop.turned.fit.options import FitOptions

UM2 = 1e-6


def spreads(*groups: tuple[int, float, float]) -> list[Spread]:
    """Spare touches, scatter in µm, probe's standard uncertainty in µm."""
    return [far_apart(n, n * s * s * UM2, u * u * UM2) for n, s, u in groups]


def held_by_integrating(groups: Sequence[Spread], half_width_mm: float) -> float:
    """Probability of the next cut's scatter within ± this, integrated over the logarithm of the variance."""

    def density(log_v: float) -> float:
        v = math.exp(log_v)
        likelihood = -0.5 * sum(
            g.spare * math.log((v + g.probe_mm2) / UM2) + g.total_mm2 / (v + g.probe_mm2) for g in groups
        )
        return v / UM2 * math.exp(likelihood) * math.sqrt(sum(g.spare / ((v + g.probe_mm2) / UM2) ** 2 for g in groups))

    def held(log_v: float) -> float:
        return density(log_v) * math.erf(half_width_mm / math.sqrt(2.0 * math.exp(log_v)))

    limits = math.log(1e-8 * UM2), math.log(1e8 * UM2)
    edges = np.linspace(*limits, 40)
    whole, inside = (sum(quad(f, a, b)[0] for a, b in pairwise(edges)) for f in (density, held))
    return inside / whole


@pytest.mark.parametrize(
    "groups",
    [
        spreads((7, 0.6, 0.35)),
        spreads((2, 0.66, 0.43), (2, 0.52, 0.14), (2, 0.70, 0.43), (1, 0.40, 0.14)),
        spreads((20, 0.3, 0.43)),
        spreads((3, 3.0, 0.3)),
        spreads((2, 2.0, 0.43)),
    ],
)
def test_the_band_holds_95_percent_of_what_is_known_of_the_next_cut(groups: list[Spread]) -> None:
    half_width = coverage_factor(sum(g.spare for g in groups)) * process_scatter(groups).standard_mm
    assert held_by_integrating(groups, half_width) == pytest.approx(0.95, abs=3e-4)


def test_without_a_probes_share_it_is_students_band() -> None:
    """Exactly with none, and in the limit of a small one."""
    assert process_scatter(spreads((7, 0.6, 0.0))).standard_mm == pytest.approx(0.6e-3, rel=1e-12)
    assert process_scatter(spreads((7, 0.6, 0.003))).standard_mm == pytest.approx(0.6e-3, rel=1e-3)


@pytest.mark.parametrize("scatter_um", [0.0, 0.05, 0.2, 0.43, 0.6, 2.0])
def test_it_stays_below_the_touches_scatter_or_the_probes_and_above_nothing(scatter_um: float) -> None:
    """Touches that scatter less than the probe should leave the process little, but never none."""
    found = process_scatter(spreads((7, scatter_um, 0.43))).standard_mm
    assert 0.0 < found <= max(scatter_um, 0.43) * 1e-3


@pytest.mark.parametrize("spare", [3, 7, 20])
@pytest.mark.parametrize("process_um", [0.3, 0.5, 1.2])
def test_drawn_cuts_lie_inside_as_often_as_promised(spare: int, process_um: float) -> None:
    """3,000 parts each: residuals of process and probe together, the next cut of the process alone.

    From σ = 0.5 µm and seven touches to spare on, not much oftener either; never oftener than without telling apart.
    """
    rng = np.random.default_rng(spare)
    total = math.hypot(process_um, 0.43)
    scatter_um = total * np.sqrt(rng.chisquare(spare, 3000) / spare)
    found = np.array([process_scatter(spreads((spare, s, 0.43))).standard_mm for s in scatter_um])
    cuts_mm, k = np.abs(process_um * 1e-3 * rng.standard_normal(3000)), coverage_factor(spare)
    held = float(np.mean(cuts_mm <= k * found))
    assert held > 0.94
    assert (
        held < 0.98
        if process_um >= 0.5 and spare >= 7
        else held <= np.mean(cuts_mm <= k * np.maximum(scatter_um, 0.43) * 1e-3)
    )


def test_a_profile_tells_process_from_probe() -> None:
    """500 touches that scatter by s, of which the probe is known for 0.4 µm: the next cut scatters by √(s² − 0.16).

    They lie 0.4 mm apart, and it is said that they have nothing in common.
    """
    profile = facetst()
    vectors = touched(profile, [125] * len(profile.features), noise(0.6e-3), standard_u_mm=0.4e-3)
    model = fit_profile(profile, vectors, FitOptions(alike_over_mm=0.0))
    expected_mm = math.sqrt(model.scatter_mm**2 - 0.4e-3**2)
    assert model.curves[0].repeatability_mm == pytest.approx(expected_mm, rel=0.02)
