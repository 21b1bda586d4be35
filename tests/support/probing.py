"""Probing programs as moves, read without trueloop: `G…`, `X…` and `Z…` words of any of the dialects, line by line."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trueloop.gauging.obstacle import stock_obstacle
from trueloop.gauging.plan import GaugingPoints, Spacing, equally_spaced
from trueloop.gauging.probe_plan import Approach, ProbePlan, probe_plan
from trueloop.gauging.stylus import Stylus
from trueloop.geometry.feature import Array, Line, Point
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.job_inputs import read_inputs
from trueloop.loops.process_intermittent import Inputs

EXAMPLES = Path(__file__).parents[2] / "examples"
STYLUS = Stylus(1.5, 0.75, 50.0, np.pi / 4)
APPROACH = Approach(stand_off_mm=2.0, overtravel_mm=1.0, margin_mm=0.4)
STEP = checked_profile([Line("cylinder", (40.0, -30.0), (40.0, 0.0)), Line("face", (40.0, 0.0), (0.0, 0.0))])
COMMENT = re.compile(r"\([^)]*\)|!.*|;.*")
WORD = re.compile(r"([XZ])\s*([-+]?\d*\.?\d+)")
TOUCHING = ("G38.2", "G31", "MEAS=1", "P9811")


@dataclass(frozen=True)
class ProbeMove:
    """One move of the ball's centre, (x, z) in mm with x a radius; `touching` is a probing move."""

    start_mm: Point
    end_mm: Point
    touching: bool


def moves_of(text: str, *, inch: bool = False, diameter: bool = True) -> list[ProbeMove]:
    """Every move after both coordinates are known. GE 2000T has no word for touching: a slow move is one."""
    unit = 25.4 if inch else 1.0
    at: dict[str, float] = {}
    moves = []
    for raw in text.splitlines():
        line = "" if raw.lstrip().startswith(("DPRNT", "WRITE", "R1=", "#", "(")) else COMMENT.sub("", raw)
        words = {letter: float(value) * unit for letter, value in WORD.findall(line)}
        if not words:
            continue
        if "X" in words and diameter:
            words["X"] /= 2
        before, at = at, at | words
        if len(before) == 2:
            slow = line.startswith("N") and "F60." in line
            touching = any(mark in line for mark in TOUCHING) or slow
            moves.append(ProbeMove((before["X"], before["Z"]), (at["X"], at["Z"]), touching))
    return moves


def plan_of(
    profile: Profile, counts: dict[str, int], approach: Approach = APPROACH, stylus: Stylus = STYLUS
) -> ProbePlan:
    spacings = {
        name: Spacing(count, 1.5 * stylus.ball_radius_mm, 1.5 * stylus.ball_radius_mm) for name, count in counts.items()
    }
    points = equally_spaced(profile, spacings)
    return probe_plan(profile, points, stock_obstacle(profile, approach.allowance_mm), stylus, approach)


def example(name: str) -> Inputs:
    return read_inputs(EXAMPLES / name / "job.toml").inputs


def points_of(inputs: Inputs) -> GaugingPoints:
    at = inputs.touches
    return GaugingPoints(at.feature_index, at.arc_length_mm, at.nominal_mm, at.outward_normal)


def example_plan(name: str, allowance_mm: float = 0.254) -> ProbePlan:
    """The plan of an example job, touched where its touches are."""
    inputs = example(name)
    approach = replace(APPROACH, allowance_mm=allowance_mm)
    obstacle = stock_obstacle(inputs.profile, allowance_mm)
    return probe_plan(inputs.profile, points_of(inputs), obstacle, STYLUS, approach, inputs.touches.point)


def log_of(plan: ProbePlan, centres_mm: Array, rows: Sequence[int] | None = None, diameter: bool = True) -> str:
    """What a Fanuc would write of touches at these centres, in this order."""
    rows = range(len(plan.touches)) if rows is None else rows
    factor = 2.0 if diameter else 1.0
    return "".join(f"X{factor * centres_mm[k][0]:.4f}Z{centres_mm[k][1]:.4f}\n" for k in rows)
