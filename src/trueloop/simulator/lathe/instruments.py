"""A day of measuring on the virtual lathe: what laser, straightedge, autocollimator, ball bar and drift probes read.

Every reading is taken at a moment of one long run of the machine, cold at its beginning. Each instrument has its noise,
a zero of its own for every run, and a straightedge a slope of its own; straightness of Z is read on a bar in the
spindle. A place is approached from the side that the reading says.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.simulator.lathe.truth import WarmLathe
from trueloop.simulator.lathe.warm_up import WarmUp, warm_up

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
    """The machine's temperatures over the day, and all readings."""
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
