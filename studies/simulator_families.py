"""Families of turned parts beside NIST's, held against the virtual machine: a groove with two edges, a lens, two sides.

`python -m studies.simulator_families --family groove --parts 60` prints rows of a family, for docs/simulator-study.md.
Profiles and programs are written here, by hand; the machine cuts with noses and holders of its own.
"""

import argparse
import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from studies.simulated_edges import SeveralTrial, grooving, several_trial, simulate_several, with_nose
from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.job import read_cuts, read_job
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.batch import run_batch
from trueloop.loops.turned.correction import Inputs
from trueloop.nc.program.called import CalledOffset
from trueloop.statistics import rms
from trueloop.turned.fit.between_cuts import NONE
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import Trial, simulate, trial_of
from trueloop_lab.simulator.machine import Repeatability
from trueloop_lab.simulator.nose import SAME
from trueloop_lab.simulator.presets import Workshop, nist

ROOT: Final = Path(__file__).parents[1]
SIGMAS_UM: Final = (0.5, 1.2, 3.0)
FIRST_SEED: Final = 800_000
CORRELATION_MM: Final = 1.0
ALLOWANCE_MM: Final = 0.25
NOT_STEEP: Final = 0.2
"""As in `simulator_study`: all parts count."""
BALL_MM: Final = 0.5
CLEAR_OF_AXIS_MM: Final = 2.0
FEWEST, EVERY_MM, MOST = 4, 1.6, 12
"""Touches of a feature: one every so many millimetres, at least and at most so many."""

GROOVE_JOB: Final = """
[part]
name = "groove"
start = [25, -70]
feature = [
    { name = "big", to = [25, -52] }, { name = "left-wall", to = [15, -52] }, { name = "floor-left", to = [15, -43] },
    { name = "floor-right", to = [15, -34] }, { name = "right-wall", to = [25, -34] }, { name = "mid", to = [25, -16] },
    { name = "step", to = [16, -16] }, { name = "seat", to = [16, 0] },
]
[[tools]]
number = 3
nose_radius_mm = 0.8
[[tools]]
number = 5
nose_radius_mm = 0.2
groove_corner = "left"
[[tools]]
number = 15
nose_radius_mm = 0.2
groove_corner = "right"
[programs]
dialect = "linuxcnc"
finish = "finish.ngc"
semifinish_allowance_mm = 0.25
[gauging]
touches = "touches.csv"
"""
GROOVE_PROGRAM: Final = """G21 G18 G7 G40 G90 G95
G97 S800 M3
T3 M6 G43 H3
G0 X33.6 Z2
G1 X33.6 Z-15.2 F0.1
G1 X51.6 Z-15.2
G1 X51.6 Z-70
G0 X80 Z20
T5 M6 G43 H5
G0 X56 Z-51.8
G1 X30.4 Z-51.8 F0.05
G1 X30.4 Z-43
G0 X60 Z-43
G43 H15
G0 X56 Z-34.2
G1 X30.4 Z-34.2 F0.05
G1 X30.4 Z-43
G0 X60 Z-43
M2
"""
SIDE_JOB: Final = """
[part]
name = "side"
start = [{start}]
feature = [{features}]
[tool]
nose_radius_mm = 0.8
number = 1
[programs]
dialect = "linuxcnc"
finish = "finish.ngc"
semifinish_allowance_mm = 0.25
[gauging]
touches = "touches.csv"
"""
SIDES: Final = (
    (
        "25, -45",
        '{ name = "collar", to = [25, -30] }, { name = "step", to = [15, -30] }, { name = "journal", to = [15, -8] }, '
        '{ name = "end", to = [5, -8] }, { name = "pin", to = [5, 0] }',
        ["X11.6 Z2", "X11.6 Z-7.2", "X31.6 Z-7.2", "X31.6 Z-29.2", "X51.6 Z-29.2", "X51.6 Z-45"],
    ),
    (
        "25, -40",
        '{ name = "collar", to = [25, -24] }, { name = "step", to = [18, -24] }, { name = "seat", to = [18, -6] }, '
        '{ name = "shoulder", to = [8, -6] }, { name = "stub", to = [8, 0] }',
        ["X17.6 Z2", "X17.6 Z-5.2", "X37.6 Z-5.2", "X37.6 Z-23.2", "X51.6 Z-23.2", "X51.6 Z-40"],
    ),
)
"""First and second side of a shaft, each clamped by itself: start, features, and the ends of the finish pass."""


@dataclass(frozen=True)
class Made:
    """One part: true residuals and half bands at its gauging points, (n,), mm."""

    left_mm: Array
    expanded_u_mm: Array


def main() -> None:
    """Prints the rows of the families asked for."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--family", choices=sorted(FAMILIES), action="append", help="all of them without")
    options.add_argument("--parts", type=int, default=60, help="parts of each family and repeatability")
    options.add_argument("--sigma-um", type=float, action="append", help="repeatability along the cut; 0.5, 1.2 and 3")
    options.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = options.parse_args()
    print("|  | σ | parts | the loop | inside the 95 % band |\n| --- | ---: | ---: | ---: | ---: |")
    for name in given.family or sorted(FAMILIES):
        for sigma_um in given.sigma_um or SIGMAS_UM:
            print(_row(name, sigma_um, given.parts, given.workers), flush=True)


def _row(name: str, sigma_um: float, parts: int, workers: int) -> str:
    make = FAMILIES[name](Repeatability(sigma_um / UM_PER_MM, CORRELATION_MM))
    made = list(run_batch(make, range(FIRST_SEED, FIRST_SEED + parts), workers=workers))
    left = rms(np.concatenate([one.left_mm for one in made])) * UM_PER_MM / (sigma_um * math.sqrt(2.0))
    inside = 100 * np.array([np.mean(np.abs(one.left_mm) <= one.expanded_u_mm) for one in made])
    u = float(np.std(inside, ddof=1)) / math.sqrt(parts) if parts > 1 else math.nan
    return f"| {name.upper()} | {sigma_um} µm | {parts} | {left:.2f} | {np.mean(inside):.1f} ± {u:.1f} % |"


def groove(repeatability: Repeatability) -> Callable[[int], Made]:
    """A groove whose walls and floor two corners of an insert leave, in a shaft that an OD tool turns."""
    with tempfile.TemporaryDirectory() as folder:
        job = _written(Path(folder), GROOVE_JOB, GROOVE_PROGRAM)
        trial = several_trial(
            [(own, _touched(inputs)) for own, inputs in read_cuts(JobFiles.of(job)).setups[0].cuts if own is not None]
        )
    outside = with_nose(nist(repeatability, SAME), 0.8)
    small = replace(outside, probe=replace(outside.probe, ball_radius_mm=BALL_MM))
    edges = [own.edge for own, _ in trial.cuts]
    shops = {
        edge.called: grooving(edge.corner, repeatability) if edge.corner in ("left", "right") else small
        for edge in edges
    }
    return partial(_of_several, trial, shops)


def lens(every: int, repeatability: Repeatability) -> Callable[[int], Made]:
    """The asphere of examples/lens, by a macro loop, and every so many of its touches, which are 0.9 mm apart.

    None is nearer the axis than the ball is wide, since the virtual stock ends there.
    """
    inputs = read_job(ROOT / "examples" / "lens" / "job.toml").inputs
    touches = inputs.touches.chosen(np.flatnonzero(inputs.touches.nominal_mm[:, 0] > CLEAR_OF_AXIS_MM)[::every])
    options = replace(inputs.options, between_cuts=NONE, limits=replace(inputs.options.limits, slope=NOT_STEEP))
    trial = trial_of(replace(inputs, touches=touches, options=options))
    return partial(_of_one, [trial], with_nose(nist(repeatability, SAME), 0.8))


def sides(repeatability: Repeatability) -> Callable[[int], Made]:
    """Both sides of a shaft as two jobs, each with its z datum, inspection and program."""
    trials = []
    for start, features, ends in SIDES:
        with tempfile.TemporaryDirectory() as folder:
            moves = "\n".join(f"G1 {end}" for end in ends[1:])
            program = f"G21 G18 G7 G40 G90 G95 F0.1\nG97 S800 M3\nT1 M6\nG0 {ends[0]}\n{moves}\nG0 X80 Z20\nM2\n"
            job = _written(Path(folder), SIDE_JOB.format(start=start, features=features), program)
            trials.append(trial_of(_touched(read_job(job).inputs)))
    return partial(_of_one, trials, with_nose(nist(repeatability, SAME), 0.8))


FAMILIES: Final[Mapping[str, Callable[[Repeatability], Callable[[int], Made]]]] = {
    "groove": groove,
    "lens": partial(lens, 2),
    "lens-dense": partial(lens, 1),
    "sides": sides,
}


def _of_one(trials: Sequence[Trial], workshop: Workshop, seed: int) -> Made:
    parts = [simulate(trial, workshop, seed + 100_000 * k) for k, trial in enumerate(trials)]
    bands = [part.correction.prediction.expanded_u_mm for part in parts]
    return Made(np.concatenate([part.finish_truth_mm for part in parts]), np.concatenate(bands))


def _of_several(trial: SeveralTrial, shops: Mapping[CalledOffset, Workshop], seed: int) -> Made:
    part = simulate_several(trial, shops, seed)
    return Made(part.finish_truth_mm, part.expanded_u_mm)


def _written(folder: Path, job: str, program: str) -> Path:
    """A job with one touch on its first feature, which is not used: where to touch is said by `_touched`."""
    (folder / "finish.ngc").write_text(program)
    start = job.split("start = [")[1].split("]", maxsplit=1)[0].split(",")
    first = job.split('name = "', 2)[2].split('"', maxsplit=1)[0]
    z_mm = float(start[1]) + 1.0
    rows = f"point,feature,nominal_x_mm,nominal_z_mm,error_um\n1,{first},{start[0].strip()},{z_mm},0.0\n"
    (folder / "touches.csv").write_text(rows)
    (folder / "job.toml").write_text(job)
    return folder / "job.toml"


def _touched(inputs: Inputs) -> Inputs:
    """The job with touches all along its features, and cuts taken for alike."""
    profile = inputs.profile
    places = [(k, s) for k in range(len(profile.features)) for s in _places_mm(profile, k)]
    index, along = np.array([k for k, _ in places], dtype=np.intp), np.array([s for _, s in places])
    count = len(places)
    touches = ErrorVectors(
        tuple(str(k + 1) for k in range(count)),
        index,
        along,
        np.zeros(count),
        np.zeros(count),
        np.zeros(count, dtype=np.bool_),
        np.array([profile.features[k].point_mm(s) for k, s in places]).reshape(-1, 2),
        np.array([profile.features[k].outward_normal(s) for k, s in places]).reshape(-1, 2),
    )
    options = replace(inputs.options, between_cuts=NONE, limits=replace(inputs.options.limits, slope=NOT_STEEP))
    return replace(inputs, touches=touches, allowance_mm=ALLOWANCE_MM, options=options)


def _places_mm(profile: Profile, index: int) -> Iterator[float]:
    """Evenly spread, clear of a concave corner by what the ball, the allowance and the nose need there."""
    length_mm = profile.features[index].length_mm
    margins = [2.0 if index == 0 else 0.5, 2.0 if index == len(profile.features) - 1 else 0.5]
    for side, junction in ((0, index - 1), (1, index)):
        if 0 <= junction < len(profile.junctions) and profile.junctions[junction].turn_rad < 0.0:
            margins[side] = 2.0
    free_mm = length_mm - sum(margins)
    count = min(max(round(free_mm / EVERY_MM) + 1, FEWEST), MOST)
    yield from np.linspace(margins[0], length_mm - margins[1], count).tolist()


if __name__ == "__main__":
    main()
