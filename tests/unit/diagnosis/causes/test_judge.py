"""Causes of series whose truth was written down before."""

import re
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from studies.diagnosed.seen import seen_series
from studies.diagnosed.shop import Shop, cut_series
from studies.diagnosed.truth import Fault, Truth, Wrong
from trueloop.diagnosis.causes.cause import Diagnosis, SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.causes.judge import judge
from trueloop.diagnosis.features.feature_error import SeenPoints
from trueloop.errors import Code, TrueloopError

TOOLS = ("T1", "T2", "T3")
SHOP = Shop(tools=TOOLS, parts=8, set_anew=(4,), standard_at=(0,))


def series(*wrong: Wrong, shop: Shop = SHOP, gain: float = 1.0, seed: int = 5) -> SeenSeries:
    return seen_series(cut_series(Truth(wrong, gain), shop, seed))


def best(found: Diagnosis) -> tuple[str, ...]:
    return found.hypotheses[0][0]


def probability(found: Diagnosis, key: str) -> float:
    return sum(share for keys, share in found.hypotheses if key in keys)


def seen_only_by(whole: SeenSeries, seen_by: SeenBy) -> SeenSeries:
    parts = (replace(part, points={seen_by: part.points[seen_by]}) for part in whole.parts)
    return replace(whole, parts=tuple(parts))


@pytest.mark.parametrize(
    ("wrong", "key"),
    [
        (Wrong(Fault.TOOL_OFFSET, 0.012, "T1"), "tool-setting"),
        (Wrong(Fault.WEAR, 0.015, "T1"), "tool-wear"),
        (Wrong(Fault.PROBE_OFFSET, 0.010), "part-probe-offset"),
        (Wrong(Fault.UNEQUAL_DEPTH, 0.015), "unequal-depth"),
        (Wrong(Fault.TWO_TOOLS, 0.012, "T3"), "two-tools"),
        (Wrong(Fault.PART_DEFLECTION, 0.015), "part-deflection"),
        (Wrong(Fault.FACE_DEFLECTION, 0.015), "tool-deflection"),
        (Wrong(Fault.CONSTANT_SPEED, 0.015), "constant-speed"),
        (Wrong(Fault.CHATTER, 0.006), "chatter"),
        (Wrong(Fault.RUN_OUT, 0.010), "chuck"),
        (Wrong(Fault.JAWS, 0.010), "jaws"),
        (Wrong(Fault.TOOL_SEAT, 0.012, "T1"), "tool-seat"),
        (Wrong(Fault.PROBE_LOOSE, 0.012), "fixturing-part-probe"),
        (Wrong(Fault.AXIS_ERROR, 0.012, error="EX0C", signal="T spindle"), "machine"),
    ],
)
def test_one_cause_is_named_with_its_remedy(wrong: Wrong, key: str) -> None:
    found = judge(series(wrong))
    assert best(found) == (key,)
    assert found.candidates[0].cause.key == key
    assert found.candidates[0].probability > 0.5
    assert found.candidates[0].supports
    tools = {one.tool for one in found.candidates if one.cause.key == key}
    assert wrong.tool in tools


def test_nothing_is_found_in_a_sound_shop() -> None:
    found = judge(series())
    assert best(found) == ()
    assert found.sound > 0.8
    assert found.gain == 1.0
    assert found.findings == ()


def test_probabilities_add_up_to_one() -> None:
    found = judge(series(Wrong(Fault.TOOL_OFFSET, 0.004, "T1")))
    assert sum(share for _, share in found.hypotheses) == pytest.approx(1.0)
    assert all(0.0 <= one.probability <= 1.0 + 1e-12 for one in found.candidates)


def test_a_tool_that_stands_too_far_out_leaves_that_much_on() -> None:
    whole = replace(series(Wrong(Fault.TOOL_OFFSET, 0.012, "T1"), shop=replace(SHOP, set_anew=())))
    found = judge(whole).candidates[0]
    assert found.cause.key == "tool-setting"
    assert found.size_mm == pytest.approx(0.012, abs=4 * found.standard_u_mm + 0.001)


def test_an_offset_that_only_the_machine_was_asked_about_stays_a_set() -> None:
    shop = replace(SHOP, tools=("T1",), standard_at=(), set_anew=())
    found = judge(seen_only_by(series(Wrong(Fault.TOOL_OFFSET, 0.012, "T1"), shop=shop), SeenBy.MACHINE))
    assert probability(found, "part-probe-offset") > 0.1
    assert probability(found, "tool-setting") > 0.1
    assert any("measuring machine" in words for words in found.decide)
    assert any("standard part" in words for words in found.decide)


def test_without_a_probe_on_the_machine_tool_and_machine_stay_a_set() -> None:
    shop = replace(SHOP, tools=("T1",), standard_at=(), set_anew=(), steady=True)
    found = judge(seen_only_by(series(Wrong(Fault.TOOL_OFFSET, 0.012, "T1"), shop=shop), SeenBy.CMM))
    assert probability(found, "machine") > 0.05
    assert probability(found, "tool-setting") > 0.1
    assert any("on the machine" in words for words in found.decide)


@pytest.mark.parametrize("gain", [0.0, 1.0, 2.0])
def test_the_share_of_a_correction_that_arrived_is_found(gain: float) -> None:
    wrong = Wrong(Fault.TOOL_OFFSET, 0.012, "T1")
    shop = replace(SHOP, set_anew=(), corrected_from=5)
    found = judge(series(wrong, shop=shop, gain=gain))
    assert found.gain == gain
    assert [one.code for one in found.findings] == ([] if gain == 1.0 else [Code.DIA_GAIN])
    assert probability(found, "tool-setting") > 0.5


def test_times_that_contradict_the_order_are_found() -> None:
    whole = series()
    third = replace(whole.parts[3], at=datetime(2026, 3, 1) - timedelta(days=1))
    found = judge(replace(whole, parts=(*whole.parts[:3], third, *whole.parts[4:])))
    assert [one.code for one in found.findings] == [Code.DIA_CLOCK]
    assert found.findings[0].values == {"part": third.serial}


def test_parts_without_errors_are_refused() -> None:
    with pytest.raises(TrueloopError) as caught:
        judge(SeenSeries({}, (SeenPart("A", 0, {SeenBy.CMM: ()}),)))
    assert caught.value.code is Code.DIA_FEW


def test_one_part_gives_a_set() -> None:
    whole = series(Wrong(Fault.TOOL_OFFSET, 0.02, "T1"))
    found = judge(replace(whole, parts=whole.parts[1:2]))
    assert found.sound < 0.1
    assert len([one for one in found.candidates if one.probability > 0.02]) > 2
    assert found.decide


def without_tools(whole: SeenSeries) -> SeenSeries:
    """As a store has it where neither a job nor a cut names a tool: no settings, no times, no depths."""
    features = {name: replace(place, tool="") for name, place in whole.features.items()}
    parts = (replace(part, setting={}, minutes_in_cut={}, depth_of_cut_mm={}) for part in whole.parts)
    return SeenSeries(features, tuple(parts))


ONE_SETTING = Shop(tools=("T1",), parts=6, set_anew=(), cut_mm=0.0005)


def test_no_minutes_are_stated_where_none_are_recorded() -> None:
    whole = series(Wrong(Fault.WEAR, 0.015, "T1"), shop=ONE_SETTING)
    untimed = replace(whole, parts=tuple(replace(part, minutes_in_cut={}) for part in whole.parts))
    (wear,) = (candidate for candidate in judge(untimed).candidates if candidate.cause.key == "tool-wear")
    (said,) = (line for line in wear.supports if line.startswith("It goes with"))
    assert "with the parts since the tool was set" in said and " min" not in said


def test_what_the_machine_did_is_in_what_is_measured_and_in_no_cause() -> None:
    """The surfaces carry 20 µm more, or less, which a model of the machine tells: causes are those of the process, and
    the means that are stated are as measured beside those of the process.
    """
    whole = series(Wrong(Fault.TOOL_OFFSET, 0.012, "T1"), shop=ONE_SETTING)

    def carrying(part: SeenPart, carried_mm: float) -> SeenPart:
        points = {by: replace(some, error_mm=some.error_mm + carried_mm) for by, some in part.points.items()}
        return replace(part, points=points, carried_mm={by: 0 * p.error_mm + carried_mm for by, p in points.items()})

    def means_um(found: Diagnosis) -> list[float]:
        said = found.candidates[0].supports[0]
        return [float(one.replace("−", "-")) for one in re.findall(r"([−\d.]+) µm", said)]

    plain = judge(whole)
    assert best(plain) == ("tool-setting",)
    process_um = means_um(plain)
    for carried_um in (20.0, -20.0):
        found = judge(replace(whole, parts=tuple(carrying(part, 1e-3 * carried_um) for part in whole.parts)))
        assert best(found) == best(plain)
        assert probability(found, "tool-setting") == pytest.approx(probability(plain, "tool-setting"), abs=1e-6)
        measured_um, of_process_um = means_um(found)[::2], means_um(found)[1::2]
        assert of_process_um == process_um
        assert measured_um == pytest.approx([um + carried_um for um in process_um], abs=0.11)


@pytest.mark.parametrize("size_mm", [0.012, -0.006])
def test_a_tool_set_off_is_first_though_nothing_names_the_tool(size_mm: float) -> None:
    found = judge(without_tools(series(Wrong(Fault.TOOL_OFFSET, size_mm, "T1"), shop=ONE_SETTING)))
    assert best(found) == ("tool-setting",)
    assert probability(found, "fixturing-tool-probe") < probability(found, "tool-setting")
    assert found.candidates[0].size_mm == pytest.approx(size_mm, abs=0.0015)


def test_one_length_that_is_off_alone_is_that_of_two_tools() -> None:
    shop = replace(ONE_SETTING, tools=("T1", "T2"))
    found = judge(without_tools(series(Wrong(Fault.TWO_TOOLS, -0.015, "T2"), shop=shop)))
    assert best(found) == ("two-tools",)


def test_a_form_that_no_cause_leaves_is_not_in_the_catalogue() -> None:
    """One feature of six stands off by other amounts on every part, the others do not."""
    whole = series(shop=ONE_SETTING)
    rng = np.random.default_rng(3)

    def bent(part: SeenPart) -> SeenPart:
        by, change = dict[SeenBy, SeenPoints](), rng.normal(0.0, 0.012)
        for seen_by, points in part.points.items():
            own = np.array([name == "shaft 2" for name in points.feature])
            by[seen_by] = replace(points, error_mm=points.error_mm + change * own)
        return replace(part, points=by)

    found = judge(replace(whole, parts=tuple(bent(part) for part in whole.parts)))
    assert best(found) == ("other",)
    assert found.candidates[0].features == ("shaft 2",)
