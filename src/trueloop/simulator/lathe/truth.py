"""Where the tool of the virtual lathe really is: slides with lost motion, rigid motions in the plane, a warm headstock.

Nothing of `trueloop.machine` is used, and its functions cannot be met exactly: positioning has a sine, straightness is
of the fifth degree, growth bends with temperature, and the screw is not warm alike along its length. Lengths in mm,
angles in rad, X a radius, temperatures in kelvins above 20 °C.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.simulator.lathe.warm_up import WarmUp
from trueloop.simulator.process import Backlash

X_TRAVEL_MM: Final = (-10.0, 310.0)
Z_TRAVEL_MM: Final = (-300.0, 110.0)
SQUARE_RAD, PARALLEL_RAD = 35e-6, -22e-6
SCREW_PER_K: Final = 11.5e-6
FIXED_Z_MM: Final = 110.0
"""Where the screw is held: it grows from there."""


@dataclass(frozen=True)
class WarmLathe:
    """The machine: `share` of its errors (0: none), and the lost motion of its drives, mm."""

    share: float = 1.0
    lost: Backlash = field(default_factory=lambda: Backlash(0.0012, 0.0080))

    def without_errors(self) -> "WarmLathe":
        """The same machine, with its errors and its lost motion switched off."""
        return WarmLathe(0.0, Backlash())

    def tool_mm(self, drives_mm: Array, tool_mm: Array, warm: WarmUp) -> Array:
        """Positions of the tool point in work coordinates, (n, 2), while the drives stand at (n, 2), in order.

        `tool_mm` (2,) leads from the cross slide's frame to the tool point; `warm` holds the moment of each position.
        """
        slides = self.lost.follow(drives_mm)
        return slides + tool_mm + self.error_mm(slides, tool_mm, warm)

    def error_mm(self, slides_mm: Array, tool_mm: Array, warm: WarmUp) -> Array:
        """Actual less intended position of the tool point as seen from the work, (n, 2), lost motion apart."""
        (x, z), share = slides_mm.T, self.share
        point = _turned(np.broadcast_to(tool_mm, slides_mm.shape), share * _cross_slide_yaw(x))
        point = point + share * _cross_slide(x) + x[:, None] * _direction(share * SQUARE_RAD)
        point = _turned(point, share * _carriage_yaw(z)) + share * _carriage(z, warm.screw + warm.hall)
        point = point + z[:, None] * _direction(share * PARALLEL_RAD)[::-1] * [-1.0, 1.0]
        seen = _turned(point - share * _headstock(warm), -share * _headstock_tilt(warm))
        return np.asarray(seen - slides_mm - tool_mm)

    def turned_rad(self, slides_mm: Array, warm: WarmUp) -> Array:
        """By how much the tool is turned about Y as seen from the work, (n,)."""
        (x, z), tilt = slides_mm.T, _headstock_tilt(warm)
        return np.asarray(self.share * (_cross_slide_yaw(x) + _carriage_yaw(z) - tilt))


def _turned(point_mm: Array, about_y_rad: Array) -> Array:
    x, z = point_mm.T
    cos, sin = np.cos(about_y_rad), np.sin(about_y_rad)
    return np.column_stack([cos * x + sin * z, cos * z - sin * x])


def _direction(about_y_rad: float) -> Array:
    return np.array([np.cos(about_y_rad), -np.sin(about_y_rad)])


def _cross_slide(x: Array) -> Array:
    """Positioning with the screw's own period in it, and straightness; zero at the spindle's axis."""
    u = x / 300.0
    return 1e-3 * np.column_stack([14 * u - 6 * u**2 + 0.5 * np.sin(2 * np.pi * x / 90), 5 * u**2 - 4 * u**5])


def _cross_slide_yaw(x: Array) -> Array:
    return 1e-6 * (18 * x / 300 - 9 * (x / 300) ** 2)


def _carriage(z: Array, screw_k: Array) -> Array:
    """Straightness, and positioning: the screw's pitch, its sine, and its growth, warmer in its middle."""
    u, from_end = z / 300.0, z - FIXED_Z_MM
    warmer = from_end + 0.15 * 400 / np.pi * np.sin(np.pi * from_end / 400)
    along = -22 * u + 13 * u**2 + 0.8 * np.sin(2 * np.pi * z / 140)
    return np.column_stack([1e-3 * (9 * u - 16 * u**3 + 7 * u**5), 1e-3 * along + SCREW_PER_K * screw_k * warmer])


def _carriage_yaw(z: Array) -> Array:
    return 1e-6 * (-25 * z / 300 + 20 * (z / 300) ** 3)


def _headstock(warm: WarmUp) -> Array:
    """By how much the spindle has moved and grown, (n, 2): it grows a little faster the warmer it is."""
    bearing, casting = warm.bearing + warm.hall, warm.casting + warm.hall
    lifted = 0.7 * casting + 0.15 * bearing
    grown = 0.9 * bearing + 0.4 * casting + 0.006 * bearing**2
    return 1e-3 * np.column_stack([lifted, grown])


def _headstock_tilt(warm: WarmUp) -> Array:
    return 0.8e-6 * (warm.casting + warm.hall)
