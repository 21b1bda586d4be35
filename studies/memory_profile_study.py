"""Whole arcs under the edge model and simple rules, in the simulated shop: the table of `studies.memory_study`."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from studies.memory_level_study import SEED, rms_um
from studies.memory_notice_study import THREE, part_of
from trueloop.arrays import Array, Integers
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop_lab.simulator.series import Series, Shop, draw

SERIES: Final = 6
PARTS: Final = 16
SHOP: Final = Shop(parts=PARTS)
WEIGHTS: Final = np.arange(0.0, 1.01, 0.125)


@dataclass(frozen=True)
class _Run:
    """One series corrected by memory: true errors left (parts, n), and by how many deviations it was mispredicted."""

    series: Series
    left: Array
    z: Array


def profiles(series: int = SERIES) -> str:
    """RMS left on the arcs by parts, and how many inspected errors lie inside the bands."""
    rows = []
    for touches in (np.arange(len(SHOP.angle_rad)), THREE):
        runs = [_by_memory(draw(SHOP, np.random.default_rng(SEED + 50_000 + k)), touches) for k in range(series)]
        left = {"memory": np.array([run.left for run in runs])}
        left["own touches"] = np.array([run.series.uncorrected_mm - _own(run.series, touches) for run in runs])
        for name, weight in (("× 0.75", 0.75), ("in hindsight", None)):
            rule = [_simple(run.series, touches, weight) for run in runs] if weight else _best(runs, touches)
            left[f"mean of earlier parts, {name}"] = np.array(rule)
        z = np.array([run.z for run in runs])
        inside = [f"{100 * np.mean(np.abs(z[:, a:b]) < 1.96):.1f} %" for a, b in ((1, 5), (5, PARTS))]
        rows += [
            f"| {len(touches)} | {name} | {rms_um(of[:, 1:5]):.2f} | {rms_um(of[:, 5:]):.2f} "
            f"| {' | '.join(inside if name == 'memory' else ['', ''])} |"
            for name, of in left.items()
        ]
    head = f"| touches | corrected by | parts 2–5 | parts 6–{PARTS} | inside 95 %, parts 2–5 | parts 6–{PARTS} |"
    return "\n".join([f"{series} series of {PARTS} parts.", "", head, "|---:|---|---:|---:|---:|---:|", *rows, ""])


def _by_memory(series: Series, touches: Integers) -> _Run:
    history: list[MadePart] = []
    left, z, nothing = [], [], np.zeros(len(series.angle_rad))
    for k in range(PARTS):
        today = part_of(series, k, touches, nothing, nothing)
        said = expect(tuple(history), _uninspected(today), CutErrors.asked(series.angle_rad, "arc"), MemoryOptions())
        correction = said.weight * said.mean_mm
        left.append(series.left_mm(k, correction))
        predicted = said.mean_mm * said.gain - correction
        z.append((series.inspected_mm(k, correction) - predicted) / np.sqrt(np.diag(said.covariance_mm2)))
        history.append(part_of(series, k, touches, correction, nothing))
    return _Run(series, np.array(left), np.array(z))


def _uninspected(part: MadePart) -> MadePart:
    return MadePart(
        part.part_type, part.serial, part.setting, part.order, part.semifinish, minutes_in_cut=part.minutes_in_cut
    )


def _own(series: Series, touches: Integers) -> Array:
    """Today's touches alone: themselves where all are made, else the offset that they show."""
    if len(touches) == len(series.angle_rad):
        return series.semifinish_mm
    return np.array([_offset(series, touches, touched) for touched in series.semifinish_mm])


def _simple(series: Series, touches: Integers, weight: float) -> Array:
    """Own touches and a share of the mean of what earlier finish errors differed by from their own touches."""
    own = _own(series, touches)
    differ = series.uncorrected_mm + series.noise_mm - own
    means = [differ[:k].mean(axis=0) if k else 0 * own[0] for k in range(len(own))]
    return np.asarray(series.uncorrected_mm - own - weight * np.array(means))


def _best(runs: list[_Run], touches: Integers) -> Array:
    """The same with the share that turns out best from the sixth part on."""
    tried = [np.array([_simple(run.series, touches, weight) for run in runs]) for weight in WEIGHTS]
    return min(tried, key=lambda left: rms_um(left[:, 5:]))


def _offset(series: Series, touches: Integers, touched: Array) -> Array:
    ways = np.stack([np.sin(series.angle_rad), np.cos(series.angle_rad)], axis=1)
    return np.asarray(ways @ np.linalg.lstsq(ways[touches], touched[touches], rcond=None)[0])
