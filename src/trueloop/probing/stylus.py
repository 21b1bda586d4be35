"""The stylus, and whether it can go somewhere without touching anything."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.option import Option
from trueloop.probing.obstacle import CHORD_MM, Obstacle

FINEST_STEP_MM: Final = 0.01

Clearance: TypeAlias = Callable[[Obstacle, Array], tuple[float, str]]
"""Maps an obstacle and a ball centre to the clearance of a part of the stylus, mm, and to what is nearest."""


@dataclass(frozen=True)
class Stylus:
    """A ball on a stem; lengths in mm.

    `stem_angle_rad` is the direction from the ball along the stem, from +z towards +x: π/2 for a probe that reaches in
    from the side. The stem is a straight bar with round ends, from the ball to `stem_length_mm` off its centre.
    """

    ball_radius_mm: Annotated[float, Option("stylus.ball_radius_mm", "Radius of the ball.", above=0)]
    stem_radius_mm: Annotated[float, Option("stylus.stem_radius_mm", "Radius of the stem.", above=0)]
    stem_length_mm: Annotated[
        float, Option("stylus.stem_length_mm", "From the ball's centre to where the probe's body begins.", above=0)
    ] = 50.0
    stem_angle_rad: Annotated[
        float,
        Option(
            "stylus.stem_angle_deg",
            "Where the stem leaves the ball, from +z towards +x: 90 away from the axis, 0 away from the chuck.",
        ),
    ] = math.pi / 2

    @property
    def stem_direction(self) -> Array:
        """Returns the unit vector from the ball along the stem, (2,)."""
        return np.array([math.sin(self.stem_angle_rad), math.cos(self.stem_angle_rad)])

    def ball_clearance_mm(self, obstacle: Obstacle, centre_mm: Array) -> tuple[float, str]:
        """Returns the clearance between ball and obstacle, and what is nearest."""
        distance, nearest = obstacle.distance_mm(centre_mm, centre_mm)
        return distance - self.ball_radius_mm - CHORD_MM, nearest

    def stem_clearance_mm(self, obstacle: Obstacle, centre_mm: Array) -> tuple[float, str]:
        """Returns the clearance between stem and obstacle, and what is nearest."""
        along = self.stem_direction
        ends = centre_mm + self.ball_radius_mm * along, centre_mm + self.stem_length_mm * along
        distance, nearest = obstacle.distance_mm(*ends)
        return distance - self.stem_radius_mm - CHORD_MM, nearest

    def clearance_mm(self, obstacle: Obstacle, centre_mm: Array) -> tuple[float, str]:
        """Returns the clearance between obstacle and ball or stem, whichever is closer, and what is nearest."""
        return min(self.ball_clearance_mm(obstacle, centre_mm), self.stem_clearance_mm(obstacle, centre_mm))


@dataclass(frozen=True)
class Meeting:
    """The place where a straight move comes too close: the ball's centre, what it comes close to, and the clearance."""

    centre_mm: tuple[float, float]
    with_what: str
    clearance_mm: float


def first_meeting(
    clearance_mm: Clearance, obstacle: Obstacle, start_mm: Array, end_mm: Array, margin_mm: float
) -> Meeting | None:
    """Returns the first place on a straight move where less than the margin is left; None when the way is free.

    Nothing is missed between the places looked at: moving by d changes a clearance by at most d, so that what is left
    over the margin may be gone at once.
    """
    length, done = math.dist(start_mm, end_mm), 0.0
    direction = (end_mm - start_mm) / length if length > 0.0 else np.zeros(2)
    while True:
        centre = start_mm + done * direction
        clearance, what = clearance_mm(obstacle, centre)
        if clearance < margin_mm:
            return Meeting((float(centre[0]), float(centre[1])), what, clearance)
        if done >= length:
            return None
        # A hundredth more than is free would be needed to pass through a corner unseen: the margin holds that.
        done = min(done + max(clearance - margin_mm, FINEST_STEP_MM), length)
