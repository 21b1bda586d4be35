"""A free-form surface milled with an end mill: what really stays, cusps included.

The surface is not that of the design displaced by errors: it is the envelope of the cutter's end along the actual
passes, of a ball, or of the ring of a bull-nose or flat end with what it encloses; its axis may turn as it cuts. Shank
and flanks cut nothing here.
Between two passes a ball of radius R leaves a cusp, which on a plane is R − √(R² − s²/4) high for a step-over s.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import repeat
from typing import Final, TypeAlias

import numpy as np

from trueloop._core import CutterSweep
from trueloop.arrays import Array
from trueloop.geometry.surface import Surface
from trueloop.surface.compensation.cutter import Cutter, contacts
from trueloop_lab.simulator.machine import Stock, SurfaceProcess, Variation

Displacement: TypeAlias = Callable[[Array], Array]
"""Actual less commanded position of the cutter's centre: (n, 3) → (n, 3), mm."""

REACH_MM = 2.0
TURN_MM = 1e-5
"""The distance by which the edge of a turning cutter may leave its way between two places: 0.01 µm."""


@dataclass(frozen=True)
class EndMill:
    """A cutter as the program believes it to be, its axis a unit vector out of the material, and by how much it is
    larger (negative: worn): a ball or corner by its radius, a flat end by that of its ring.
    """

    cutter: Cutter
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    radius_error_mm: float = 0.0

    def centres_mm(self, contact_mm: Array, normal: Array) -> Array:
        """Returns programmed middles of the ring for contacts and normals out of the material, (…, 3) → (…, 3)."""
        across = normal - np.sum(normal * self.axis, axis=-1, keepdims=True) * np.asarray(self.axis)
        length = np.linalg.norm(across, axis=-1, keepdims=True)
        lean = np.where(length > 1e-9, across / np.maximum(length, 1e-300), 0.0)
        return np.asarray(contact_mm + self.cutter.corner_mm * normal + self.cutter.ring_mm * lean)

    def swept(self, centres_mm: Array, axes: Array | None = None) -> CutterSweep:
        """Returns the sweep of the actual cutter with the middle of its ring at (n, 3); axes (n, 3) where it turns.

        Between two places the axis takes the shortest way; `turn_rad` is the most it may turn there.
        """
        ring, corner = self.cutter.ring_mm, self.cutter.corner_mm
        if corner > 0.0:
            corner += self.radius_error_mm
        else:
            ring += self.radius_error_mm
        along = np.array([self.axis]) if axes is None else np.ascontiguousarray(axes)
        return CutterSweep(np.ascontiguousarray(centres_mm), ring, corner, along)


@dataclass(frozen=True)
class MilledStock:
    """Endless material less the passes cut so far."""

    passes: tuple[CutterSweep, ...] = ()

    def cut_by(
        self,
        cutter: EndMill,
        passes_mm: Iterable[Array],
        displacement: Displacement | None = None,
        axes: Iterable[Array | None] = repeat(None),
    ) -> "MilledStock":
        """Returns the stock after passes of programmed centres, (n, 3) each, from which the cutter is displaced.

        axes: its axis at every centre, for every pass; the cutter's own where they are left out.
        """
        actual = (p if displacement is None else p + displacement(p) for p in passes_mm)
        return MilledStock((*self.passes, *map(cutter.swept, actual, axes)))

    def height_mm(self, points_mm: Array, normal: Array, reach_mm: float = REACH_MM) -> Array:
        """Returns where a line through each nominal point (n, 3) along its normal (n, 3) leaves the material, (n,).

        Positive = material left on; +reach where nothing was cut within reach.
        """
        height = np.full(len(points_mm), reach_mm)
        origins, directions = np.ascontiguousarray(points_mm), np.ascontiguousarray(normal)
        for swept in self.passes:
            height = swept.entries(origins, directions, height, reach_mm)
        return height


def turn_rad(cutter: Cutter) -> float:
    """Returns the angle that a cutter's axis may turn between two places: a chord of its radius R is R δ²/8 off."""
    return float(np.sqrt(8 * TURN_MM / cutter.radius_mm))


@dataclass(frozen=True)
class VirtualCmm:
    """A measuring machine with its own errors.

    `frame_mm` is the standard deviation of its part origin on each axis, `tilt_rad` that of the turned
    part's axis, or of the milled part's turn about each axis.
    Its length error is at most `mpe_mm` + L · `mpe_per_mm` at distance L from the origin (maximum permissible error,
    ISO 10360-2), uniform.
    """

    frame_mm: float = 0.0
    tilt_rad: float = 0.0
    mpe_mm: float = 0.0
    mpe_per_mm: float = 0.0

    def measure(self, stock: Stock | MilledStock, points_mm: Array, normal: Array, rng: np.random.Generator) -> Array:
        """Returns measured part errors along the nominal normals, (n,), positive = material left on.

        Points and normals are (n, 2) in the plane of a turned part, (n, 3) on a milled one.
        """
        moved = self.frame_mm * rng.standard_normal(points_mm.shape[1]) + np.zeros_like(points_mm)
        moved = moved + self.tilt_rad * _turned(points_mm, rng)
        most = self.mpe_mm + self.mpe_per_mm * np.linalg.norm(points_mm, axis=1)
        found: Array = stock.height_mm(points_mm, normal) + np.einsum("ij,ij->i", moved, normal)
        found += most * (2.0 * rng.random(len(points_mm)) - 1.0)
        return found

    @property
    def standard_u_mm(self) -> float:
        """Returns the standard uncertainty of one point near the origin: frame and length error together."""
        return math.hypot(self.frame_mm, self.mpe_mm / math.sqrt(3.0))


def _turned(points_mm: Array, rng: np.random.Generator) -> Array:
    """Displacement of points by a random small turn about the origin, in mm per radian of standard deviation."""
    if points_mm.shape[1] == 2:
        return rng.standard_normal() * np.column_stack([points_mm[:, 1], -points_mm[:, 0]])
    return np.cross(rng.standard_normal(3), points_mm)


STEP_MM: Final = 0.5
"""The cutter is displaced anew this far along a pass: errors of the process are smooth over millimetres."""


@dataclass(frozen=True, eq=False)
class Passes:
    """Programmed centres of the cutter's end and its axes there, (n, 3) a pass, and where it touches the surface from
    all of them: parameters in [0, 1] and normals, a row a centre, pass after pass.
    """

    centres_mm: tuple[Array, ...]
    axes: tuple[Array, ...]
    u: Array
    v: Array
    normal: Array


@dataclass(frozen=True, eq=False)
class VirtualMill:
    """The process stands the cutter off along the surface's normal: its pattern on every part alike, its variation on
    each part its own. `radius_error_mm` is by how much the cutter is larger than programmed (negative: worn). The
    measuring machine touches a grid of `grid` places, each with the process's noise besides its own errors.
    """

    process: SurfaceProcess
    radius_error_mm: float = 0.0
    cmm: VirtualCmm = field(default_factory=VirtualCmm)
    grid: tuple[int, int] = (25, 25)

    def cut(self, passes: Passes, cutter: EndMill, variation: Variation | None) -> MilledStock:
        """Returns one part, cut along the programmed passes; without variation with the errors common to all parts."""
        off = self.process.pattern.value_mm(passes.u, passes.v)
        if variation is not None:
            off = off + variation.value_mm(passes.u, passes.v)
        ends = np.cumsum([len(centres) for centres in passes.centres_mm])[:-1]
        actual = np.split(np.concatenate(passes.centres_mm) + off[:, None] * passes.normal, ends)
        worn = replace(cutter, radius_error_mm=self.radius_error_mm)
        return MilledStock().cut_by(worn, actual, axes=passes.axes)

    def measure(self, stock: MilledStock, points_mm: Array, normal: Array, rng: np.random.Generator) -> Array:
        """Deviations along the nominal normals, (n,), as the measuring machine finds them."""
        noise = self.process.noise_mm * rng.standard_normal(len(points_mm))
        return self.cmm.measure(stock, points_mm, normal, rng) + noise


def passes_over(
    surface: Surface, centres_mm: Sequence[Array], cutter: EndMill, axes: Sequence[Array] | None = None
) -> Passes:
    """Passes of programmed centres, with a centre at least every half millimetre; axes at each, or the cutter's own."""
    given = axes or [np.tile(cutter.axis, (len(centres), 1)) for centres in centres_mm]
    close = [_close(np.hstack(both)) for both in zip(centres_mm, given, strict=True)]
    centres, turned = tuple(c[:, :3] for c in close), tuple(_unit(c[:, 3:]) for c in close)
    tips = np.concatenate(centres) - cutter.cutter.corner_mm * np.concatenate(turned)
    feet = contacts(surface, cutter.cutter, tips, np.concatenate(turned)).feet
    (u0, u1), (v0, v1) = surface.domain
    return Passes(centres, turned, (feet.u - u0) / (u1 - u0), (feet.v - v0) / (v1 - v0), feet.normal)


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _close(rows: Array) -> Array:
    """Rows (n, k) that begin with a place, and rows put evenly between them."""
    lengths = np.linalg.norm(np.diff(rows[:, :3], axis=0), axis=1)
    steps = np.maximum(np.ceil(lengths / STEP_MM).astype(int), 1)
    of = np.repeat(np.arange(len(steps)), steps)
    share = (np.arange(len(of)) - np.repeat(np.cumsum(steps) - steps, steps)) / steps[of]
    return np.vstack([rows[of] + share[:, None] * (rows[of + 1] - rows[of]), rows[-1]])
