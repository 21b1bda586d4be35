"""Every part of [6811] Tables 2–11 runs through the loop, and the page about them says what came out."""

import numpy as np
import pytest

from scripts.nist_bands import Held, held, together
from scripts.nist_parts import NistPart, parts
from scripts.nist_table import PAGE, corrected, page, part_name
from trueloop.loops.turned.correction import Correction
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM


@pytest.fixture(scope="module")
def results() -> list[tuple[NistPart, Correction]]:
    return [(part, corrected(part)) for part in parts()]


def test_the_page_is_what_the_code_gives(results: list[tuple[NistPart, Correction]]) -> None:
    assert PAGE.read_text(encoding="utf-8") == page(results), "run  python -m scripts.nist_table --write"


def test_every_part_is_corrected_and_predicted_better_than_it_was(results: list[tuple[NistPart, Correction]]) -> None:
    """Also at points that the fit did not see, where their feature has others."""
    assert len(results) == 14
    for part, correction in results:
        prediction = correction.prediction
        seen = np.isfinite(prediction.leave_one_out_mm)
        assert rms(prediction.after_mm) < rms(prediction.before_mm) / 5, part_name(part)
        assert rms(prediction.leave_one_out_mm[seen]) < rms(prediction.before_mm[seen]) / 4, part_name(part)
        assert correction.corrected_program != correction.source_program, part_name(part)


def test_measured_and_published_roots_are_those_of_the_tables(results: list[tuple[NistPart, Correction]]) -> None:
    """[6811 Table 9], four MODBAS2 parts: NIST's finish cut left 4.7 µm RMS on the dome over all of them."""
    left_um = [
        touch.error_mm * UM_PER_MM
        for part, _ in results
        if part.family.name == "MODBAS2"
        for touch in part.finish
        if touch.feature == "dome" and touch.error_mm is not None
    ]
    assert len(left_um) == 80
    assert rms(np.array(left_um)) == pytest.approx(4.7, abs=0.05)


def families(results: list[tuple[NistPart, Correction]]) -> dict[str, Held]:
    """What our correction would have left in NIST's metal, by family."""
    each = [(part.family.name, held(part_name(part), part, correction)) for part, correction in results]
    return {name: together(name, [one for other, one in each if other == name]) for name, _ in each}


def test_the_bands_hold_what_our_correction_would_have_left_in_metal(
    results: list[tuple[NistPart, Correction]],
) -> None:
    """The prior between cuts was set before; two cuts taken for alike hold 81 % of the points only."""
    by_family = families(results)
    everything = together("all", list(by_family.values()))
    assert len(everything.left_mm) == 330
    assert 0.90 <= everything.inside <= 0.98
    assert everything.inside_without_prior < 0.83
    assert 0.90 <= by_family["MODBAS2"].inside <= 0.98
    assert 0.90 <= by_family["PIECS11"].inside <= 0.98


def test_the_finish_cut_took_more_than_the_semifinish_cut(results: list[tuple[NistPart, Correction]]) -> None:
    """What is left is F − C + P by hand, at one touch of each: [6811 Tables 8 to 11] less what either fit took out."""
    by_family = families(results)
    assert np.mean(by_family["MODBAS2"].left_mm) * UM_PER_MM == pytest.approx(-1.9, abs=0.1)
    assert np.mean(by_family["PIECS11"].left_mm) * UM_PER_MM == pytest.approx(-3.1, abs=0.1)
    part, correction = next(pair for pair in results if pair[0].family.name == "PIECS11")
    k = next(k for k, touch in enumerate(part.finish) if touch.feature == "collar")  # one touch: both take it out whole
    finish_mm = part.finish[k].error_mm
    assert finish_mm is not None
    assert held("", part, correction).left_mm[np.flatnonzero(~correction.touches.at_reference) == k] == pytest.approx(
        finish_mm, abs=1e-12
    )
