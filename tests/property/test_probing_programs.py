"""Probing programs over any profile: every touch is met where it was planned, and nothing is met before it.

Programs are read back by LinuxCNC's interpreter (its dialect), by trueloop's reader (GE 2000T) and by a reader of words
that knows neither; what the stylus does on the way is checked densely against the part's polygon.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import Tool, interpret
from tests.support.probing import APPROACH, ProbeMove, example_plan, moves_of, plan_of
from tests.support.profiles import profiles
from trueloop.controllers.probing import WRITERS, Settings, probing_program
from trueloop.errors import Code, TrueloopError
from trueloop.gauging.obstacle import CHORD_MM, stock_obstacle
from trueloop.gauging.probe_plan import ProbePlan
from trueloop.gauging.stylus import Stylus
from trueloop.geometry.feature import Array
from trueloop.geometry.profile import Profile
from trueloop.nc.program import read_program
from trueloop.nc.tool_path import Motion

MICROMETRE = 1e-3
ROUNDED_MM = 3e-4  # coordinates to 1e-5 in
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
    """Every probing move meets the part first where the plan says; every other move stays clear with ball and stem."""
    allowance, stylus = plan.approach.allowance_mm, plan.stylus
    obstacle = stock_obstacle(profile, allowance)
    touches = iter(plan.touches)
    for move in moves:
        start, end = np.array(move.start_mm), np.array(move.end_mm)
        if move.touching:
            touch = next(touches)
            met = where_the_ball_meets(profile, allowance, stylus, start, end)
            assert met is not None, touch
            assert math.dist(met, touch.contact_mm) < MICROMETRE + CHORD_MM, touch
            continue
        back = any(math.dist(move.end_mm, t.start_mm) < ROUNDED_MM for t in plan.touches) and any(
            math.dist(move.start_mm, t.target_mm) < ROUNDED_MM for t in plan.touches
        )
        if back:
            continue  # retraces the probing move
        for share in np.linspace(0.0, 1.0, 25):
            clearance, what = stylus.clearance_mm(obstacle, start + share * (end - start))
            assert clearance > min(plan.approach.margin_mm, plan.approach.stand_off_mm) - 0.02, (move, what)
    assert next(touches, None) is None


@settings(max_examples=25)
@given(profile=profiles(), control=st.sampled_from(SKIP_CONTROLS), inch=st.booleans(), diameter=st.booleans())
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
    diameter = diameter or control == "ge2000t"
    text = probing_program(plan, control, Settings(inch=inch, diameter=diameter))
    feed = "F60." if not inch else f"F{60 / 25.4:.5f}".rstrip("0")
    moves = moves_of(text.replace(feed, "F60."), inch=inch, diameter=diameter)
    require_safe(plan, profile, moves)


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


@pytest.mark.parametrize("control", ["linuxcnc", "ge2000t"])
def test_our_own_reader_finds_the_same_moves(control: str) -> None:
    plan = example_plan("piecs11")
    path = read_program(probing_program(plan, control, Settings()).encode(), control).run()
    ends = path.end_mm[path.motion != Motion.RAPID][:, [0, 2]]
    for touch in plan.touches:
        assert np.min(np.hypot(*(ends - np.array(touch.target_mm)).T)) < ROUNDED_MM
    assert not [found for found in path.findings if found.severity == "error"]


def test_macros_measure_along_one_axis() -> None:
    """P9811 names the surface itself: 40.1 mm of radius are 80.2 of diameter, the face stands at z = 0.1."""
    from tests.support.probing import STEP

    text = probing_program(
        plan_of(STEP, {"cylinder": 2, "face": 2}, replace(APPROACH, allowance_mm=0.1)), "renishaw", Settings()
    )
    assert text.count("G65 P9811 X80.2 Q1.") == 2
    assert text.count("G65 P9811 Z0.1 Q1.") == 2
    assert text.index("G65 P9832") < text.index("G65 P9811") < text.index("G65 P9833")
