"""The virtual machine tool: commanded paths in, the surface that results out."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.geometry.feature import contact_angle_rad
from trueloop_lab.simulator.nose import SAME, CentrePath, Nose, Transfer
from trueloop_lab.simulator.process import REACH_MM, Backlash, Deflection, Repeatability, Stock, sweep

PER_MM: Final = 0.01
REFERENCE_C: Final = 20.0


@dataclass(frozen=True)
class ErrorTerm:
    """One term; `axis` 0 is x, 1 is z."""

    axis: int
    coefficient_mm: float
    x_power: int = 0
    z_power: int = 0
    temperature_power: int = 0


@dataclass(frozen=True)
class MachineError:
    """All terms. Without any the machine goes where it is commanded."""

    terms: tuple[ErrorTerm, ...] = ()

    def error_mm(self, position_mm: Array, temperature_c: float) -> Array:
        """Returns E at positions (n, 2), (n, 2)."""
        error = np.zeros_like(position_mm)
        x, z, warmer = position_mm[:, 0] * PER_MM, position_mm[:, 1] * PER_MM, temperature_c - REFERENCE_C
        for term in self.terms:
            shape = x**term.x_power * z**term.z_power * warmer**term.temperature_power
            error[:, term.axis] += term.coefficient_mm * shape
        return error


@dataclass(frozen=True)
class VirtualMachine:
    """One machine with one tool. Everything that makes its parts wrong is known.

    `tool_offset_mm` (x as a radius, z) is by how much the tool was set wrongly; `transfer` what the finish cut does
    otherwise than the cuts before it. `body_mm`: centres (x, z) from the nose centre of further circles of its radius
    that cut along with it, unworn: the rest of an insert that is more than a nose.
    """

    nose: Nose
    tool_offset_mm: tuple[float, float] = (0.0, 0.0)
    repeatability: Repeatability = field(default_factory=Repeatability)
    deflection: Deflection = field(default_factory=Deflection)
    backlash: Backlash = field(default_factory=Backlash)
    error: MachineError = field(default_factory=MachineError)
    transfer: Transfer = SAME
    body_mm: tuple[tuple[float, float], ...] = ()

    def cut(
        self,
        stock: Stock,
        paths: Sequence[CentrePath],
        rng: np.random.Generator,
        temperature_c: float = REFERENCE_C,
        transfer: Transfer = SAME,
    ) -> Stock:
        """Returns the stock after the nose was commanded along these paths: one cut of the process.

        The actual path is the commanded one with play, machine error, wrong setting, what gives way under the force,
        what this cut does otherwise (`transfer`), and what does not repeat; the surface is the envelope of the nose
        along it.
        """
        cut_mm = self.repeatability.draw_cut_mm(rng)
        actual = (
            self._actual(path, stock, cut_mm, rng, temperature_c) + transfer.displacement_mm(path) for path in paths
        )
        return stock.cut_by([one for at in actual for one in self._swept(at)])

    def _swept(self, at: Array) -> list[NoseSweep]:
        """Returns the swept area of the insert for these nose centres; the body first, the nose finishes."""
        unworn = Nose(self.nose.radius_mm)
        return [*(sweep(at + np.array(apart), unworn) for apart in self.body_mm), sweep(at, self.nose)]

    def _actual(
        self, path: CentrePath, stock: Stock, cut_mm: Array, rng: np.random.Generator, temperature_c: float
    ) -> Array:
        at = self.backlash.follow(path.centre_mm)
        at += self.error.error_mm(at, temperature_c) + np.asarray(self.tool_offset_mm)
        if not self.deflection.rigid and stock.sweeps:
            below = self.nose.radius_mm + self.nose.wear_at_mm(contact_angle_rad(path.normal))
            at += self.deflection.displacement_mm(path, at - below[:, None] * path.normal, stock)
        at += self.repeatability.displacement_mm(path, cut_mm, rng)
        return at


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
