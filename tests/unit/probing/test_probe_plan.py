"""The way of the ball from where the probing move begins to the surface."""

from dataclasses import replace

import pytest

from tests.support.probing import APPROACH, plan_of
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Line
from trueloop.geometry.validate import checked_profile
from trueloop.probing.calibration import Stylus
from trueloop.probing.probe_plan import ProbePlan, SecondTouch

CORNERS = [(10.05, -30.0), (10.05, -20.8), (10.0, -20.8), (10.0, -25.0), (8.0, -25.0), (8.0, -15.0), (10.0, -15.0),
           (10.0, -19.2), (10.05, -19.2), (10.05, 0.0)]  # fmt: skip
NAMES = ("chuck-side", "lip", "ceiling", "wall", "floor", "wall-2", "ceiling-2", "lip-2", "cylinder")
SLOT = checked_profile([Line(name, a, b) for name, a, b in zip(NAMES, CORNERS[:-1], CORNERS[1:], strict=True)])
"""A chamber 2 mm deep under a mouth 1.6 mm wide between lips 0.05 mm thick."""


def test_a_ball_is_not_sent_through_a_mouth_narrower_than_itself() -> None:
    """At its start above the lips and at the floor beneath them a ball of 2 mm is free, between them it is not."""
    with pytest.raises(TrueloopError, match="clearance to 'chuck-side'") as refused:
        plan_of(SLOT, {"floor": 1}, APPROACH, Stylus(1.0, 0.3))
    assert refused.value.code is Code.PRB_REACH
    thin = plan_of(SLOT, {"floor": 1}, APPROACH, Stylus(0.25, 0.1))
    assert thin.touches[0].feature == "floor"


GROOVE = checked_profile(
    [
        Line("chuck-side", (40.0, -30.0), (40.0, -20.0)),
        Line("wall", (40.0, -20.0), (34.0, -20.0)),
        Line("floor", (34.0, -20.0), (34.0, -14.0)),
        Line("wall-2", (34.0, -14.0), (40.0, -14.0)),
        Line("cylinder", (40.0, -14.0), (40.0, 0.0)),
    ]
)
"""A groove 6 mm wide: between the ball of 1 mm that touches one wall and the other wall 5 mm are left."""


def test_the_ball_does_not_back_off_into_what_stands_opposite() -> None:
    """A touch may come where the approach begins, 2 mm from the wall: 2.4 mm farther back the margin is kept, not 3."""
    stylus = Stylus(0.5, 0.3)

    def plan(back_off_mm: float) -> ProbePlan:
        return plan_of(GROOVE, {"wall": 1}, replace(APPROACH, second=SecondTouch(back_off_mm, 30.0)), stylus)

    assert plan(2.4).touches[0].feature == "wall"
    with pytest.raises(
        TrueloopError, match=r"z -14\.500 mm the clearance to 'wall-2' is 0\.000 mm.*\n.*back-off"
    ) as refused:
        plan(3.0)
    assert refused.value.code is Code.PRB_REACH
