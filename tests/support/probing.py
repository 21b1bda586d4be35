"""Plans to probe by, and probing programs as moves."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trueloop.controllers.probing import Settings
from trueloop.errors import Severity
from trueloop.gauging.obstacle import stock_obstacle
from trueloop.gauging.plan import GaugingPoints, Spacing, equally_spaced
from trueloop.gauging.probe_plan import Approach, ProbePlan, probe_plan
from trueloop.gauging.stylus import Stylus
from trueloop.geometry.feature import Array, Line, Point
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.job_inputs import read_inputs
from trueloop.loops.process_intermittent import Inputs
from trueloop.nc.program import read_program
from trueloop.nc.tool_path import Motion

EXAMPLES = Path(__file__).parents[2] / "examples"
STYLUS = Stylus(1.5, 0.75, 50.0, np.pi / 4)
APPROACH = Approach(stand_off_mm=2.0, overtravel_mm=1.0, margin_mm=0.4)
STEP = checked_profile([Line("cylinder", (40.0, -30.0), (40.0, 0.0)), Line("face", (40.0, 0.0), (0.0, 0.0))])
COMMENT = re.compile(r";.*")
WORD = re.compile(r"([XZ])\s*([-+]?\d*\.?\d+)")
READ_AS = {
    "linuxcnc": "linuxcnc",
    "fanuc": "fanuc-lathe",
    "haas": "haas-lathe",
    "renishaw": "fanuc-lathe",
    "ge2000t": "ge2000t",
}
SYSTEM_VARIABLES = ("#5061", "#5062", "#5063")
INCREMENT = {"X": "U", "Z": "W"}


@dataclass(frozen=True)
class ProbeMove:
    """One move of the ball's centre, (x, z) in mm with x a radius; a `touching` one is told to its programmed end."""

    start_mm: Point
    end_mm: Point
    touching: bool


def moves_of(text: str, control: str, plan: ProbePlan, program: Settings) -> list[ProbeMove]:
    """Every move of a probing program once both coordinates are known, as trueloop's reader of that control runs it.

    What the control itself would put into variables is given as zero: nothing moves by it. A control that trueloop does
    not read is read word by word.
    """
    if control not in READ_AS:
        return _moves_by_words(text, program)
    if control == "renishaw":
        text = _without_macros(text, plan, program)
    path = read_program(text.encode(), READ_AS[control]).run({name: 0.0 for name in SYSTEM_VARIABLES if name in text})
    assert not [found for found in path.findings if found.severity != Severity.NOTE], path.findings
    touching = path.motion == Motion.PROBE
    if control == "ge2000t":
        touching = np.abs(path.feed - program.probe_feed_mm_per_min) < 1e-3 * program.probe_feed_mm_per_min
    known = int(np.argmax(path.motion != Motion.RAPID)) - 1  # rapids away from the axis, then along it
    moves = zip(path.start_mm[known:], path.end_mm[known:], touching[known:], strict=True)
    return [ProbeMove((a[0], a[2]), (b[0], b[2]), bool(touches)) for a, b, touches in moves]


def _without_macros(text: str, plan: ProbePlan, program: Settings) -> str:
    """The macros as moves: P9810 goes to a place; P9811 takes the ball Q beyond the surface it names, then back."""
    ball_mm, beyond_mm = plan.stylus.ball_radius_mm, plan.approach.overtravel_mm

    def touch(found: re.Match[str]) -> str:
        axis, surface, overtravel = found[1], float(found[2]), float(found[3])
        assert abs(overtravel * program.unit_mm - beyond_mm) < 1e-3
        doubled = 2.0 if axis == "X" and program.diameter else 1.0
        end = surface + doubled * (ball_mm - beyond_mm) / program.unit_mm
        back = doubled * (plan.approach.stand_off_mm + beyond_mm) / program.unit_mm
        return f"G31 {axis}{end:.5f} F60.\nG1 {INCREMENT[axis]}{back:.5f} F60."

    return re.sub(r"G65 P9811 ([XZ])(\S+) Q(\S+)", touch, text.replace("G65 P9810", "G1"))


def _moves_by_words(text: str, program: Settings) -> list[ProbeMove]:
    at: dict[str, float] = {}
    moves = []
    for raw in text.splitlines():
        line = "" if raw.startswith(("WRITE", "R1=")) else COMMENT.sub("", raw)
        words = {letter: float(value) * program.unit_mm for letter, value in WORD.findall(line)}
        if not words:
            continue
        if "X" in words and program.diameter:
            words["X"] /= 2
        before, at = at, at | words
        if len(before) == 2:
            moves.append(ProbeMove((before["X"], before["Z"]), (at["X"], at["Z"]), "MEAS=1" in line))
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
