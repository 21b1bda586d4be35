"""The post-process loop: by hand, and against a lathe that is simulated here without a word of the model."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest

from tests.support.series import MADE, followed, inspection, reading, seen
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.proposal import Proposal, ProposalClass
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.geometry.feature import Line
from trueloop.geometry.validate import checked_profile
from trueloop.loops.post_process.decide import decide, usable
from trueloop.loops.post_process.propose import ProposalContext, effect_of, fitted_offset, moved_by_offset, proposals_of
from trueloop.loops.post_process.series import (
    ADJUSTS,
    Parameter,
    PartSeen,
    Series,
    SeriesOptions,
    Stage,
    When,
    may_change,
    parts_in_order,
    series_of,
    stage_of,
)
from trueloop.loops.post_process.tracked import capability, replay, tracked
from trueloop.memory.level.kalman import REDUCED
from trueloop_lab.loops.series import CYLINDER, simulate
from trueloop_lab.simulator.series import Shop, draw

BY = ProposalContext("me", MADE)


def _proposed(*errors_um: float) -> tuple[Proposal, ...]:
    return proposals_of([followed(*errors_um)], SeriesOptions(), BY)


def test_a_shaft_that_is_too_large_is_to_become_smaller() -> None:
    (proposal,) = _proposed(26.0, 29.0, 28.0)
    (effect,) = proposal.effects
    assert proposal.changes is ProposalClass.TOOL_OFFSET
    assert -0.028 < effect.size_change_mm < -0.5 * 0.028, "not more than the error, and not confirmed yet"
    assert effect.error_before_mm == pytest.approx(0.0277, abs=0.001)
    (other,) = _proposed(-26.0, -29.0, -28.0)
    assert other.effects[0].size_change_mm == pytest.approx(-effect.size_change_mm)


def test_the_predicted_effect_is_the_change_times_its_gain_and_the_zone_is_counted_by_hand() -> None:
    """Limits ± 30 µm: the share inside is Φ((30 − e)/u) − Φ((−30 − e)/u)."""
    from statistics import NormalDist

    one = followed(26.0, 29.0, 28.0)
    effect, gain = effect_of(one, -0.020), one.last.step.gain
    assert gain is not None
    assert effect.error_after_mm - effect.error_before_mm == pytest.approx(-0.020 * gain)
    of_part = NormalDist(effect.error_after_mm, effect.standard_u_mm)
    assert effect.probability_in_after == pytest.approx(of_part.cdf(0.030) - of_part.cdf(-0.030), abs=1e-6)


def test_an_accepted_proposal_is_not_proposed_again_before_a_part_was_cut_with_it() -> None:
    (series,) = series_of(seen(26.0, 29.0, 28.0))
    (first,) = proposals_of([tracked(series)], SeriesOptions(), BY)
    in_force = {series.identity: -first.effects[0].size_change_mm}
    again = tracked(series, in_force_mm=in_force)
    assert proposals_of([again], SeriesOptions(), BY) == ()
    assert effect_of(again, 0.0).error_before_mm == pytest.approx(first.effects[0].error_after_mm)


class Lathe:
    """A stand-in for the shop: a level that wanders, scatter, and offsets that act by a share of themselves."""

    def __init__(self, seed: int, drift_um: float, gain: float = 1.0) -> None:
        rng = np.random.default_rng(seed)
        self.level_um = rng.normal(0, 20) + np.cumsum(rng.normal(0, drift_um, 40))
        self.noise_um, self.gain = rng.normal(0, 3.0, 40), gain

    def error_um(self, part: int, offset_um: float) -> float:
        """What an inspection finds; a positive offset makes the part larger."""
        return float(self.level_um[part] + self.gain * offset_um + self.noise_um[part])


def _closed_loop(lathe: Lathe, parts: int) -> tuple[Series, list[bool]]:
    """Part by part: inspected, proposed, accepted, cut with it."""
    done: list[PartSeen] = []
    offset_um, inside = 0.0, list[bool]()
    for k in range(parts):
        part = inspection(str(k + 1), {"journal": lathe.error_um(k, offset_um)})
        identity = series_of([PartSeen(part)])[0].identity
        done.append(PartSeen(part, {identity: -offset_um / 1000}))
        (series,) = series_of(done)
        now = tracked(series)
        inside.append(bool(now.last.inside))
        for proposal in proposals_of([now], SeriesOptions(largest_mm=1.0), BY):
            if proposal.changes is ProposalClass.TOOL_OFFSET:
                offset_um += 1000 * proposal.effects[0].size_change_mm
    return series, inside


def test_a_simulated_shop_comes_to_its_nominal_size_and_stays_there() -> None:
    """Scatter 3 µm and drift 0.5 µm a part: nobody leaves less than 3 µm; a sign turned round would run away."""
    left_um, inside = list[float](), list[bool]()
    for seed in range(8):
        series, held = _closed_loop(Lathe(seed, 0.5), 20)
        left_um += [1000 * one.error_mm for one in series.made[5:]]
        inside += held[1:]
    assert np.sqrt(np.mean(np.square(left_um))) < 1.25 * np.hypot(3.0, 0.5)
    assert 0.90 < np.mean(inside) <= 1.0


def test_an_actuator_that_does_half_of_what_is_asked_is_still_corrected() -> None:
    series, _ = _closed_loop(Lathe(3, 0.0, gain=0.6), 20)
    assert abs(np.mean([1000 * one.error_mm for one in series.made[10:]])) < 3.0


def test_the_replay_leaves_what_arithmetic_leaves() -> None:
    """E − c with the c of the part before; the mean of 20, 26 and 29 is 25, so the fourth part keeps 3 of 28 µm."""
    (series,) = series_of(seen(20.0, 26.0, 29.0, 28.0))
    found = replay(series)
    assert [one.uncorrected_mm - one.correction_mm for one in found.parts] == [one.left_mm for one in found.parts]
    assert found.parts[0].correction_mm == 0.0 and found.parts[0].left_mm == pytest.approx(0.020)
    assert found.rivals_mm["mean of all parts before"][3] == pytest.approx(0.003)
    assert found.rivals_mm["0.75 of the part before"][3] == pytest.approx(0.028 - 0.75 * 0.029)
    shorter = replay(replace(series, made=series.made[:3]))
    assert found.parts[:3] == shorter.parts, "what comes later changes nothing before"


def test_a_jump_alarms_and_memory_is_to_begin_anew() -> None:
    one = followed(10.0, 11.0, 9.0, 10.0, 12.0, 10.0, 60.0)
    assert one.open_alarm is not None and one.open_alarm.made.serial == "7"
    restart = next(p for p in proposals_of([one], SeriesOptions(), BY) if p.changes is ProposalClass.MEMORY)
    assert restart.from_serial == "7"
    anew = [
        replace(part, begin_anew=frozenset({one.series.identity}) if part.serial == "7" else frozenset())
        for part in seen(10.0, 11.0, 9.0, 10.0, 12.0, 10.0, 60.0)
    ]
    again = tracked(series_of(anew)[0])
    assert again.open_alarm is None
    level_mm = again.last.step.level_mm
    assert level_mm is not None and level_mm == pytest.approx(0.060, abs=0.003)


def test_errors_that_keep_changing_their_sign_propose_a_smaller_weight() -> None:
    """Corrections that overshoot, one after the other [4773 §3.5]."""
    errors = [15.0 if k % 2 else -15.0 for k in range(16)]
    found = [p for p in _proposed(*errors) if p.changes is ProposalClass.WEIGHT]
    assert [one.weight for one in found] == [pytest.approx(REDUCED)]


def test_stages_never_touch_programs_or_values_of_real_time() -> None:
    """[4773 §3, §5]: stage 2 has nothing left in this loop, stage 3 never adjusts, stage 5 goes along."""
    assert may_change(Stage.PATHS) == may_change(Stage.IDENTIFICATION) == frozenset()
    assert ADJUSTS[Stage.PATHS] == {Parameter.NC_CODE, Parameter.REAL_TIME}
    assert [stage_of(one) for one in ProposalClass] == [Stage.OFFSETS, Stage.MODEL, Stage.WEIGHTS]


def test_a_part_filled_in_is_left_out_and_a_single_value_counts() -> None:
    parts = [
        PartSeen(inspection("1", {"a": 3.0, "b": 0.0, "c": -2.0})),
        PartSeen(inspection("2", {"a": 0.0, "b": 0.0, "c": 0.0})),
    ]
    kept, findings = usable(parts, take_nominal=False)
    assert [one.serial for one in kept] == ["1"]
    assert [(one.code, one.severity) for one in findings] == [
        (Code.SER_NOMINAL, Severity.NOTE),
        (Code.SER_NOMINAL, Severity.WARNING),
    ]
    assert [one.serial for one in usable(parts, take_nominal=True)[0]] == ["1", "2"]


def test_another_nominal_is_another_series_and_the_earlier_one_proposes_nothing() -> None:
    revised = [replace(inspection(str(k), {}), values=(reading("journal", 20.0, 24.1),)) for k in (4, 5)]
    both = series_of([*seen(26.0, 29.0, 28.0), *map(PartSeen, revised)])
    assert [(one.latest, len(one.made)) for one in both] == [(False, 3), (True, 2)]
    (proposal,) = proposals_of([tracked(one) for one in both], SeriesOptions(), BY)
    assert proposal.effects[0].parts == 2


@pytest.mark.parametrize(("factor", "found"), [(25.4, True), (1 / 25.4, True), (10.0, False), (1.001, False)])
def test_another_unit_is_noticed_by_its_factor(factor: float, found: bool) -> None:
    other = replace(inspection("2", {}), values=(reading("journal", 20.0, 24.0 * factor),))
    _, findings = usable([PartSeen(inspection("1", {"journal": 20.0})), PartSeen(other)], take_nominal=False)
    assert (Code.SER_UNIT in [one.code for one in findings]) is found


def test_the_order_is_that_of_the_cuts_then_of_the_clock_then_as_kept() -> None:
    late, early = MADE + timedelta(hours=2), MADE
    assert parts_in_order([When("1", 0, 2, None, early), When("2", 1, 1, None, late)])[0] == (1, 0)
    order, findings = parts_in_order([When("1", 0, measured_at=late), When("2", 1, measured_at=early)])
    assert order == (1, 0) and {one.code for one in findings} == {Code.SER_ORDER}
    assert parts_in_order([When("1", 0, measured_at=early), When("2", 1, measured_at=late)]) == ((0, 1), ())
    assert parts_in_order([When("1", 0, measured_at=late), When("2", 1)]) == ((0, 1), ())


def _stepped() -> tuple[Characteristic, ...]:
    return (
        Characteristic("d", Quantity.DIAMETER, "journal", 24.0),
        Characteristic("l", Quantity.LENGTH, "shoulder", 12.0),
    )


def test_an_offset_moves_a_diameter_by_twice_x_and_a_length_by_z() -> None:
    """A shoulder that faces the free end at z = −12: moved towards the chuck, its length from z = 0 grows."""
    profile = checked_profile(
        [
            Line("seat", (15.0, -30.0), (15.0, -12.0)),
            Line("shoulder", (15.0, -12.0), (12.0, -12.0)),
            Line("journal", (12.0, -12.0), (12.0, 0.0)),
        ],
        {},
    )
    diameter, length = (moved_by_offset(profile, one) for one in _stepped())
    assert diameter == pytest.approx([2.0, 0.0]) and length == pytest.approx([0.0, -1.0])
    (x_mm, z_mm), known = fitted_offset(
        np.array([diameter, length]), np.array([-0.020, 0.009]), np.array([0.002, 0.002])
    )
    assert (x_mm, z_mm) == pytest.approx((-0.010, -0.009))
    assert known == pytest.approx((1.96 * 0.001, 1.96 * 0.002), rel=1e-3)
    offset_mm, known = fitted_offset(diameter[None], np.array([-0.020]), np.array([0.002]))
    assert offset_mm == pytest.approx((-0.010, 0.0)) and known[1] is None


def test_no_offset_changes_a_length_between_two_faces_of_one_tool() -> None:
    """Both faces move by dZ; where each has a tool of its own, dZ of either changes the length."""
    profile = checked_profile(
        [
            Line("seat", (15.0, -30.0), (15.0, -12.0)),
            Line("shoulder", (15.0, -12.0), (12.0, -12.0)),
            Line("journal", (12.0, -12.0), (12.0, 0.0)),
            Line("end", (12.0, 0.0), (0.0, 0.0)),
        ],
        {},
    )
    _, from_zero = _stepped()
    between = replace(from_zero, other="end")
    for length in (from_zero, between):  # the end face stands at the part's zero
        assert moved_by_offset(profile, length) == pytest.approx([0.0, 0.0])
        assert moved_by_offset(profile, length, 0.0, (1, 2)) == pytest.approx([0.0, -1.0])
        assert moved_by_offset(profile, length, 0.0, (3,)) == pytest.approx([0.0, 1.0])
    assert moved_by_offset(profile, from_zero, -50.0) == pytest.approx([0.0, 1.0]), "the zero is a stop at z = -50"


def test_a_decision_overrides_only_what_is_named() -> None:
    one = followed(26.0, 29.0, 28.0)
    (proposal,) = proposals_of([one], SeriesOptions(), BY)
    now, series = MADE + timedelta(days=30), {one.series.identity: one}

    def decided(*override: str) -> Sequence[str]:
        options = SeriesOptions(largest_mm=0.010)
        return decide(proposal, "accepted", "me", now, series, (), options, override=override).overrides

    with pytest.raises(TrueloopError, match="SER-LARGE"):
        decided("old")
    with pytest.raises(TrueloopError, match="SER-OLD"):
        decided("large")
    assert set(decided("large", "old")) == {"SER-LARGE", "SER-OLD"}
    assert decide(proposal, "rejected", "me", now, series, (), SeriesOptions()).verdict == "rejected"


def test_capability_by_hand_and_not_before_twenty_parts() -> None:
    """Mean 10 µm, s 2 µm to limits at ± 30 µm: Ppk = 20/(3·2) = 3.33."""
    errors = [8.0, 12.0] * 10
    s = np.std(errors, ddof=1)
    (series,) = series_of(seen(*errors))
    found = capability(series)
    assert found is not None and found.ppk == pytest.approx(20.0 / (3.0 * s))
    assert found.lower < found.ppk
    one_sided = replace(series, characteristic=replace(series.characteristic, upper_limit=None))
    below = capability(one_sided)
    assert below is not None and below.ppk == pytest.approx(40.0 / (3.0 * s)), "10 µm of error and 30 µm to the limit"
    assert capability(series_of(seen(*errors[:-1]))[0]) is None


def test_a_simulated_series_is_cut_with_what_its_own_parts_propose() -> None:
    """Against the shop's own arithmetic: found = uncorrected − gain · correction + noise, at a cylinder."""
    shop = Shop(parts=25, gain=1.4, changed_at=15)
    found = simulate(shop, np.random.default_rng(5))
    drawn = draw(replace(shop, angle_rad=CYLINDER), np.random.default_rng(5))
    for k, part in enumerate(found.parts):
        free_mm = float(drawn.uncorrected_mm[k, 0] + drawn.noise_mm[k, 0])
        assert part.measured_mm == pytest.approx(free_mm)
        assert part.left_mm == pytest.approx(free_mm - 1.4 * part.correction_mm)
    assert [part.serial for part in found.parts if part.set_before] == ["16"]
    assert found.parts[0].correction_mm == 0.0


def test_the_mean_of_a_simulated_series_is_that_of_what_was_found_before() -> None:
    found = simulate(Shop(parts=6), np.random.default_rng(2))
    free = np.array([part.measured_mm for part in found.parts])
    left = found.rivals_mm["mean of all parts before"]
    assert left[1:] == pytest.approx([free[k] - free[:k].mean() for k in range(1, 6)])


def test_memory_leaves_less_than_doing_nothing_in_most_simulated_shops() -> None:
    """Settings of 20 µm, scatter of 3: without a correction a level stays on."""
    better = [
        (found.rms_mm() or 0.0) < (found.rms_mm("measured") or 0.0)
        for found in (simulate(Shop(parts=20), np.random.default_rng(seed)) for seed in range(12))
    ]
    assert sum(better) >= 10
