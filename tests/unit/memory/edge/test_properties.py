"""What must hold of memory whatever the parts: touches help, order within a part is nothing, the future is not seen."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from studies.replay.replay import Predicted, replay
from tests.unit.memory.edge.parts import ANGLES, errors, made, series
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import enough_touches, expect, is_seen, latest, predict
from trueloop.memory.made_part import CutErrors, Expected, MadePart

HISTORY = series(5)
LAST = replace(series(6)[-1], finish=None, correction_mm=None)


def touched(places: list[int], error_mm: Array | None = None) -> MadePart:
    error = LAST.semifinish.error_mm if error_mm is None else error_mm
    return replace(LAST, semifinish=replace(LAST.semifinish, error_mm=np.asarray(error)).chosen(places))


def taken_off(part: MadePart, share: float) -> MadePart:
    """The part had only a share of its correction been taken off."""
    assert part.finish is not None and part.correction_mm is not None
    left = part.finish.error_mm + (1.0 - share) * part.correction_mm
    return replace(part, finish=replace(part.finish, error_mm=left), correction_mm=share * part.correction_mm)


def expected(part: MadePart, history: tuple[MadePart, ...] = HISTORY, **options: object) -> Expected:
    return expect(history, part, CutErrors.asked(ANGLES, "dome"), MemoryOptions(**options))  # type: ignore[arg-type]


@settings(max_examples=10, deadline=None)
@given(st.permutations(range(len(ANGLES))))
def test_the_order_of_a_parts_points_is_nothing(order: list[int]) -> None:
    one = HISTORY[2]
    assert one.finish is not None and one.correction_mm is not None
    other = replace(
        one,
        semifinish=one.semifinish.chosen(order),
        finish=one.finish.chosen(order),
        correction_mm=one.correction_mm[order],
    )
    usual, changed = expected(LAST), expected(LAST, (*HISTORY[:2], other, *HISTORY[3:]))
    assert changed.mean_mm == pytest.approx(usual.mean_mm, abs=2e-6)


def test_material_left_on_by_all_cuts_alike_is_expected_with_its_sign() -> None:
    """A touch higher by 10 µm along x and z moves the whole expectation by nearly as much, and never against it."""
    raised = touched(list(range(len(ANGLES))), LAST.semifinish.error_mm + 0.010)
    moved = expected(raised).mean_mm - expected(LAST).mean_mm
    assert np.all((moved > 0.007) & (moved < 0.011))


def test_advice_is_what_a_search_step_by_step_finds() -> None:
    """By conditioning on every candidate with a plain inverse."""
    rng = np.random.default_rng(2)
    for touches in (0, 1, *[6] * 20):
        root = rng.normal(size=(touches + 3, touches + 3)) * rng.uniform(0.2, 5.0, (touches + 3, 1))
        covariance = root @ root.T + 0.1 * np.eye(touches + 3)

        def left(chosen: list[int], covariance: Array = covariance, t: int = touches) -> float:
            known, across = covariance[np.ix_(chosen, chosen)], covariance[t:, chosen]
            return float(np.trace(covariance[t:, t:] - across @ np.linalg.inv(known) @ across.T))

        chosen: list[int] = []
        while left(chosen) > 1.1**2 * left(list(range(touches))):
            rest = [k for k in range(touches) if k not in chosen]
            chosen.append(min(rest, key=lambda k: left([*chosen, k])))
        assert enough_touches(covariance, touches) == len(chosen)


def test_more_inspected_parts_are_needed_before_bands_stop_being_widened() -> None:
    """√1.3 with two inspected parts: against the covariance of the prediction itself."""
    for count, times in ((1, 1.3), (2, 1.3), (3, 1.0)):
        plain = predict(HISTORY[:count], LAST, CutErrors.asked(ANGLES, "dome"))
        found = expected(LAST, HISTORY[:count])
        command_mm = plain.mean_mm / plain.gain
        np.testing.assert_allclose(found.covariance_mm2, times * plain.inspected(command_mm).covariance_mm2)
        assert any("band is widened" in note for note in found.notes) == (times > 1)


def test_the_first_correction_is_three_quarters_until_one_of_its_size_was_inspected() -> None:
    none, small = ([taken_off(part, share) for part in HISTORY[:2]] for share in (0.0, 0.1))
    for history, weight in ((none, 0.75), (small, 0.75), (HISTORY[:2], 1.0)):
        assert np.all(expected(LAST, tuple(history)).weight == weight)
    assert np.all(expected(LAST, tuple(none), first_weight=0.5).weight == 0.5)


def test_bands_leave_the_correction_to_the_own_fit_and_frozen_learns_nothing_more() -> None:
    assert expected(LAST, memory="bands").own_fit and not expected(LAST).own_fit
    frozen = expected(LAST, memory="frozen", last_part="2")
    assert frozen == expected(LAST, HISTORY[:3]) and frozen.parts == 3


def test_an_inspection_whose_correction_is_unknown_is_not_learned_from() -> None:
    unknown = [replace(part, correction_mm=None) for part in HISTORY]
    found = expected(LAST, tuple(unknown))
    assert found.parts == 0 and not found.own_fit
    assert any("correction is not known" in note for note in found.notes)
    without = expected(LAST, tuple(replace(part, finish=None) for part in unknown))
    assert found.mean_mm == pytest.approx(without.mean_mm)


def test_flags() -> None:
    deep = [replace(part, depth_of_cut_mm=0.25, feed_mm=0.1) for part in HISTORY]
    notes = expected(replace(LAST, depth_of_cut_mm=0.28, feed_mm=0.105), tuple(deep)).notes
    assert [note for note in notes if "depth" in note] and not [note for note in notes if "feed" in note]
    assert any("order" in note for note in expected(replace(LAST, order=4.0)).notes)
    assert any("order" in note for note in expected(replace(LAST, order_in_doubt=True)).notes)
    aged = [replace(part, minutes_in_cut=float(10 - k)) for k, part in enumerate(HISTORY)]
    assert any("order" in note for note in expected(LAST, tuple(aged)).notes)
    assert not expected(LAST).notes
    wrong = expected(replace(series(4, gain=2.2)[-1], finish=None, correction_mm=None), series(4, gain=2.2)[:3])
    assert any("of a correction of 1" in note for note in wrong.notes)


def unfinished(part: MadePart) -> MadePart:
    return replace(part, finish=None, correction_mm=None)


def _three_of(part: MadePart) -> MadePart:
    return replace(part, semifinish=part.semifinish.chosen([2, 8, 14]))


def test_a_replay_sees_nothing_of_what_comes_later() -> None:
    def own(part: MadePart) -> Predicted:
        return Predicted(part.semifinish.error_mm, np.full(len(ANGLES), 0.008))

    usual = replay(HISTORY, own, MemoryOptions(), lambda _: (2, 8, 14))
    last = HISTORY[3]
    assert last.finish is not None
    other = replace(last, finish=replace(last.finish, error_mm=last.finish.error_mm + 0.05))
    changed = replay((*HISTORY[:3], other, *HISTORY[4:]), own, MemoryOptions(), lambda _: (2, 8, 14))
    for one, two in zip(usual[:4], changed[:4], strict=True):
        np.testing.assert_array_equal(one.predicted.error_mm, two.predicted.error_mm)
    assert not np.allclose(usual[4].predicted.error_mm, changed[4].predicted.error_mm, atol=1e-4)
    assert [one.touches for one in usual] == [17, 3, 3, 3, 3] and usual[0].own_fit
    np.testing.assert_allclose(changed[3].left_mm - usual[3].left_mm, 0.05)
    at_three = (*HISTORY[:1], *(_three_of(part) for part in HISTORY[1:3]))
    direct = expect(at_three, _three_of(unfinished(last)), last.finish, MemoryOptions())
    assert last.uncorrected_mm is not None
    np.testing.assert_allclose(usual[3].left_mm, last.uncorrected_mm - direct.mean_mm)
    np.testing.assert_allclose(usual[3].predicted.half_band_mm, 1.96 * np.sqrt(np.diag(direct.covariance_mm2)))


def test_a_replay_uses_all_touches_where_three_are_refused() -> None:
    """A second type whose arc goes on beyond what the first has shown."""
    wide = np.radians(np.linspace(5.0, 105.0, 21))
    new = made(5, np.random.default_rng(9), angle_rad=wide, part_type="knob")
    with pytest.raises(TrueloopError) as refused:
        expect(HISTORY, replace(LAST, part_type="knob"), CutErrors.asked(wide, "dome"), MemoryOptions())
    assert refused.value.code == Code.MEM_UNSEEN

    def own(part: MadePart) -> Predicted:
        return Predicted(part.semifinish.error_mm, np.full(len(part.semifinish.error_mm), 0.008))

    assert replay((*HISTORY, new), own, MemoryOptions(), lambda _: (2, 8, 14))[-1].touches == 21
    flat = replace(LAST, semifinish=errors(np.empty(0), np.empty(0)))
    assert expected(flat).enough_touches == 0


@pytest.mark.parametrize(("touches", "earlier_deg", "seen"), [(5, 80.0, True), (4, 80.0, False), (5, 40.0, False)])
def test_between_many_touches_of_an_arc_earlier_parts_are_used_that_saw_it_alike(
    touches: int, earlier_deg: float, seen: bool
) -> None:
    """Touches 20° apart and angles 10° from them; earlier parts have touched the same, as far as `earlier_deg`."""
    at = np.radians(np.arange(0.0, 81.0, 20.0))
    known = at[at <= np.radians(earlier_deg)]
    before = [replace(HISTORY[0], semifinish=errors(0.0 * known, known), finish=None)]
    today = replace(LAST, semifinish=errors(np.zeros(touches), at[:touches]))
    angles = at[: touches - 1] + np.radians(10.0)
    found = is_seen(before, today, angles, np.full(len(angles), touches), MemoryOptions())
    assert bool(np.all(found)) == seen


def test_what_memory_alone_says_is_what_it_says_without_a_touch() -> None:
    assert expected(LAST).memory_mm == pytest.approx(expected(touched([])).mean_mm, abs=2e-6)


def test_time_in_cut_is_counted_in_parts_of_mean_duration() -> None:
    """Parts of seven minutes each are as parts without a time; a long pause between two of them is not."""
    even = tuple(replace(part, minutes_in_cut=7.0 * k) for k, part in enumerate(HISTORY))
    last = replace(LAST, minutes_in_cut=7.0 * len(HISTORY))
    assert expected(last, even).mean_mm == pytest.approx(expected(LAST).mean_mm, abs=1e-9)
    worn = expected(replace(last, minutes_in_cut=7.0 * 40), even)
    assert np.all(np.diag(worn.covariance_mm2) != np.diag(expected(last, even).covariance_mm2))


def test_an_edge_is_known_by_its_latest_parts_and_by_those_of_the_type() -> None:
    old, new = (replace(HISTORY[0], part_type="old", serial="o"), replace(HISTORY[1], serial="n"))
    history = [
        *(replace(old, order=float(k)) for k in range(12)),
        *(replace(new, order=float(k)) for k in range(12, 60)),
    ]
    assert [part.order for part in latest(history, "dome")] == [float(k) for k in range(20, 60)]
    assert [part.order for part in latest(history, "old")] == [float(k) for k in (*range(2, 12), *range(20, 60))]
    assert latest(HISTORY, "dome") == HISTORY
