"""The way of the ball from where the probing move begins to the surface."""

import pytest

from tests.support.probing import APPROACH, plan_of
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Line
from trueloop.geometry.validate import checked_profile
from trueloop.probing.stylus import Stylus

CORNERS = [(10.05, -30.0), (10.05, -20.8), (10.0, -20.8), (10.0, -25.0), (8.0, -25.0), (8.0, -15.0), (10.0, -15.0),
           (10.0, -19.2), (10.05, -19.2), (10.05, 0.0)]  # fmt: skip
NAMES = ("chuck-side", "lip", "ceiling", "wall", "floor", "wall-2", "ceiling-2", "lip-2", "cylinder")
SLOT = checked_profile([Line(name, a, b) for name, a, b in zip(NAMES, CORNERS[:-1], CORNERS[1:], strict=True)])
"""A chamber 2 mm deep under a mouth 1.6 mm wide between lips 0.05 mm thick."""


def test_a_ball_is_not_sent_through_a_mouth_narrower_than_itself() -> None:
    """At its start above the lips and at the floor beneath them a ball of 2 mm is free, between them it is not."""
    with pytest.raises(TrueloopError, match="left to 'chuck-side'") as refused:
        plan_of(SLOT, {"floor": 1}, APPROACH, Stylus(1.0, 0.3))
    assert refused.value.code is Code.PRB_REACH
    thin = plan_of(SLOT, {"floor": 1}, APPROACH, Stylus(0.25, 0.1))
    assert thin.touches[0].feature == "floor"
