"""The nose model on the ten worn-nose parts of [6811] Tables 8 and 10: one tool cut them all.

Touches are named by their place among the twenty of a dome or knob, counted from 1. "Third and eighteenth" are the two
that stand two from either end: where a prober would put two touches without knowing more.
"""

import numpy as np
import pytest

from scripts.nist_nose import (
    PAGE,
    PLACES,
    arc_of,
    family,
    left_on_cones_um,
    left_out,
    left_out_rms_um,
    median_um,
    page,
    transfer_um,
)
from tests.support.nist_errors import nist_parts, semifinish
from tests.support.touched import chosen
from trueloop.statistics import rms
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.nose_fit import NoseTouches, fit_nose_model
from trueloop.units import UM_PER_MM

TWO, THREE, ALL = PLACES.values()


def test_the_page_is_what_the_code_gives() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run  python -m scripts.nist_nose --write"


def test_modbas2_tells_the_dome_of_piecs11() -> None:
    """Fitted on four parts, it predicts another part's mean dome to 1.1 µm RMS from two offsets; 23 µm before them."""
    before, after = transfer_um()
    assert before == pytest.approx(23.0, abs=0.5)
    assert after <= 1.2


def test_a_few_touches_tell_the_whole_dome() -> None:
    """Ten parts, each left out in turn: two touches 2.7, three 2.3, all twenty 1.8 µm RMS."""
    assert left_out_rms_um(TWO) == pytest.approx(2.72, abs=0.02)
    assert left_out_rms_um(THREE) == pytest.approx(2.32, abs=0.02)
    assert left_out_rms_um(ALL) == pytest.approx(1.76, abs=0.02)


def test_wherever_the_touches_lie() -> None:
    """Median over all pairs at least three places apart 2.9 µm, over every seventh triple 2.3 µm: no lucky choice."""
    assert median_um(2, 1) == pytest.approx(2.91, abs=0.02)
    assert median_um(3, 7) == pytest.approx(2.33, abs=0.05)


def test_the_predicted_uncertainty_holds() -> None:
    """Two touches: 95 of 100 touches on parts never seen lie within two standard uncertainties."""
    ratios = []
    for part, nose in left_out():
        arc = arc_of(part)
        prediction = nose.predict(arc.subset(list(TWO)))
        u = np.hypot(prediction.standard_deviation_mm(arc.contact_angle_rad), nose.scatter_mm)
        ratios.append((arc.error_mm - prediction.value_mm(arc.contact_angle_rad)) / u)
    within = np.mean(np.abs(np.concatenate(ratios)) < 2.0)
    assert 0.90 <= within <= 0.99


def test_cones_stand_off_the_nose() -> None:
    """What is left on the cones: 11 to 17 µm on nine parts, 30 µm on the one whose taper looks falsified."""
    left_um = left_on_cones_um()
    assert len(left_um) == 10
    assert left_um.pop("2811") == pytest.approx(30.2, abs=0.5)
    assert all(10.0 < left < 18.0 for left in left_um.values()), left_um


def test_w_has_nothing_in_common_with_tool_offsets() -> None:
    """∫w sin φ dφ = ∫w cos φ dφ = 0; and offsets put on the data go to the offsets, not to w."""
    parts = family("MODBAS2")
    nose = fit_nose_model(parts)
    angle = np.linspace(nose.lowest_rad, nose.highest_rad, 20001)
    w = nose.w_mm(angle)
    assert abs(float(np.trapezoid(w * np.sin(angle), angle))) < 1e-8
    assert abs(float(np.trapezoid(w * np.cos(angle), angle))) < 1e-8
    first = parts[0]
    shift = 0.05 * np.sin(first.contact_angle_rad) - 0.03 * np.cos(first.contact_angle_rad)
    moved = NoseTouches(first.part, first.feature, first.on_arc, first.contact_angle_rad, first.error_mm + shift)
    again = fit_nose_model([moved, *parts[1:]])
    np.testing.assert_allclose(again.w_mm(angle), w, atol=1e-12)
    change = np.array(again.offsets_mm[first.part]) - np.array(nose.offsets_mm[first.part])
    np.testing.assert_allclose(change, [0.05, -0.03], atol=1e-12)


@pytest.mark.parametrize(("places", "at_most_um", "own_at_least_um"), [(TWO, 2.6, 20.0), (THREE, 2.0, 4.0)])
def test_few_touches_are_served_by_other_parts_noses(
    places: tuple[int, ...], at_most_um: float, own_at_least_um: float
) -> None:
    """MODBAS2 2511 with two or three touches on its dome and the nose of six PIECS11 parts: the dome to 2 µm.

    Its own curve through so few touches is off by many times as much, and leave-one-out knows it.
    """
    part = nist_parts("MODBAS2")[0]
    every = semifinish(part)
    few = chosen(every, [*range(12), *(12 + place for place in places)])
    nose = fit_nose_model(family("PIECS11"))
    with_nose, without = fit_profile(part.profile, few, nose=nose), fit_profile(part.profile, few)
    (choice,) = with_nose.choices
    assert choice.nose_serves
    dome = every.of_feature(len(part.profile.features) - 1)
    true, along = every.error_mm[dome], every.arc_length_mm[dome]
    assert rms(true - with_nose.curves[-1].value_mm(along)) * UM_PER_MM <= at_most_um
    assert rms(true - without.curves[-1].value_mm(along)) * UM_PER_MM >= own_at_least_um
