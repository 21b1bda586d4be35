"""What memory expects of the next finish cut, on parts made up by another model."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.memory.edge.parts import ANGLES, made, series
from trueloop.errors import Code, TrueloopError
from trueloop.estimate.catalogue import PRIORS
from trueloop.memory.edge.learnt import MemoryOptions, known_edge, observed
from trueloop.memory.edge.predict import expect, innovations, latest, predict
from trueloop.memory.made_part import CutErrors, Expected, MadePart


def unfinished(part: MadePart) -> MadePart:
    return replace(part, finish=None, correction_mm=None)


def expected(parts: tuple[MadePart, ...], **options: object) -> Expected:
    return expect(parts[:-1], unfinished(parts[-1]), CutErrors.asked(ANGLES, "dome"), MemoryOptions(**options))  # type: ignore[arg-type]


def test_expects_what_the_finish_cut_does_differently() -> None:
    parts = series(7)
    found, uncorrected = expected(parts), parts[-1].uncorrected_mm
    assert uncorrected is not None
    left, own = uncorrected - found.mean_mm, uncorrected - parts[-1].semifinish.error_mm
    assert np.sqrt(np.mean(left**2)) < 0.0020 < np.sqrt(np.mean(own**2))
    assert not found.own_fit and found.parts == 6 and found.gain == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_finish_cut_that_was_displaced_displaces_no_later_prediction(sign: float) -> None:
    """Somebody entered 20 µm in X for the last part alone: its finish cut lies there, and no touch.

    Were that shared out among all finish cuts, the next part would be expected micrometres off, in a band as wide.
    """
    *earlier, last, today = series(4, seed=2)
    entered_mm = sign * 0.020 * np.sin(ANGLES)
    assert last.finish is not None and today.uncorrected_mm is not None
    displaced = replace(last, finish=replace(last.finish, error_mm=last.finish.error_mm + entered_mm))
    sound, found = expected((*earlier, last, today)), expected((*earlier, displaced, today))
    assert np.max(np.abs(found.mean_mm - sound.mean_mm)) < 0.0015
    wider = np.diag(found.covariance_mm2) / np.diag(sound.covariance_mm2)
    assert float(np.sqrt(np.mean(wider))) < 1.4
    assert np.sqrt(np.mean((today.uncorrected_mm - found.mean_mm) ** 2)) < 0.003


def test_the_first_part_is_corrected_by_its_own_fit() -> None:
    for parts, options in ((series(1), {}), (series(4), {"memory": "off"})):
        found = expected(parts, **options)
        assert found.own_fit and found.parts == 0
        assert found.weight == pytest.approx(0.75)


def test_an_actuator_that_moves_twice_is_learned_from_one_part() -> None:
    parts = series(3, gain=2.2)
    found, right = expected(parts), series(3)[-1].uncorrected_mm
    assert right is not None
    assert found.gain == pytest.approx(2.2, abs=0.2)
    assert np.sqrt(np.mean((right - 2.2 * found.mean_mm) ** 2)) < 0.006


@pytest.mark.parametrize("gain", [-1.0, 0.0])
def test_an_actuator_gone_wrong_is_not_divided_by(gain: float) -> None:
    """After one part, and after three: what it makes of a correction is near nothing, or the wrong way."""
    for count in (2, 4):
        with pytest.raises(TrueloopError) as refused:
            expected(series(count, gain=gain))
        assert refused.value.code == Code.MEM_GAIN


def test_innovations_are_those_of_the_cut_that_was_not_corrected() -> None:
    parts = series(6)
    last = parts[-1]
    assert last.finish is not None and last.correction_mm is not None
    not_run = replace(last, finish=replace(last.finish, error_mm=last.finish.error_mm + last.correction_mm))
    _, usual = innovations(parts[:-1], last)
    _, changed = innovations(parts[:-1], not_run)
    assert changed.error_mm - usual.error_mm == pytest.approx(last.correction_mm, abs=1e-12)
    z = usual.error_mm / np.sqrt(np.diag(usual.covariance_mm2))
    assert 0.3 < np.sqrt(np.mean(z**2)) < 2.0


def test_a_feature_without_a_touch_may_be_far_off_on_the_part_in_hand() -> None:
    """What one feature of one part is off by has Student's distribution with three degrees of freedom: its variance is
    three times the square of its scale. Without earlier parts all sizes are those believed beforehand, and the band of
    the untouched face is wider by (3 − 1) × all that a feature has of its own, of the type and of the part.
    """
    today = unfinished(series(1)[0])
    face = CutErrors.asked(np.array([0.0]), "face")
    wider = predict((), today, face).inspected(np.zeros(1)).covariance_mm2
    known = known_edge((), today, face)
    places, functional = known.places(face, True)
    plain = known.state.given(observed(today, known.age)[0]).state.at(places).predict(places, functional)
    own_mm2 = 2.0 * sum(PRIORS[name].median ** 2 for name in ("group", "group_part"))  # in the middle no tilt shows
    assert wider - plain.covariance_mm2 == pytest.approx(np.full((1, 1), own_mm2), rel=1e-6)


def test_alarms_and_prediction_of_a_part_follow_from_one_state_of_the_parts_before_it() -> None:
    """A part that was measured anew, and one more or less, is in the state."""
    *before, today = series(4)
    known = known_edge(before, unfinished(today))
    assert known_edge(tuple(before), replace(today, serial="again")).state is known.state
    last = before[-1]
    assert last.finish is not None
    measured = replace(last, finish=replace(last.finish, error_mm=last.finish.error_mm + 0.005))
    anew = known_edge([*before[:-1], measured], unfinished(today))
    assert anew.state.mean != pytest.approx(known.state.mean, abs=1e-4)
    assert len(known_edge(before[:-1], last).left_mm) == 2


def test_a_prediction_takes_in_no_more_parts_after_a_thousand_of_ten_types() -> None:
    """The latest 40, and the latest ten of the part's own type; of the other types nothing is in the state."""
    rng = np.random.default_rng(0)
    parts = [made(order, rng, part_type=f"type {order % 10}") for order in range(1000)]
    sizes = []
    for history in (parts[-100:], parts):
        known = known_edge(latest(history, "type 0"), replace(parts[0], serial="today", order=1000.0))
        sizes.append((len(known.left_mm), len(known.state.mean)))
    assert sizes[0] == sizes[1] and sizes[0][0] == 40 + 6
    assert {key[1] for key in known.state.blocks if key[0] == "part zero"} == {"type 0"}
