"""A virtual lathe that errs while it warms up: its truth by plain transforms, its temperatures, instruments on it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop_lab.simulator.machine import Backlash

COLD_C: Final = 20.0
FASTER: Final = 60.0
STEP_S: Final = 0.02
BEARING_K, BEARING_S = 24.0, 20.0
CASTING_SHARE, CASTING_S = 0.8, 30.0
NUT_K, NUT_S, SCREW_S = 8.0, 25.0, 18.0
HALL_K, HALL_PERIOD_S = 0.4, 900.0
SURFACE_SHARE: Final = 0.2
SENSOR_NOISE_K: Final = 0.02

Spans = Sequence[tuple[float, float]]
"""From when to when something runs, s."""


@dataclass(frozen=True)
class WarmUp:
    """Temperatures over time, each (n,), °C above 20: front bearing, casting of the headstock, nut, screw, hall.

    The nut is heated where it runs; the screw follows it, and no sensor is on it.
    """

    time_s: Array
    bearing: Array
    casting: Array
    nut: Array
    screw: Array
    hall: Array

    def at(self, time_s: Array) -> "WarmUp":
        """Returns the state at other times: linear between the known ones, constant beyond the ends."""
        known = (self.bearing, self.casting, self.nut, self.screw, self.hall)
        return WarmUp(time_s, *(np.interp(time_s, self.time_s, values) for values in known))

    def sensors(self, rng: np.random.Generator | None = None) -> dict[str, Array]:
        """Returns the readings, °C: T1 at the bearing, T2 on the casting's skin near it, T3 at the nut."""
        skin = (1 - SURFACE_SHARE) * self.casting + SURFACE_SHARE * self.bearing
        true = {"T1": self.bearing, "T2": skin, "T3": self.nut}
        noise = rng.normal(0.0, SENSOR_NOISE_K, (3, len(self.time_s))) if rng else np.zeros((3, len(self.time_s)))
        return {name: COLD_C + self.hall + true[name] + n for name, n in zip(true, noise, strict=True)}


def warm_up(until_s: float, spindle: Spans, axes: Spans) -> WarmUp:
    """Simulates a machine cold at 0 s, with the spindle turning and the axes moving within the spans."""
    time_s = np.arange(0.0, until_s + STEP_S, STEP_S)
    turning, moving = (_within(time_s, spans) for spans in (spindle, axes))
    bearing = _follows(BEARING_K * turning, BEARING_S)
    casting = _follows(CASTING_SHARE * bearing, CASTING_S)
    nut = _follows(NUT_K * moving, NUT_S)
    hall = HALL_K * np.sin(2 * np.pi * time_s / HALL_PERIOD_S)
    return WarmUp(time_s, bearing, casting, nut, _follows(nut, SCREW_S), hall)


def _within(time_s: Array, spans: Spans) -> Array:
    return np.asarray(sum(((time_s >= low) & (time_s < high) for low, high in spans), np.zeros(len(time_s))))


def _follows(driven: Array, constant_s: float) -> Array:
    """A body that takes on the temperature of what heats it, cold at first."""
    share, at, found = STEP_S / constant_s, 0.0, np.empty(len(driven))
    for k, towards in enumerate(driven.tolist()):
        at += share * (towards - at)
        found[k] = at
    return found


X_TRAVEL_MM: Final = (-10.0, 310.0)
Z_TRAVEL_MM: Final = (-300.0, 110.0)
SQUARE_RAD, PARALLEL_RAD = 35e-6, -22e-6
SCREW_PER_K: Final = 11.5e-6
FIXED_Z_MM: Final = 110.0
"""The z at which the screw is held: it grows from there."""


@dataclass(frozen=True)
class WarmLathe:
    """The machine: `share` of its errors (0: none), and the lost motion of its drives, mm."""

    share: float = 1.0
    lost: Backlash = field(default_factory=lambda: Backlash(0.0012, 0.0080))

    def without_errors(self) -> "WarmLathe":
        """Returns the machine without errors and lost motion."""
        return WarmLathe(0.0, Backlash())

    def tool_mm(self, drives_mm: Array, tool_mm: Array, warm: WarmUp) -> Array:
        """Returns positions of the tool point in work coordinates, (n, 2), for the drives at (n, 2), in order.

        `tool_mm` (2,) leads from the cross slide's frame to the tool point; `warm` holds the moment of each position.
        """
        slides = self.lost.follow(drives_mm)
        return slides + tool_mm + self.error_mm(slides, tool_mm, warm)

    def error_mm(self, slides_mm: Array, tool_mm: Array, warm: WarmUp) -> Array:
        """Returns actual less intended position of the tool point as seen from the work, (n, 2), lost motion apart."""
        (x, z), share = slides_mm.T, self.share
        point = _turned(np.broadcast_to(tool_mm, slides_mm.shape), share * _cross_slide_yaw(x))
        point = point + share * _cross_slide(x) + x[:, None] * _direction(share * SQUARE_RAD)
        point = _turned(point, share * _carriage_yaw(z)) + share * _carriage(z, warm.screw + warm.hall)
        point = point + z[:, None] * _direction(share * PARALLEL_RAD)[::-1] * [-1.0, 1.0]
        seen = _turned(point - share * _headstock(warm), -share * _headstock_tilt(warm))
        return np.asarray(seen - slides_mm - tool_mm)

    def turned_rad(self, slides_mm: Array, warm: WarmUp) -> Array:
        """Returns the angle by which the tool is turned about Y as seen from the work, (n,)."""
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


UNTIL_S: Final = 2400.0
SPINDLE: Final = ((300.0, 450.0), (1100.0, 1160.0), (1300.0, 1500.0), (1700.0, 1730.0))
AXES: Final = ((600.0, 700.0), (750.0, 770.0), (1300.0, 1500.0), (1900.0, 1990.0))
LASER_UM, STRAIGHT_UM, BAR_UM, PROBE_UM, ANGLE_URAD = 0.15, 0.2, 0.3, 0.1, 0.5
REFERENCE_TOOL_MM: Final = (0.0, 0.0)
LONG_TOOL_MM: Final = (-60.0, 90.0)
MID_MM: Final = (150.0, -100.0)
DRIFT_AT_MM: Final = (40.0, -150.0)
FAR_DRIFT_AT_MM: Final = (40.0, -20.0)
BAR_MM: Final = 100.0
X_ENDS, Z_ENDS = (0.0, 300.0), (-290.0, 100.0)


@dataclass(frozen=True)
class Reading:
    """One reading: commanded position and way of travel (x, z), direction, value in µm, or µrad where `angle`."""

    time_s: float
    at_mm: tuple[float, float]
    way: tuple[int, int]
    along: tuple[float, float]
    tool_mm: tuple[float, float]
    value: float
    u: float
    run: str
    angle: bool = False
    slope_known: bool = False


@dataclass(frozen=True)
class _Run:
    """Places in order with what the instrument looks along, and its noise in µm or µrad."""

    name: str
    begin_s: float
    places_mm: Array
    along: Array
    noise: float
    tool_mm: tuple[float, float] = REFERENCE_TOOL_MM
    step_s: float = 0.5
    angle: bool = False
    straightness: str = ""


def measured_day(lathe: WarmLathe, seed: int = 0) -> tuple[WarmUp, tuple[Reading, ...]]:
    """Returns the machine's temperatures over the day, and all readings."""
    day, rng = warm_up(UNTIL_S, SPINDLE, AXES), np.random.default_rng(seed)
    return day, tuple(reading for run in _runs() for reading in _read(lathe, day, run, rng))


def _runs() -> Iterator[_Run]:
    there_and_back = np.concatenate([np.arange(0, 1.01, 1 / 30), np.arange(1, -0.01, -1 / 30)])
    x_line = np.column_stack([np.interp(there_and_back, [0, 1], X_ENDS), np.full(len(there_and_back), MID_MM[1])])
    z_line = np.column_stack([np.full(len(there_and_back), MID_MM[0]), np.interp(there_and_back, [0, 1], Z_ENDS)])
    for number, tool in enumerate((REFERENCE_TOOL_MM, LONG_TOOL_MM)):
        yield _Run(f"laser X {number}", 5 + 120 * number, x_line, _all(x_line, 1, 0), LASER_UM, tool)
        yield _Run(f"laser Z {number}", 40 + 120 * number, z_line, _all(z_line, 0, 1), LASER_UM, tool)
    yield _Run("straightness of X", 75, x_line, _all(x_line, 0, 1), STRAIGHT_UM, straightness="by eye")
    yield _Run("straightness of Z", 200, z_line, _all(z_line, 1, 0), STRAIGHT_UM, straightness="spindle")
    yield _Run("yaw of X", 235, x_line, _all(x_line, 0, 0), ANGLE_URAD, angle=True)
    yield _Run("yaw of Z", 265, z_line, _all(z_line, 0, 0), ANGLE_URAD, angle=True)
    for number, begin_s in enumerate((620, 665, 700, 735, 780, 850, 1320, 1400, 1480, 1540, 1950, 2050)):
        yield _Run(f"laser Z warm {number}", begin_s, z_line, _all(z_line, 0, 1), LASER_UM)
    for number, begin_s in enumerate((155, 960)):
        yield _ball_bar(f"ball bar {number}", begin_s)
    for number, (begin_s, until_s) in enumerate(((295, 600), (1090, 1300), (1500, 1900))):
        yield from _drift(number, np.arange(begin_s, until_s, 4.0))


def _all(places: Array, x: float, z: float) -> Array:
    return np.tile(np.array([x, z]), (len(places), 1))


def _ball_bar(name: str, begin_s: float) -> _Run:
    """Once round and back: the bar's direction leads from its centre to the tool."""
    angle = np.concatenate([np.arange(0, 361, 6), np.arange(360, -1, -6)]) * np.pi / 180
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    return _Run(name, begin_s, MID_MM + BAR_MM * along, along, BAR_UM, step_s=0.2)


def _drift(number: int, time_s: Array) -> Iterator[_Run]:
    """Probes at a bar in the spindle, the axes standing: across at two places, and along."""
    for name, at_mm, along in (
        ("X", DRIFT_AT_MM, (1, 0)),
        ("X far", FAR_DRIFT_AT_MM, (1, 0)),
        ("Z", DRIFT_AT_MM, (0, 1)),
    ):
        places = np.broadcast_to(at_mm, (len(time_s), 2))
        yield _Run(
            f"drift {number} {name}",
            float(time_s[0]),
            places,
            _all(places, *along),
            PROBE_UM,
            step_s=float(time_s[1] - time_s[0]),
        )


def _read(lathe: WarmLathe, day: WarmUp, run: _Run, rng: np.random.Generator) -> Iterator[Reading]:
    time_s = run.begin_s + run.step_s * np.arange(len(run.places_mm), dtype=np.float64)
    ways = _ways(run.places_mm)
    slides = run.places_mm - 0.5 * lathe.share * ways * [lathe.lost.x_mm, lathe.lost.z_mm]
    warm = day.at(time_s)
    if run.angle:
        value = 1e6 * lathe.turned_rad(slides, warm)
    else:
        error = slides - run.places_mm + lathe.error_mm(slides, np.array(run.tool_mm), warm)
        value = 1e3 * np.einsum("ij,ij->i", error, run.along)
    value = value + rng.normal(0, run.noise, len(value)) + rng.normal(0, 5.0)
    if run.straightness == "by eye":
        value = value + rng.normal(0, 0.03) * run.places_mm.sum(axis=1)
    for k, at in enumerate(run.places_mm.tolist()):
        yield Reading(
            float(time_s[k]), tuple(at), tuple(ways[k].tolist()), tuple(run.along[k].tolist()), run.tool_mm,
            float(value[k]), run.noise, run.name, run.angle, run.straightness == "spindle",
        )  # fmt: skip


def _ways(places_mm: Array) -> Array:
    """Which way each axis last moved, +1 or −1; at first the way it is about to go, 0 where it stands all along."""
    ways = np.zeros(places_mm.shape, dtype=int)
    for axis in range(2):
        moved = np.sign(np.diff(places_mm[:, axis])).astype(int).tolist()
        way = next((step for step in moved if step), 0)
        ways[0, axis] = way
        for k, step in enumerate(moved):
            way = step or way
            ways[k + 1, axis] = way
    return ways
