"""A milling machine whose parts are wrong in known ways, with an end mill whose axis stands still or turns."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.surface import Surface
from trueloop.simulator.mill import EndMill, MilledStock, VirtualCmm
from trueloop.simulator.process import SurfaceProcess, Variation
from trueloop.surface.compensation.cutter import contacts

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
