"""The tool nose of the simulator: round, or worn as a radius error over contact angle."""

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError

MOST_STEP_RAD: Final = math.radians(1.0)
"""No piece of the wear is wider."""


@dataclass(frozen=True)
class Nose:
    """A nose of `radius_mm`, at contact angle φ larger by w(φ) (negative: worn, material is left on).

    w runs through `wear_mm` at `wear_angle_rad` (both (m,), ascending angles) as a cubic spline that is level at its
    ends, and stays constant beyond them. It is the support function of the nose less its radius: where the surface's
    normal points along φ, the surface comes to lie R + w(φ) from the nose centre. The body must be convex,
    R + w + w″ > 0, or parts of the edge would never touch the work.
    """

    radius_mm: float
    wear_angle_rad: tuple[float, ...] = ()
    wear_mm: tuple[float, ...] = ()
    pieces: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", _pieces(self.wear_angle_rad, self.wear_mm))
        _check(self)

    @property
    def step_rad(self) -> float:
        """Returns the width of the pieces, all alike over the range of the wear table; `MOST_STEP_RAD` without one."""
        if not len(self.pieces):
            return MOST_STEP_RAD
        return (self.wear_angle_rad[-1] - self.wear_angle_rad[0]) / len(self.pieces)

    @property
    def first_rad(self) -> float:
        """Returns the contact angle at which the wear table begins."""
        return self.wear_angle_rad[0] if self.wear_angle_rad else 0.0

    def wear_at_mm(self, contact_angle_rad: Array) -> Array:
        """Returns W at contact angles of any shape."""
        if not len(self.pieces):
            return np.zeros_like(contact_angle_rad)
        at = np.clip((contact_angle_rad - self.first_rad) / self.step_rad, 0.0, len(self.pieces) - 1e-12)
        piece = self.pieces[at.astype(np.intp)]
        u = (at - np.floor(at)) * self.step_rad
        value: Array = piece[..., 0] + u * (piece[..., 1] + u * (piece[..., 2] + u * piece[..., 3]))
        return value


def _pieces(angle_rad: tuple[float, ...], wear_mm: tuple[float, ...]) -> Array:
    """Cubics of one width with the spline's values and slopes at their ends: neighbours agree in value and slope."""
    ascending = len(angle_rad) == len(wear_mm) >= 2 and np.all(np.diff(angle_rad) > 0.0)
    if not (ascending and np.all(np.isfinite([*angle_rad, *wear_mm]))):
        if not angle_rad and not wear_mm:
            return np.zeros((0, 4))
        raise TrueloopError(
            Code.SIM_NOSE,
            f"a worn nose given by {len(angle_rad)} angles and {len(wear_mm)} radius errors",
            hint="give at least two contact angles in ascending order and a radius error for each, all finite",
        )
    from scipy.interpolate import CubicSpline  # only a worn nose needs it

    spline = CubicSpline(angle_rad, wear_mm, bc_type="clamped")
    count = max(1, math.ceil((angle_rad[-1] - angle_rad[0]) / MOST_STEP_RAD - 1e-9))
    ends = np.linspace(angle_rad[0], angle_rad[-1], count + 1)
    value, slope, h = spline(ends), spline(ends, 1), (angle_rad[-1] - angle_rad[0]) / count
    secant = np.diff(value) / h
    second = (3 * secant - 2 * slope[:-1] - slope[1:]) / h
    third = (slope[:-1] + slope[1:] - 2 * secant) / h**2
    return np.ascontiguousarray(np.column_stack([value[:-1], slope[:-1], second, third]))


def _check(nose: Nose) -> None:
    """A radius, angles of one turn, and what the sweep asks of the body: that it is convex."""
    if not (math.isfinite(nose.radius_mm) and nose.radius_mm > 0.0):
        raise TrueloopError(
            Code.SIM_NOSE,
            f"a nose radius of {nose.radius_mm} mm with {len(nose.wear_mm)} radius errors",
            hint="the simulated nose has a finite radius above 0 mm",
        )
    for angle in nose.wear_angle_rad:
        if not abs(angle) <= math.pi:
            raise TrueloopError(
                Code.SIM_NOSE,
                f"a radius error at a contact angle of {math.degrees(angle):.1f}°",
                hint="contact angles are degrees from −180 to 180, from +z towards +x",
            )
    try:
        NoseSweep(np.zeros((1, 2)), nose.radius_mm, nose.first_rad, nose.step_rad, nose.pieces)
    except ValueError as hollow:
        raise TrueloopError(
            Code.SIM_NOSE,
            str(hollow),
            hint="a nose touches the work only where it is convex: make the radius errors smoother over angle",
        ) from hollow
