"""The envelope beside shapely's buffer, and one simulated part."""

import functools
import importlib
import importlib.util
import math
from pathlib import Path

import numpy as np

from benches.ratio import Contender, compare
from trueloop.arrays import Array
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate
from trueloop_lab.loops.turned import Trial, finish, measured_part, semifinish_and_probe, simulate, trial_of
from trueloop_lab.simulator.machine import REACH_MM, sweep
from trueloop_lab.simulator.nose import Nose
from trueloop_lab.simulator.presets import nist

EXAMPLES = Path(__file__).parents[1] / "examples"
SEGMENTS = 10_000
NOSE = Nose(0.8)


def quarter(noise_mm: float) -> tuple[Array, Array, Array]:
    """A quarter circle of 38 mm as 10⁴ segments, and the rays that ask its envelope, as many."""
    angle = np.linspace(0.0, math.pi / 2, SEGMENTS + 1)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    nodes = 38.0 * direction + np.random.default_rng(1).normal(0.0, 1.0, (SEGMENTS + 1, 2)) * noise_mm
    return nodes, 37.2 * direction[1:-1], direction[1:-1]


def ours(nodes: Array, points: Array, directions: Array) -> Array:
    return sweep(nodes, NOSE).entries(points, directions, np.full(len(points), REACH_MM), REACH_MM)


def envelope() -> None:
    """Ours asks 10⁴ rays of 10⁴ segments; the rival makes a polygon that says nothing of them yet."""
    for words, noise_mm in (("smooth", 0.0), ("±1 µm of noise", 1e-3)):
        nodes, points, directions = quarter(noise_mm)
        error = np.max(np.abs(ours(nodes, points, directions))) if not noise_mm else math.nan
        note = f"largest error {error * 1e6:.2f} nm" if not noise_mm else ""
        contenders = [Contender("trueloop", functools.partial(ours, nodes, points, directions), note)]
        if importlib.util.find_spec("shapely"):
            line = importlib.import_module("shapely").LineString(nodes)
            contenders.append(Contender("shapely buffer", functools.partial(line.buffer, 0.8, quad_segs=256)))
        compare(f"Turning envelope, {SEGMENTS} segments, {words}", contenders, note_heading="accuracy")


def without_loop(trial: Trial) -> None:
    """Three cuts, 32 touches, calibration, measuring machine: the correction is made beforehand."""
    semifinished, touches = semifinish_and_probe(trial, WORKSHOP, 1)
    finished = finish(trial, WORKSHOP, CORRECTION, semifinished, 1)
    measured_part(trial, WORKSHOP, CORRECTION, touches, semifinished, finished, 1)


WORKSHOP = nist()
TRIAL = trial_of(read_job(EXAMPLES / "modbas2" / "job.toml").inputs)
CORRECTION = compensate(TRIAL.inputs)


def main() -> None:
    """The envelope, then parts."""
    envelope()
    compare(
        "One simulated part: three cuts, 32 touches, measuring machine",
        [
            Contender("simulator alone", lambda: without_loop(TRIAL), "aim: 20 ms, at most 50 ms"),
            Contender("with the loop under trial", lambda: simulate(TRIAL, WORKSHOP, 1)),
        ],
    )


if __name__ == "__main__":
    main()
