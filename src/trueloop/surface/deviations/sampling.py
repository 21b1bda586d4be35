"""How densely to touch a surface, and with which ball."""

from dataclasses import dataclass

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface

PLACES = 60


@dataclass(frozen=True)
class SamplingAdvice:
    """A grid that takes from the surface what the ball can feel.

    `step_mm` is the ball's radius; `shortest_wave_mm`, twice the step, the shortest wave that the grid tells from
    others (Nyquist). `rows` and `columns` cover the longest lines along u and v. `hollow_radius_mm` is the surface's
    smallest concave radius (inf: none); the ball has to be smaller: `reaches_everywhere`.
    """

    step_mm: float
    shortest_wave_mm: float
    rows: int
    columns: int
    hollow_radius_mm: float
    reaches_everywhere: bool


def sampling_advice(surface: Surface, ball_radius_mm: float, step_mm: float | None = None) -> SamplingAdvice:
    """Advice for a ball: the step of the grid equals the ball's radius [MPM §3], or is the one given.

    A ball rolls over waves shorter than about its radius: a finer grid would measure the ball, a coarser one would
    mistake short waves for long ones. Raises SRF-BALL for a radius that is not positive.
    """
    if not ball_radius_mm > 0:
        raise TrueloopError(
            Code.SRF_BALL,
            f"a ball of radius {ball_radius_mm} mm has no sampling step",
            hint="give the calibrated radius of the stylus tip in mm",
            values={"ball_radius_mm": ball_radius_mm},
        )
    step = step_mm or ball_radius_mm
    (u0, u1), (v0, v1) = surface.domain
    us, vs = np.linspace(u0, u1, PLACES), np.linspace(v0, v1, PLACES)
    grid = surface.grid_mm(us, vs)
    along = float(np.max(np.sum(np.linalg.norm(np.diff(grid, axis=0), axis=2), axis=0)))
    across = float(np.max(np.sum(np.linalg.norm(np.diff(grid, axis=1), axis=2), axis=1)))
    u, v = (us[:-1] + us[1:]) / 2, (vs[:-1] + vs[1:]) / 2  # not at the edges: a pole has no curvature
    hollow = float(np.min(surface.curvatures_per_mm(np.repeat(u, len(v)), np.tile(v, len(u)))[:, 0]))
    radius = -1.0 / hollow if hollow < 0 else float("inf")
    rows, columns = int(np.ceil(along / step)) + 1, int(np.ceil(across / step)) + 1
    return SamplingAdvice(step, 2 * step, rows, columns, radius, ball_radius_mm < radius)
