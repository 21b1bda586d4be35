"""Probing programs over any profile: every touch is met where it was planned, and nothing is met before it.

Programs are read back by trueloop's own readers of the controls' dialects, LinuxCNC's by its own interpreter as well;
what the stylus does on the whole way is checked against the part with its stock.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import Tool, interpret
from tests.support.probing import APPROACH, EXAMPLES, STEP, STYLUS, ProbeMove, example, example_plan, moves_of, plan_of
from tests.support.profiles import profiles
from trueloop.arrays import Array
from trueloop.controllers.probing import WRITERS, Settings, probing_program
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.measure.probing import read_probing
from trueloop.probing.calibration import CHORD_MM, Stylus, stock_obstacle
from trueloop.probing.probe_plan import ProbePlan, SecondTouch

MICROMETRE = 1e-3
ROUNDED_MM = 3e-4  # coordinates to 1e-5 in
DIAMETERS = ("fanuc", "haas", "ge2000t")
"""Controls that take X as a diameter whatever the program says."""

LOOP = EXAMPLES / "loop" / "modbas2.toml"
SKIP_CONTROLS = [name for name in WRITERS if name != "renishaw"]


def where_the_ball_meets(
    profile: Profile, allowance_mm: float, stylus: Stylus, start: Array, end: Array
) -> Array | None:
    """The first position on a move at which the ball touches the part, by halving, None when it meets nothing."""
    obstacle = stock_obstacle(profile, allowance_mm)

    def free(share: float) -> bool:
        centre = start + share * (end - start)
        return obstacle.distance_mm(centre, centre)[0] > stylus.ball_radius_mm

    if free(1.0) and all(free(share) for share in np.linspace(0.0, 1.0, 41)):
        return None
    low, high = 0.0, next(share for share in np.linspace(0.0, 1.0, 41) if not free(share))
    low = max(0.0, high - 1 / 40)
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if free(middle) else (low, middle)
    met: Array = start + low * (end - start)
    return met


def require_safe(plan: ProbePlan, profile: Profile, moves: list[ProbeMove]) -> None:
    """Every probing move meets the part first where the plan says, and goes back as it came; on all ways between, ball
    and stem stay clear of the part.

    A clearance changes by no more than the way gone: what keeps half a step where it is looked at is clear between.
    """
    stylus, allowance_mm = plan.stylus, plan.approach.allowance_mm
    obstacle, margin_mm = stock_obstacle(profile, allowance_mm), plan.approach.margin_mm - ROUNDED_MM
    touches, back_to = iter(plan.touches), None
    for move in moves:
        start, end = np.array(move.start_mm), np.array(move.end_mm)
        if move.touching:
            touch = next(touches)
            met = where_the_ball_meets(profile, allowance_mm, stylus, start, end)
            assert met is not None, touch
            assert math.dist(met, touch.contact_mm) < MICROMETRE + CHORD_MM, touch
            assert all(stylus.stem_clearance_mm(obstacle, at)[0] > 0.0 for at in along(start, met)), touch
            back_to = move.start_mm
            continue
        if back_to is not None:
            assert math.dist(move.end_mm, back_to) < ROUNDED_MM, move
            back_to = None
            continue
        clearances = [stylus.clearance_mm(obstacle, at) for at in along(start, end)]
        assert min(clearances)[0] > margin_mm, (move, min(clearances))
    assert next(touches, None) is None and math.dist(moves[-1].end_mm, plan.safe_mm) < ROUNDED_MM


def along(start: Array, end: Array) -> Array:
    """Places on a move, at most 0.4 mm apart."""
    share = np.linspace(0.0, 1.0, 2 + int(math.dist(start, end) / 0.4))
    places: Array = start + share[:, None] * (end - start)
    return places


@pytest.mark.parametrize("control", SKIP_CONTROLS)
@settings(max_examples=8)
@given(profile=profiles(), inch=st.booleans(), diameter=st.booleans())
def test_every_touch_is_met_where_planned_and_nothing_before(
    profile: Profile, control: str, inch: bool, diameter: bool
) -> None:
    counts = {feature.name: 3 for feature in profile.features if feature.length_mm > 8.0}
    assume(counts)
    try:
        plan = plan_of(profile, counts, replace(APPROACH, allowance_mm=0.1))
    except TrueloopError as refused:
        assert refused.code in (Code.PRB_REACH, Code.PRB_BALL)
        assume(False)
    program = Settings(inch=inch, diameter=diameter or control in DIAMETERS)
    require_safe(plan, profile, moves_of(probing_program(plan, control, program), control, plan, program))


@settings(max_examples=8)
@given(profile=profiles())
def test_ball_and_stem_are_free_as_far_as_the_ball_may_back_off(profile: Profile) -> None:
    """A touch may come as early as where the approach begins."""
    counts = {feature.name: 3 for feature in profile.features if feature.length_mm > 8.0}
    assume(counts)
    try:
        plan = plan_of(profile, counts, replace(APPROACH, allowance_mm=0.1, second=SecondTouch(1.5, 30.0)))
    except TrueloopError as refused:
        assert refused.code in (Code.PRB_REACH, Code.PRB_BALL)
        assume(False)
    obstacle = stock_obstacle(profile, 0.1)
    for touch in plan.touches:
        farthest = np.array(touch.start_mm) + 1.5 * np.array(touch.normal)
        places = along(np.array(touch.contact_mm), farthest)
        assert all(STYLUS.stem_clearance_mm(obstacle, at)[0] > 0.0 for at in places), touch
        assert STYLUS.ball_clearance_mm(obstacle, farthest)[0] > plan.approach.margin_mm - ROUNDED_MM, touch


@settings(max_examples=10)
@given(radius=st.floats(15.0, 60.0), length=st.floats(12.0, 80.0), inch=st.booleans())
def test_macros_meet_cylinders_and_faces_where_planned(radius: float, length: float, inch: bool) -> None:
    features = [Line("cylinder", (radius, -length), (radius, 0.0)), Line("face", (radius, 0.0), (0.0, 0.0))]
    profile = checked_profile(features)
    plan = plan_of(profile, {"cylinder": 3, "face": 3}, replace(APPROACH, allowance_mm=0.1))
    program = Settings(inch=inch)
    require_safe(plan, profile, moves_of(probing_program(plan, "renishaw", program), "renishaw", plan, program))


@pytest.mark.parametrize("control", SKIP_CONTROLS)
@pytest.mark.parametrize("name", ["facetst", "modbas2", "piecs11"])
def test_the_parts_of_nist_are_probed_without_a_collision(name: str, control: str) -> None:
    plan, program = example_plan(name), Settings()
    moves = moves_of(probing_program(plan, control, program), control, plan, program)
    require_safe(plan, example(name).profile, moves)


@pytest.mark.parametrize("control", ["linuxcnc", "siemens"])
def test_repeated_trials_touch_all_points_in_turn_and_nothing_between(control: str) -> None:
    once, probing = read_probing(LOOP), read_probing(LOOP, trials=3)
    plan, program = probing.plan, Settings()
    assert [touch.point for touch in plan.touches] == 3 * [touch.point for touch in once.plan.touches]
    moves = moves_of(probing_program(plan, control, program), control, plan, program)
    require_safe(plan, probing.part.profile, moves)


@pytest.mark.parametrize("name", ["facetst", "modbas2", "piecs11"])
def test_linuxcnc_reads_its_program_as_it_was_planned(name: str, tmp_path: Path) -> None:
    plan = example_plan(name)
    for diameter in (True, False):
        program = tmp_path / f"{name}-{diameter}.ngc"
        program.write_text(probing_program(plan, "linuxcnc", Settings(diameter=diameter)))
        probing = [move for move in interpret(program, tools=[Tool(9)]) if move.kind == "probe"]
        assert len(probing) == len(plan.touches)
        for move, touch in zip(probing, plan.touches, strict=True):
            start, target = touch.start_mm, touch.target_mm
            assert math.dist((move.start_mm[0], move.start_mm[2]), start) < ROUNDED_MM
            assert math.dist((move.end_mm[0], move.end_mm[2]), target) < ROUNDED_MM


def test_macros_measure_along_one_axis() -> None:
    """P9811 names the surface itself: 40.1 mm of radius are 80.2 of diameter, the face stands at z = 0.1."""
    text = probing_program(
        plan_of(STEP, {"cylinder": 2, "face": 2}, replace(APPROACH, allowance_mm=0.1)), "renishaw", Settings()
    )
    assert text.count("G65 P9811 X80.2 Q1.") == 2
    assert text.count("G65 P9811 Z0.1 Q1.") == 2
    assert text.index("G65 P9832") < text.index("G65 P9811") < text.index("G65 P9833")
