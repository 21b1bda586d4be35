"""The simulated shop: forms of worn edges by geometry, growth by its time constants, events where they belong."""

from dataclasses import replace

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop_lab.simulator.series import (
    ANGLES,
    Event,
    Series,
    Shop,
    What,
    draw,
    flat,
    notch,
    other_form,
    other_radius,
    warming,
    wear,
)

SHOP = Shop(parts=8)


def drawn(*events: Event, shop: Shop = SHOP, seed: int = 11) -> Series:
    return draw(shop, np.random.default_rng(seed), events)


def cut_by(points: Array, normal_rad: float) -> float:
    """How far a nose, given as points (2, many) in (x, z), comes along an outward normal of the part: the least n·p."""
    return float((np.array([np.sin(normal_rad), np.cos(normal_rad)]) @ points).min())


def nose_points(centre: float, radius: float) -> Array:
    """A nose about (centre, centre)."""
    turn = np.linspace(0, 2 * np.pi, 200_001)
    return np.asarray(centre + radius * np.stack([np.sin(turn), np.cos(turn)]))


def test_a_flat_leaves_on_what_the_nose_no_longer_reaches() -> None:
    """A nose of 0.8 mm without what lies beyond a line 10 µm inside it: the least n·p of points."""
    whole, middle = nose_points(0.0, 0.8), 0.7
    along = np.array([np.sin(middle), np.cos(middle)]) @ whole
    worn = whole[:, along >= -0.790]
    angles = middle + np.array([-0.3, -0.12, -0.05, 0.0, 0.03, 0.1, 0.2])
    left_on = [cut_by(worn, angle) - cut_by(whole, angle) for angle in angles]
    assert flat(angles, middle, 0.010) == pytest.approx(left_on, abs=1e-5)
    assert max(left_on) == pytest.approx(0.010, abs=1e-5)


def test_a_smaller_nose_touched_off_cuts_too_deep_between() -> None:
    """Nose of 0.78 mm for 0.80: touched off along X and Z it comes as far there, and further between."""
    nominal, smaller = nose_points(0.0, 0.80), nose_points(-0.02, 0.78)
    angles = np.linspace(0, np.pi / 2, 7)
    errors = [cut_by(smaller, angle) - cut_by(nominal, angle) for angle in angles]
    assert other_radius(angles, 0.02) == pytest.approx(errors, abs=1e-6)
    assert errors[3] < -0.008


def test_a_notch_has_straight_flanks() -> None:
    assert notch(np.array([0.5, 0.55, 0.6, 0.65]), 0.5, 0.010, 0.1) == pytest.approx([0.010, 0.005, 0.0, 0.0])


def test_wear_breaks_in_then_goes_evenly_then_faster() -> None:
    minutes = np.array([0.0, 15.0, 60.0, 120.0, 240.0])
    by_hand = 0.003 * (1 - np.exp(-minutes / 15)) + 0.006 * minutes / 60 + 0.006 * (minutes / 240) ** 4
    assert wear(Shop(), minutes) == pytest.approx(by_hand)
    assert np.all(np.diff(wear(Shop(), np.linspace(0, 300, 50))) > 0)


def test_a_shift_begins_cold() -> None:
    shop = Shop(minutes=10.0, warming_min=40.0, shift_parts=6)
    shift = warming(shop, np.arange(13.0))
    assert shift[[0, 6, 12]] == pytest.approx([0.0, 0.0, 0.0])
    assert shift[4] == pytest.approx(-0.006 * (1 - np.exp(-1)))


def test_what_arrives_of_a_correction() -> None:
    series = drawn(Event(What.CORRECTION, 3, 0.0), Event(What.CORRECTION, 4, 2.0), shop=replace(SHOP, gain=1.1))
    for part, gain in ((2, 1.1), (3, 0.0), (4, 2.2)):
        assert series.left_mm(part, 0.010) == pytest.approx(series.uncorrected_mm[part] - gain * 0.010)
        assert series.inspected_mm(part, 0.01) == pytest.approx(series.left_mm(part, 0.01) + series.noise_mm[part])


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_events_change_the_parts_that_they_belong_to() -> None:
    plain = drawn()
    moved = drawn(Event(What.OFFSET, 5, 0.010))
    assert moved.uncorrected_mm[:5] == pytest.approx(plain.uncorrected_mm[:5])
    by = np.tile(0.010 * np.sin(ANGLES), (3, 1))
    assert moved.uncorrected_mm[5:] - plain.uncorrected_mm[5:] == pytest.approx(by)
    assert moved.semifinish_mm[5:] - plain.semifinish_mm[5:] == pytest.approx(by, abs=0.011e-2)
    finish = drawn(Event(What.FINISH, 5, 0.010))
    assert finish.uncorrected_mm[5] - plain.uncorrected_mm[5] == pytest.approx(0.010 * np.sin(ANGLES))
    assert finish.uncorrected_mm[6:] == pytest.approx(plain.uncorrected_mm[6:])
    assert finish.semifinish_mm == pytest.approx(plain.semifinish_mm)


def test_another_edge_differs_by_the_size_asked_for() -> None:
    plain, turned = drawn(shop=replace(SHOP, noise_mm=0.0)), None
    turned = drawn(Event(What.EDGE, 6, 0.007), shop=replace(SHOP, noise_mm=0.0))
    by = turned.uncorrected_mm - plain.uncorrected_mm
    assert rms(by[6]) == rms(by[7]) == pytest.approx(0.007)
    assert by[:6] == pytest.approx(0.0)
    assert rms(other_form(ANGLES, np.random.default_rng(1), 0.003)) == pytest.approx(0.003)


def test_an_edge_that_is_known_to_be_another_begins_anew() -> None:
    series = drawn(shop=replace(SHOP, changed_at=5))
    assert series.edge.tolist() == [0] * 5 + [1] * 3
    assert series.minutes_in_cut[[0, 4, 5, 7]] == pytest.approx([6.0, 30.0, 6.0, 18.0])


def test_an_edge_that_stands_still_only_scatters() -> None:
    still = Shop(parts=400, stands_from=6, clamping_mm=0.0, own_form_mm=0.0, noise_mm=0.0, resolution_mm=1e-9)
    touched = draw(still, np.random.default_rng(3)).semifinish_mm
    assert touched[7:] == pytest.approx(np.tile(touched[6], (393, 1)), abs=1e-8)
    assert rms(touched[6] - touched[5]) > 1e-5


def test_noise_is_as_stated() -> None:
    still = Shop(parts=4000, minutes=0.0, gross_share=0.02)
    for shop in (still, replace(still, heavy_tails=True)):
        noise = drawn(shop=shop).noise_mm
        assert np.mean(np.abs(noise) > 0.012) == pytest.approx(0.02 * 0.548, rel=0.15)  # 12 µm of 20: 0.6 σ
        assert rms(noise[np.abs(noise) < 0.008]) == pytest.approx(0.0015, rel=0.2)


def test_the_probe_reads_in_steps() -> None:
    steps = drawn(shop=replace(SHOP, resolution_mm=0.0005)).semifinish_mm / 0.0005
    assert steps == pytest.approx(np.round(steps))


def test_one_place_is_enough() -> None:
    assert draw(Shop(angle_rad=np.array([np.pi / 2])), np.random.default_rng(0)).uncorrected_mm.shape == (30, 1)
