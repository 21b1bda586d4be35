"""The nose model on the ten worn-nose parts of [6811] Tables 8 and 10: one tool cut them all.

Touches are named by their place among the twenty of a dome or knob, counted from 1. "Third and eighteenth" are the two
that stand two from either end: where a prober would put two touches without knowing more.
"""

import itertools
from functools import cache

import numpy as np
import pytest

from tests.support.nist_errors import nist_parts, semifinish
from tests.support.touched import chosen
from trueloop.error_curve.fit_profile import fit_profile
from trueloop.error_curve.nose_fit import fit_nose_model, nose_touches
from trueloop.error_curve.nose_model import NoseModel, NoseTouches
from trueloop.geometry.feature import Array
from trueloop.units import UM_PER_MM

TWO, THREE, ALL = (2, 17), (2, 9, 17), tuple(range(20))


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@cache
def touches(family: str) -> tuple[NoseTouches, ...]:
    return tuple(nose_touches(part.number, part.profile, semifinish(part)) for part in nist_parts(family))


def arc_of(part: NoseTouches) -> NoseTouches:
    return part.subset(part.on_arc)


@cache
def without_each_part() -> tuple[tuple[NoseTouches, NoseModel], ...]:
    """Each of the ten parts with the nose model of the other nine."""
    ten = [*touches("MODBAS2"), *touches("PIECS11")]
    return tuple((part, fit_nose_model([*ten[:k], *ten[k + 1 :]])) for k, part in enumerate(ten))


def left_out_rms_um(places: tuple[int, ...]) -> float:
    """RMS over the whole arcs of all ten parts, each predicted from some touches of its own and nine others' nose."""
    errors = []
    for part, nose in without_each_part():
        arc = arc_of(part)
        prediction = nose.predict(arc.subset(list(places)))
        errors.append(arc.error_mm - prediction.value_mm(arc.contact_angle_rad))
    return rms(np.concatenate(errors)) * UM_PER_MM


def mean_knob(nose: NoseModel) -> NoseTouches:
    """The mean of the six PIECS11 knobs, within the angles that the nose model covers."""
    arcs = [arc_of(part) for part in touches("PIECS11")]
    angle = np.mean([arc.contact_angle_rad for arc in arcs], axis=0)
    error = np.mean([arc.error_mm for arc in arcs], axis=0)
    shared = (angle >= nose.lowest_rad) & (angle <= nose.highest_rad)
    return NoseTouches("mean", ("knob",) * 20, np.ones(20, dtype=np.bool_), angle, error).subset(shared)


def test_modbas2_tells_the_dome_of_piecs11() -> None:
    """Fitted on four parts, it predicts another part's mean dome to 1.1 µm RMS from two offsets; 23 µm before them."""
    nose = fit_nose_model(touches("MODBAS2"))
    knob = mean_knob(nose)
    assert len(knob.feature) == 16
    angle = knob.contact_angle_rad
    terms = np.column_stack([np.sin(angle), np.cos(angle)])
    as_modbas2 = nose.w_mm(angle) + terms @ np.mean(list(nose.offsets_mm.values()), axis=0)
    assert rms(knob.error_mm - as_modbas2) * UM_PER_MM == pytest.approx(23.0, abs=0.5)
    offset = nose.predict(knob)
    assert rms(knob.error_mm - offset.value_mm(angle)) * UM_PER_MM <= 1.2


def test_a_few_touches_tell_the_whole_dome() -> None:
    """Ten parts, each left out in turn: two touches 2.7, three 2.3, all twenty 1.8 µm RMS."""
    assert left_out_rms_um(TWO) == pytest.approx(2.72, abs=0.02)
    assert left_out_rms_um(THREE) == pytest.approx(2.32, abs=0.02)
    assert left_out_rms_um(ALL) == pytest.approx(1.76, abs=0.02)


def test_wherever_the_touches_lie() -> None:
    """Median over all pairs at least three apart 2.9 µm, over all triples 2.4 µm: no lucky choice."""
    pairs = [pair for pair in itertools.combinations(range(20), 2) if pair[1] - pair[0] > 2]
    triples = itertools.islice(itertools.combinations(range(20), 3), 0, None, 7)
    assert np.median([left_out_rms_um(pair) for pair in pairs]) == pytest.approx(2.91, abs=0.02)
    assert np.median([left_out_rms_um(triple) for triple in triples]) == pytest.approx(2.42, abs=0.02)


def test_the_predicted_uncertainty_holds() -> None:
    """Two touches: 95 of 100 touches on parts never seen lie within two standard uncertainties."""
    ratios = []
    for part, nose in without_each_part():
        arc = arc_of(part)
        prediction = nose.predict(arc.subset(list(TWO)))
        u = np.hypot(prediction.standard_deviation_mm(arc.contact_angle_rad), nose.scatter_mm)
        ratios.append((arc.error_mm - prediction.value_mm(arc.contact_angle_rad)) / u)
    within = np.mean(np.abs(np.concatenate(ratios)) < 2.0)
    assert 0.90 <= within <= 0.99


def test_cones_stand_off_the_nose() -> None:
    """What is left on the cones: 11 to 17 µm on nine parts, 30 µm on the one whose taper was falsified."""
    left_um: dict[str, float] = {}
    for family in ("MODBAS2", "PIECS11"):
        nose = fit_nose_model(touches(family))
        left_um |= {part: left * UM_PER_MM for (part, feature), left in nose.left_mm.items() if feature == "cone"}
    assert len(left_um) == 10
    falsified = left_um.pop("2811")
    assert falsified == pytest.approx(30.2, abs=0.5)
    assert all(8.0 < left < 20.0 for left in left_um.values()), left_um


def test_w_has_nothing_in_common_with_tool_offsets() -> None:
    """∫w sin φ dφ = ∫w cos φ dφ = 0; and offsets put on the data go to the offsets, not to w."""
    parts = touches("MODBAS2")
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
    nose = fit_nose_model(touches("PIECS11"))
    with_nose, without = fit_profile(part.profile, few, nose=nose), fit_profile(part.profile, few)
    (choice,) = with_nose.choices
    assert choice.nose_serves
    dome = every.of_feature(len(part.profile.features) - 1)
    true, along = every.error_mm[dome], every.arc_length_mm[dome]
    assert rms(true - with_nose.curves[-1].value_mm(along)) * UM_PER_MM <= at_most_um
    assert rms(true - without.curves[-1].value_mm(along)) * UM_PER_MM >= own_at_least_um
