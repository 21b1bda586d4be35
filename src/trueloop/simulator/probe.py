"""The virtual touch probe: what the control reports when the ball meets the part."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import contact_angle_rad
from trueloop.simulator.machine import REFERENCE_C, MachineError
from trueloop.simulator.process import REACH_MM, Stock

SPREAD: Final = 21
ROUNDS: Final = 4


def ball_contact_mm(stock: Stock, points_mm: Array, normal: Array, ball_radius_mm: float) -> Array:
    """Returns the ball centre's position on each approach line at first contact, from the point along its normal, (n,).

    The ball meets the part where height(y) + √(r² − y²) is largest over the lines beside the approach line, y from −r
    to r: searched on a spread of lines, then closer around the best, to a tenth of a nanometre on smooth surfaces. An
    approach that runs into a neighbouring feature ends at that feature, or at the reach of the search plus r.
    """
    if ball_radius_mm <= 0.0:
        return stock.height_mm(points_mm, normal)
    beside = np.column_stack([normal[:, 1], -normal[:, 0]])
    middle = np.zeros(len(points_mm))
    half_width = ball_radius_mm
    best = np.full(len(points_mm), -np.inf)
    for _ in range(ROUNDS):
        y = np.clip(middle[:, None] + half_width * np.linspace(-1, 1, SPREAD), -ball_radius_mm, ball_radius_mm)
        lines = (points_mm[:, None, :] + y[..., None] * beside[:, None, :]).reshape(-1, 2)
        height = stock.height_mm(lines, np.repeat(normal, SPREAD, axis=0), REACH_MM).reshape(y.shape)
        meets = height + np.sqrt(np.maximum(ball_radius_mm**2 - y**2, 0.0))
        found = np.argmax(meets, axis=1)
        rows = np.arange(len(y))
        best, middle = np.maximum(best, meets[rows, found]), y[rows, found]
        half_width *= 3.0 / (SPREAD - 1)
    return best


@dataclass(frozen=True)
class VirtualProbe:
    """A ball on a switch. Lengths in mm.

    The probe trips when the ball has gone on by `pre_travel_mm` + `lobing_mm` · cos(lobes · (θ − phase)) after contact,
    θ the contact angle of the approach. `range_x_mm`, `range_z_mm`: range of repeated touches on each axis, uniform, as
    [6811 §4.1] states them. `overshoot_mm`: the control latches up to this much later, uniform. `calibrated_rad`: the
    contact angles between which it is calibrated before each part; None: those that the part asks for.
    """

    ball_radius_mm: float
    pre_travel_mm: float = 0.0
    lobing_mm: float = 0.0
    lobes: int = 3
    lobing_phase_rad: float = 0.0
    range_x_mm: float = 0.0
    range_z_mm: float = 0.0
    overshoot_mm: float = 0.0
    calibrated_rad: tuple[float, float] | None = None

    def trip_mm(self, normal: Array) -> Array:
        """Returns the travel after contact before the probe trips, for approaches against `normal`, (n,)."""
        turned = self.lobes * (contact_angle_rad(normal) - self.lobing_phase_rad)
        trip: Array = self.pre_travel_mm + self.lobing_mm * np.cos(turned)
        return trip

    def touch(
        self,
        stock: Stock,
        points_mm: Array,
        normal: Array,
        rng: np.random.Generator,
        error: MachineError | None = None,
        temperature_c: float = REFERENCE_C,
    ) -> Array:
        """Returns ball centres as the control reports them, (n, 2), of touches against the normals at the points.

        The machine errs while probing as well: the ball is at commanded + E, the control reports the commanded position
        [6876 §3.3, Fig. 9].
        """
        off = np.zeros_like(points_mm)
        if error is not None:
            off = error.error_mm(points_mm + self.ball_radius_mm * normal, temperature_c)
        contact = ball_contact_mm(stock, points_mm + off, normal, self.ball_radius_mm)
        late = self.trip_mm(normal) + self.overshoot_mm * rng.random(len(points_mm))
        scatter = (rng.random(points_mm.shape) - 0.5) * [self.range_x_mm, self.range_z_mm]
        reported: Array = points_mm + (contact - late)[:, None] * normal + scatter
        return reported

    def touch_sphere(
        self, centre_mm: tuple[float, float], radius_mm: float, angle_rad: Array, rng: np.random.Generator
    ) -> Array:
        """Returns reported ball centres on a calibration sphere (or in a ring gauge: negative radius), (n, 2)."""
        outward = np.column_stack([np.sin(angle_rad), np.cos(angle_rad)])
        normal = math.copysign(1.0, radius_mm) * outward
        at = np.asarray(centre_mm) + abs(radius_mm) * outward + self.ball_radius_mm * normal
        late = self.trip_mm(normal) + self.overshoot_mm * rng.random(len(angle_rad))
        scatter = (rng.random(at.shape) - 0.5) * [self.range_x_mm, self.range_z_mm]
        reported: Array = at - late[:, None] * normal + scatter
        return reported
