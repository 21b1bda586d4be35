"""A plain zig-zag path for finishing a surface with a ball-end cutter, for trials.

Passes run along u, side by side along v, the distance between them chosen so that the ridges they leave stay below a
scallop height. Points along a pass are close enough for the chord tolerance.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.surface import Surface
from trueloop.nc.edit.edit import coordinate_text
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import CoordinateState

PLACES: Final = 200
SPINDLE_RPM: Final = 7500
"""An example's speed: feed and depth of the zig-zag do not follow from it."""
MOST_POINTS: Final = 2_000_000


@dataclass(frozen=True)
class ZigzagOptions:
    """Ball radius, largest height of the ridges, chord tolerance and retract height in mm; feed in mm/min."""

    radius_mm: float
    scallop_mm: float = 0.002
    chord_mm: float = 0.001
    feed_mm_per_min: float = 300.0
    clearance_mm: float = 5.0


def zigzag(surface: Surface, options: ZigzagOptions) -> list[Array]:
    """Passes as tips of the cutter (n, 3), tool axis along z, in cutting order.

    Raises SRF-PATH for a cutter too large for a hollow, a scallop height that is none, or millions of points.
    """
    _check(surface, options)
    (u0, u1), _ = surface.domain
    points, (passed, at_v) = _points_of_pass(surface, options), _passes_passed(surface, options)
    count = int(np.ceil(passed[-1])) + 1
    _check_size(count, points)
    passes = []
    for k, v in enumerate(np.interp(np.linspace(0.0, passed[-1], count), passed, at_v)):
        u = np.linspace(u0, u1, points)
        at = surface.partials(u, np.full(len(u), v))
        tips = at.point_mm + options.radius_mm * (surface.normal_of(at) - np.array([0.0, 0.0, 1.0]))
        passes.append(tips[::-1] if k % 2 else tips)
    return passes


def program_text(passes: list[Array], dialect: Dialect, options: ZigzagOptions) -> str:
    """The passes as a program in mm: G17 G21 G40 G90 G94, one rapid in, feed throughout, one rapid out."""
    state = CoordinateState(inch=False, diameter=False)
    top = max(float(np.max(tips[:, 2])) for tips in passes) + options.clearance_mm

    def place(tip: Array, axes: str = "XYZ") -> str:
        return " ".join(coordinate_text(dialect, name, float(tip["XYZ".index(name)]), state) for name in axes)

    first = passes[0][0]
    up = coordinate_text(dialect, "Z", top, state)
    lines = ["G17 G21 G40 G90 G94", f"S{SPINDLE_RPM} M3", f"G0 {up}", f"G0 {place(first, 'XY')}"]
    lines.append(f"G1 {place(first, 'Z')} F{options.feed_mm_per_min:g}")
    lines += [place(tip) for tips in passes for tip in tips][1:]
    return "\n".join([*lines, f"G0 {up}", "M5", "M2", ""])


def scallop_step_mm(radius_mm: float, scallop_mm: float, curvature_per_mm: Array) -> Array:
    """Distance between passes that leaves ridges of that height: √(8 R h/(1 + R κ)), κ across the passes.

    Convex is positive. To second order in the step; good while the step is small beside both radii.
    """
    return np.asarray(np.sqrt(8 * radius_mm * scallop_mm / (1 + radius_mm * curvature_per_mm)))


def _passes_passed(surface: Surface, options: ZigzagOptions) -> tuple[Array, Array]:
    """How many passes are needed up to parameters v, and these: each as far on as its narrowest place allows."""
    (u0, u1), (v0, v1) = surface.domain
    u, v = np.linspace(u0, u1, PLACES + 2)[1:-1], np.linspace(v0, v1, PLACES)
    at = surface.partials(np.tile(u, PLACES), np.repeat(v, PLACES))
    normal = surface.normal_of(at)
    along = at.du / np.linalg.norm(at.du, axis=1, keepdims=True)
    across = at.dv - np.sum(at.dv * along, axis=1, keepdims=True) * along
    rate = np.linalg.norm(across, axis=1)
    kappa = -np.sum(normal * at.dvv, axis=1) / np.sum(at.dv**2, axis=1)
    step = scallop_step_mm(options.radius_mm, options.scallop_mm, np.maximum(kappa, -0.9 / options.radius_mm))
    density = np.max((rate / step).reshape(PLACES, PLACES), axis=1)
    return np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(v))]), v


def _points_of_pass(surface: Surface, options: ZigzagOptions) -> int:
    """Points of a pass: the sagitta of a step on the path of the ball's centre stays below the chord tolerance."""
    (u0, u1), (v0, v1) = surface.domain
    u, v = np.linspace(u0, u1, PLACES + 2)[1:-1], np.linspace(v0, v1, PLACES + 2)[1:-1]
    u, v = np.tile(u, PLACES), np.repeat(v, PLACES)
    at = surface.partials(u, v)
    bend = surface.curvatures_per_mm(u, v)
    sharpest = np.max(np.abs(bend), axis=1) * np.abs(1 + options.radius_mm * bend).max(axis=1)
    length = np.linalg.norm(at.du, axis=1)
    step = np.sqrt(8 * options.chord_mm / np.maximum(sharpest, 1e-6))
    return max(2, int(np.ceil(float(np.max(length / step)) * (u1 - u0))) + 1)


def _check(surface: Surface, options: ZigzagOptions) -> None:
    (u0, u1), (v0, v1) = surface.domain
    u, v = np.linspace(u0, u1, 62)[1:-1], np.linspace(v0, v1, 62)[1:-1]
    hollow = float(np.min(surface.curvatures_per_mm(np.tile(u, 60), np.repeat(v, 60))[:, 0]))
    if options.scallop_mm <= 0 or options.chord_mm <= 0 or options.radius_mm <= 0:
        wrong = f"radius {options.radius_mm} mm, scallop {options.scallop_mm} mm, chord {options.chord_mm} mm"
        raise Code.SRF_PATH.refusal(wrong, hint="all three have to be above zero")
    if hollow * options.radius_mm <= -1:
        raise Code.SRF_PATH.refusal(
            f"a ball of radius {options.radius_mm:g} mm does not fit a hollow of radius {-1 / hollow:.3f} mm",
            hint="take a smaller cutter",
        )


def _check_size(passes: int, points: int) -> None:
    if passes * points > MOST_POINTS:
        raise Code.SRF_PATH.refusal(
            f"{passes:.3g} passes of {points:.3g} points would be needed; {MOST_POINTS} are the most",
            hint="allow a higher scallop or a larger chord",
        )
