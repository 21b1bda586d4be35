"""The virtual touch probe: what the control reports when the ball meets the part."""

import math
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import contact_angle_rad
from trueloop.simulator.ball import ball_contact_mm
from trueloop.simulator.machine_error import REFERENCE_C, MachineError
from trueloop.simulator.stock import Stock


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
        """How far the ball goes on after contact before the probe trips, for approaches against `normal`, (n,)."""
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
        """Ball centres as the control reports them, (n, 2), of touches against the normals at the points.

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
        """Reported ball centres on a calibration sphere (or ring gauge from inside: negative radius), (n, 2)."""
        outward = np.column_stack([np.sin(angle_rad), np.cos(angle_rad)])
        normal = math.copysign(1.0, radius_mm) * outward
        at = np.asarray(centre_mm) + abs(radius_mm) * outward + self.ball_radius_mm * normal
        late = self.trip_mm(normal) + self.overshoot_mm * rng.random(len(angle_rad))
        scatter = (rng.random(at.shape) - 0.5) * [self.range_x_mm, self.range_z_mm]
        reported: Array = at - late[:, None] * normal + scatter
        return reported
