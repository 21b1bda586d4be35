"""Expected against obtained, where half of a correction is applied: half of the error is expected to be left."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_inputs
from tests.support.kept import cut_of
from trueloop.domain.life import Ran
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import Obtained, obtained
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.statistics import rms


@pytest.fixture(scope="module")
def half() -> Correction:
    inputs = example_inputs("modbas2")
    return compensate(replace(inputs, options=replace(inputs.options, weight=0.5)))


def found_at_arcs(correction: Correction, share: float) -> Obtained:
    """Errors found that are a share of those touched before the cut."""
    cut = cut_of(correction)
    one = obtained(correction, cut, replace(correction.touches, error_mm=share * correction.touches.error_mm))
    assert one is not None
    return one


def test_what_is_expected_is_inside_and_its_opposite_is_not(half: Correction) -> None:
    touched = half.touches.error_mm[~half.touches.at_reference]
    one = found_at_arcs(half, 0.5)
    assert one.places == len(touched) and one.inside == one.places
    assert one.found_mm == pytest.approx(0.5 * rms(touched))
    assert one.predicted_mm == pytest.approx(one.found_mm, rel=0.1) and one.predicted_mm > 0.01
    assert found_at_arcs(half, -0.5).inside < 0.5 * one.places
    assert found_at_arcs(half, 0.0).inside < one.places


def test_another_program_than_the_predicted_one_is_not_compared(half: Correction) -> None:
    given = half.programs_sha256[Ran.AS_PROGRAMMED]
    assert obtained(half, replace(cut_of(half), program_sha256=given), half.touches) is None
    assert obtained(half, replace(cut_of(half), correction=""), half.touches) is None


def test_without_a_place_beside_the_reference_there_is_nothing_to_compare(half: Correction) -> None:
    reference = np.flatnonzero(half.touches.at_reference).tolist()
    assert obtained(half, cut_of(half), half.touches.chosen(reference)) is None
