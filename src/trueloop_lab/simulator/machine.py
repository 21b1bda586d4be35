"""The virtual machine tool: commanded paths in, the surface that results out.

The cutting process: deflection of tool and part, random errors, lost motion, and the surface that cuts leave.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.geometry.feature import contact_angle_rad
from trueloop.surface.separation.spline_surface import Size, SplineSurface
from trueloop_lab.simulator.nose import SAME, CentrePath, Nose, Transfer

REACH_MM: Final = 1.0
"""The distance from a nominal point within which the surface is sought, either way: below a wall, above any error."""


def sweep(centre_mm: Array, nose: Nose) -> NoseSweep:
    """Returns the sweep of a nose along positions of its centre (n, 2)."""
    return NoseSweep(np.ascontiguousarray(centre_mm), nose.radius_mm, nose.first_rad, nose.step_rad, nose.pieces)


@dataclass(frozen=True)
class Stock:
    """An endless bar less the swept regions of all cuts so far. x is a radius."""

    sweeps: tuple[NoseSweep, ...] = ()

    def cut_by(self, sweeps: Iterable[NoseSweep]) -> "Stock":
        """Returns the stock after further cuts."""
        return Stock((*self.sweeps, *sweeps))

    def height_mm(self, points_mm: Array, direction: Array, reach_mm: float = REACH_MM) -> Array:
        """Returns where a line through each point (n, 2) along its unit direction (n, 2) leaves the material, (n,).

        Measured from the point, positive outside; +reach where nothing was cut away within reach. It is the true
        surface: no error terms are added up, no curvature is neglected.
        """
        height = np.full(len(points_mm), reach_mm)
        origins, directions = np.ascontiguousarray(points_mm), np.ascontiguousarray(direction)
        for swept in reversed(self.sweeps):  # the last cut is nearly everywhere the lowest: the others soon give up
            height = swept.entries(origins, directions, height, reach_mm)
        return height


EXTREME_OF_625: Final = 3.08
"""Expected largest of 625 standard normal values: what a published ± of 625 residuals means in standard deviations."""

LEAST_MM: Final = 0.0024
MOST_MM: Final = 0.0043
EXTREME_MM: Final = 0.0065
"""Published limits [MPM §8]: of the variability between parts, and of the random part."""

FREQUENCIES: Final = (1.0, 2.5, 4.0)
"""Frequencies of the waves by which parts differ, in radians over a side."""
WAVES: Final = 2 * len(FREQUENCIES)


@dataclass(frozen=True, eq=False)
class SurfaceProcess:
    """`pattern` is what every part gets. Parts differ from it by smooth surfaces, whose standard deviation over parts
    grows from `least_mm` in the middle to `most_mm` at the edges; `noise_mm` is that of one touch.
    """

    pattern: SplineSurface
    least_mm: float
    most_mm: float
    noise_mm: float

    def variation(self, rng: np.random.Generator) -> "Variation":
        """Draws a part's difference from the pattern: normal weights for every wave along u times every one along v."""
        return Variation(self.least_mm, self.most_mm, rng.normal(size=(WAVES, WAVES)))


@dataclass(frozen=True, eq=False)
class Variation:
    """A smooth surface over [0, 1] × [0, 1] in mm: waves whose size grows from the middle to the edges.

    `weights` (6, 6): of each wave along u with each along v. The squares of either direction's waves add up to one
    everywhere: weights that are drawn independently with unit variance make that size the standard deviation.
    """

    least_mm: float
    most_mm: float
    weights: Array

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""
        return self._scaled(u, v, np.sum((_harmonics(u) @ self.weights) * _harmonics(v), axis=1))

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""
        return self._scaled(u[:, None], v[None, :], _harmonics(u) @ self.weights @ _harmonics(v).T)

    def _scaled(self, u: Array, v: Array, field: Array) -> Array:
        edge = np.maximum(np.abs(2 * u - 1), np.abs(2 * v - 1))
        return np.asarray((self.least_mm + (self.most_mm - self.least_mm) * edge) * field)


def published_process(rng: np.random.Generator, pattern_mm: float = 0.008, controls: int = 9) -> SurfaceProcess:
    """Returns a process of the size of [MPM §8]: variability between parts ±2.4 to ±4.3 µm, random part within ±6.5 µm.

    The extremes are read as three standard deviations for the few parts' models, and as the largest of 625 values for
    the random part. The pattern itself is drawn, its control values with the given standard deviation.
    """
    pattern = SplineSurface(Size(controls, controls), rng.normal(0.0, pattern_mm, (controls, controls)))
    return SurfaceProcess(pattern, LEAST_MM / 3, MOST_MM / 3, EXTREME_MM / EXTREME_OF_625)


def _harmonics(at: Array) -> Array:
    """Six smooth functions whose squares add up to one everywhere: a field of them varies alike in all places."""
    waves = [wave(w * at) for w in FREQUENCIES for wave in (np.cos, np.sin)]
    return np.asarray(np.stack(waves, axis=1) / np.sqrt(len(FREQUENCIES)))


STATION_MM: Final = 0.5
"""Forces are reckoned this far apart along the path and run straight between."""

DEEPEST_CUT_MM: Final = 5.0


@dataclass(frozen=True)
class Repeatability:
    """Random errors of the process, standard deviations in mm.

    `along_mm` varies along the cut like a Gaussian process of correlation length `correlation_mm` (correlation
    exp(−d²/2ℓ²)), normal to the path; `cut_to_cut_mm` moves a whole cut, on x and z each. No chatter: nothing here
    is of a wavelength that the nose would fill.
    """

    along_mm: float = 0.0
    correlation_mm: float = 2.0
    cut_to_cut_mm: float = 0.0

    def displacement_mm(self, path: CentrePath, cut_mm: Array, rng: np.random.Generator) -> Array:
        """Draws one cut's displacement of the nose centre, (n, 2); `cut_mm` (2,) is that of the whole cut."""
        moved: Array = np.broadcast_to(cut_mm, path.centre_mm.shape)
        if self.along_mm > 0.0:
            moved = (
                moved
                + self.along_mm * _gaussian_process(path.along_mm, self.correlation_mm, rng)[:, None] * path.normal
            )
        return moved

    def draw_cut_mm(self, rng: np.random.Generator) -> Array:
        """Draws the displacement of one whole cut, (2,)."""
        return self.cut_to_cut_mm * rng.standard_normal(2)


@dataclass(frozen=True)
class Deflection:
    """The deflection of tool and part under the cutting force.

    The force normal to the contour is `specific_force_n_per_mm2` × depth of cut × feed (the radial part of the specific
    cutting force). It moves the tool by `tool_mm_per_n` along the normal, and the part by its compliance along x:
    `chuck_mm_per_n` + `part_mm_per_n_mm3` · (z − z_chuck)³ (a cantilever: 1/(3EI)). Valid for small deflections of a
    part of one diameter; the depth of cut is that which remains when all has given way.
    """

    specific_force_n_per_mm2: float = 0.0
    tool_mm_per_n: float = 0.0
    chuck_mm_per_n: float = 0.0
    part_mm_per_n_mm3: float = 0.0
    chuck_z_mm: float = 0.0
    feed_mm_per_rev: float = 0.127

    @property
    def rigid(self) -> bool:
        """Returns whether nothing gives way."""
        return self.specific_force_n_per_mm2 == 0.0

    def displacement_mm(self, path: CentrePath, contact_mm: Array, stock: Stock) -> Array:
        """Returns the displacement of the nose relative to the part, (n, 2), cutting the stock above the contact line.

        `contact_mm` (n, 2) is where the nose would cut if nothing gave way.
        """
        count = max(2, math.ceil(path.along_mm[-1] / STATION_MM))
        at = np.linspace(0.0, path.along_mm[-1], count)
        nearest = np.unique(np.minimum(np.searchsorted(path.along_mm, at), len(path.along_mm) - 1))
        contact, normal = contact_mm[nearest], path.normal[nearest]
        depth = np.clip(stock.height_mm(contact, normal, DEEPEST_CUT_MM), 0.0, None)
        depth = np.where(depth >= DEEPEST_CUT_MM, 0.0, depth)
        feed = np.where(np.isnan(path.feed_mm_per_rev), self.feed_mm_per_rev, path.feed_mm_per_rev)[nearest]
        stiffness = self.specific_force_n_per_mm2 * feed
        on_x = self.chuck_mm_per_n + self.part_mm_per_n_mm3 * np.clip(contact[:, 1] - self.chuck_z_mm, 0.0, None) ** 3
        yielding = self.tool_mm_per_n + on_x * normal[:, 0] ** 2
        force = stiffness * depth / (1.0 + stiffness * yielding)
        part = np.column_stack([on_x * normal[:, 0], np.zeros(len(nearest))])
        away = force[:, None] * (self.tool_mm_per_n * normal + part)
        return np.column_stack([np.interp(path.along_mm, path.along_mm[nearest], away[:, k]) for k in range(2)])


@dataclass(frozen=True)
class Backlash:
    """Play of each axis in mm: the slide follows its drive within ± half of it, and stays where it was pushed to."""

    x_mm: float = 0.0
    z_mm: float = 0.0

    def follow(self, commanded_mm: Array) -> Array:
        """Returns the slide's positions, (n, 2), when it is driven through these positions from the first on."""
        actual = np.array(commanded_mm, dtype=np.float64)
        for axis, play in enumerate((self.x_mm, self.z_mm)):
            if play > 0.0:
                actual[:, axis] = _follow(commanded_mm[:, axis], play / 2)
        return actual


def _follow(driven: Array, half: float) -> Array:
    at, found = float(driven[0]), np.empty_like(driven)
    for k, position in enumerate(driven.tolist()):
        at = min(max(at, position - half), position + half)
        found[k] = at
    return found


def _gaussian_process(along: Array, correlation: float, rng: np.random.Generator) -> Array:
    """Unit variance, correlation exp(−d²/2ℓ²): white noise on a grid of ℓ/4, weighted by a Gaussian of width ℓ/√2."""
    step = correlation / 4
    margin = 16
    count = math.ceil(along[-1] / step) + 2 * margin + 2
    offsets = np.arange(-margin, margin + 1) * step
    weights = np.exp(-((offsets / correlation) ** 2))
    weights /= np.linalg.norm(weights)
    smooth = np.convolve(rng.standard_normal(count), weights, mode="same")
    from scipy.interpolate import CubicSpline  # only a process that does not repeat needs it

    values: Array = CubicSpline(step * (np.arange(count) - margin), smooth)(along)
    return values


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
