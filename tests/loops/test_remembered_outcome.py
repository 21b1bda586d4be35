"""What a correction by earlier parts is expected to leave, where the machine makes 1.25 of a correction of 1."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.support.remembered import remembering_inputs
from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.outcome import expected_mm
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.memory.made_part import MadePart
from trueloop.report.turned.remembered import remembered
from trueloop.turned.options import By

RADIUS = Characteristic("dome radius", Quantity.RADIUS, "dome", nominal=37.084, lower_limit=37.0, upper_limit=37.2)


def by_more(part: MadePart) -> MadePart:
    """The same part, of which the finish cut took off 1.25 of what was commanded."""
    assert part.finish is not None and part.correction_mm is not None
    left = part.finish.error_mm + part.correction_mm - 1.25 * part.correction_mm
    return replace(part, finish=replace(part.finish, error_mm=left))


@cache
def inputs() -> Inputs:
    given = remembering_inputs()
    return replace(given, history=tuple(map(by_more, given.history)), characteristics=(RADIUS,))


@cache
def corrected(weight: float, by: By) -> Correction:
    options = replace(inputs().options, weight=weight, by=by)
    return compensate(replace(inputs(), options=options))


def uncorrected_mm(correction: Correction, arc_length_mm: Array) -> Array:
    """E at places of the dome, from what memory predicted."""
    memory = correction.memory
    assert memory is not None and memory.applied and memory.expected is not None
    known = memory.expected
    return known.along(known.gain * known.mean_mm, correction.profile.names.index("dome"), arc_length_mm)


def test_the_machine_is_asked_for_less() -> None:
    correction = corrected(1.0, "contour")
    assert correction.memory is not None and correction.memory.expected is not None
    assert correction.memory.expected.gain == pytest.approx(1.25, abs=0.05)
    dome = correction.profile.names.index("dome")
    s = np.array([20.0, 40.0])
    asked = correction.model.curves[dome].value_mm(s)
    expected = uncorrected_mm(correction, s)
    assert 1.25 * asked == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(("weight", "left"), [(1.0, 0.0), (0.5, 0.5)])
def test_a_weight_leaves_its_share_of_what_would_have_been(weight: float, left: float) -> None:
    """At touches, along the feature and of a size of it: the radius is larger by the mean of what is left."""
    correction = corrected(weight, "contour")
    dome = correction.profile.names.index("dome")
    rows = correction.touches.of_feature(dome)
    by_hand = left * uncorrected_mm(correction, correction.touches.arc_length_mm[rows])
    assert correction.prediction.after_mm[rows] == pytest.approx(by_hand, abs=5e-5)
    s = np.linspace(5.0, 55.0, 20)
    by_hand = left * uncorrected_mm(correction, s)
    assert expected_mm(correction, dome, s) == pytest.approx(by_hand, abs=5e-5)


def test_an_offset_takes_off_more_as_well() -> None:
    correction = corrected(1.0, "offset")
    dome = correction.profile.names.index("dome")
    assert correction.by_offset[dome]
    memory = correction.memory
    assert memory is not None and memory.expected is not None
    rows = correction.touches.of_feature(dome)
    normal = correction.touches.outward_normal[rows]
    moved = memory.expected.gain * (normal @ np.array(correction.decision.offset_mm))
    by_hand = uncorrected_mm(correction, correction.touches.arc_length_mm[rows]) + moved
    assert np.max(np.abs(moved)) > 0.02
    assert correction.prediction.after_mm[rows] == pytest.approx(by_hand, abs=5e-5)
    assert expected_mm(correction, dome, correction.touches.arc_length_mm[rows]) == pytest.approx(by_hand, abs=5e-5)


def test_a_size_of_an_arc_is_expected_where_nothing_is_left() -> None:
    """1.46 in as drawn when all is taken out; off when half of it is, the same way as a smaller dome is."""
    (whole,), (half,) = corrected(1.0, "contour").characteristics, corrected(0.5, "contour").characteristics
    assert whole.after.value == pytest.approx(37.084, abs=0.004)
    assert abs(half.after.value - 37.084) > 3 * abs(whole.after.value - 37.084)


def test_the_share_from_memory_is_large_where_memory_alone_says_the_same() -> None:
    """By hand: 30 µm from memory and 10 µm more from touches are shares of 3/4 and 1/4, everywhere."""
    correction = corrected(1.0, "contour")
    memory = correction.memory
    assert memory is not None and memory.expected is not None
    n = len(memory.expected.contact_angle_rad)
    expected = replace(memory.expected, memory_mm=np.full(n, 0.030), mean_mm=np.full(n, 0.040))
    dome = correction.profile.names.index("dome")
    assert replace(memory, expected=expected).share(dome) == pytest.approx(0.75)
    assert replace(memory, expected=expected, applied=False).share(dome) == 0.0


def test_the_figure_shows_what_an_offset_takes_off() -> None:
    """−dX on a cylinder's side and −dZ on the face: an offset towards the part takes material off."""
    correction = corrected(1.0, "offset")
    memory = correction.memory
    assert memory is not None and memory.expected is not None
    drawn = remembered(correction, memory, memory.expected, 980)["data"]
    (line,) = (trace for trace in drawn if trace["name"] == "applied")
    ends = [y for _, y in sorted(zip(line["x"], line["y"], strict=True))][:: len(line["x"]) - 1]
    dx, dz = correction.decision.offset_mm
    assert ends == pytest.approx([-1000.0 * dz, -1000.0 * dx], abs=0.1)
    assert dx < 0.0
