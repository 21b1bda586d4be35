"""The time of a program, from its tool path: cuts at the programmed feed, rapid moves at a stated rate, dwells.

Accelerations, overrides, tool changes are left out, so that a machine takes longer.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.program.along import lengths_mm
from trueloop.nc.program.tool_path import INVERSE_TIME, PER_REVOLUTION, Motion, ToolPath
from trueloop.units import MM_PER_M

_SURFACE_SPEED: Final = 96
_PIECES: Final = 64
_MM_PER_FOOT: Final = 304.8


@dataclass(frozen=True)
class MachiningTime:
    """Seconds: of each move (n,), and of the dwells together. `rapid` (n,) tells which moves are not at feed."""

    move_s: Array
    rapid: Flags
    dwell_s: float

    @property
    def cutting_s(self) -> float:
        """Returns the time of all moves at feed, s."""
        return float(self.move_s[~self.rapid].sum())

    @property
    def rapid_s(self) -> float:
        """Returns the time of all moves not at feed, s."""
        return float(self.move_s[self.rapid].sum())

    @property
    def total_s(self) -> float:
        """Moves and dwells."""
        return self.cutting_s + self.rapid_s + self.dwell_s


def machining_time(
    path: ToolPath, rapid_mm_min: float, max_rpm: float | None = None, *, lead_along_thread: bool = False
) -> MachiningTime:
    """Computes the time of each move of a path.

    A cut of length s takes s / F at a feed a minute, 1 / F at an inverse time, and at a feed a revolution the integral
    of ds / (F n), where n is the spindle's speed: S, or under constant surface speed v / (2 pi x) at the radius x, in
    metres (feet) a minute, as far as max_rpm and the program's own limit let it. Rapid moves go straight at
    rapid_mm_min. The feed of a thread is its lead: on the axis along which it is longer (Fanuc, Haas, Sinumerik), or
    with `lead_along_thread` along the thread itself (LinuxCNC). A dwell counted in revolutions takes them at the speed
    unknown here, and is refused.

    Raises NC-FEED where a cut has no feed, or no spindle speed that its feed needs, or no limit near the axis.
    """
    length_mm = lengths_mm(path)
    with np.errstate(divide="ignore", invalid="ignore"):
        fed_mm = length_mm if lead_along_thread else _fed_mm(path, length_mm)
        minutes = np.where(path.feed_mode == INVERSE_TIME, 1.0, fed_mm) / path.feed
        per_revolution = path.feed_mode == PER_REVOLUTION
        minutes[per_revolution] *= _minutes_per_revolution(path, max_rpm)[per_revolution]
    minutes[path.rapid] = length_mm[path.rapid] / rapid_mm_min
    still = length_mm == 0.0
    minutes[still] = 0.0
    _require_known(path, minutes)
    if np.isnan(path.dwell_s).any():
        raise _unknown(path, int(path.dwell_before[np.isnan(path.dwell_s)][0]), "a dwell without a time in seconds")
    return MachiningTime(60.0 * minutes, path.rapid, float(path.dwell_s.sum()))


def _fed_mm(path: ToolPath, length_mm: Array) -> Array:
    """Returns the length that each move's feed refers to (n,), mm: for a thread the longer travel, X a radius."""
    travel_mm = np.abs(path.end_mm - path.start_mm).max(axis=1)
    return np.asarray(np.where(path.motion == Motion.THREAD, travel_mm, length_mm))


def _minutes_per_revolution(path: ToolPath, max_rpm: float | None) -> Array:
    """Mean of 1 / n along each move, min; NaN where the speed is not known."""
    constant = 1.0 / np.where(path.spindle_speed > 0.0, path.spindle_speed, np.nan)
    surface = path.spindle_mode == _SURFACE_SPEED
    if not surface.any():
        return np.asarray(constant)
    unit_mm = np.where(path.inch, _MM_PER_FOOT, MM_PER_M)
    limit_rpm = np.fmin(path.spindle_limit, np.inf if max_rpm is None else max_rpm)
    limit_rpm = np.where(np.isnan(limit_rpm), np.inf, limit_rpm)
    radius_mm = _radii_mm(path)
    per_revolution = 2.0 * np.pi * radius_mm / (path.spindle_speed * unit_mm)[:, None]
    slowest = np.maximum(per_revolution, 1.0 / limit_rpm[:, None]).mean(axis=1)
    slowest[(slowest == 0.0) | ~(path.spindle_speed > 0.0)] = np.nan
    return np.where(surface, slowest, constant)


def _radii_mm(path: ToolPath) -> Array:
    """|x| at the middle of each of `_PIECES` equal pieces of every move (n, pieces)."""
    share = (np.arange(_PIECES) + 0.5) / _PIECES
    radius = path.start_mm[:, [0]] + (path.end_mm - path.start_mm)[:, [0]] * share
    turning = np.flatnonzero((path.motion == Motion.ARC) & (path.plane == 18))
    arm = path.start_mm[turning] - path.centre_mm[turning]
    angle = path.sweep_rad[turning, None] * share
    # Positive is clockwise with z to the right and x up: x turns towards +z.
    radius[turning] = path.centre_mm[turning, [0]][:, None] + arm[:, [0]] * np.cos(angle) - arm[:, [2]] * np.sin(angle)
    return np.abs(radius)


def _require_known(path: ToolPath, minutes: Array) -> None:
    unknown = np.flatnonzero(~np.isfinite(minutes))
    if unknown.size:
        move = int(unknown[0])
        fed = path.feed[move] > 0.0
        raise _unknown(path, move, "a cut without a spindle speed" if fed else "a cut without a feed")


def _unknown(path: ToolPath, move: int, what: str) -> TrueloopError:
    line = int(path.line[min(move, len(path) - 1)]) if len(path) else None
    return Code.NC_FEED.refusal(
        f"line {line}: {what}: its time is not known",
        hint="write F, S, and near the axis a limit (G50 S…), or name it: --max-rpm",
        place=Place(line=line),
    )
