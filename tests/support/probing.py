"""Plans to probe by, and probing programs as moves."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trueloop.arrays import Array
from trueloop.controllers.probing import Settings, probing_program
from trueloop.errors import Severity
from trueloop.geometry.feature import Line, Point
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Inputs
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion
from trueloop.probing.calibration import Stylus, stock_obstacle
from trueloop.probing.probe_plan import Approach, GaugingPoints, ProbePlan, Spacing, equally_spaced, probe_plan

EXAMPLES = Path(__file__).parents[2] / "examples"
STYLUS = Stylus(1.5, 0.75, 50.0, np.pi / 4)
APPROACH = Approach(stand_off_mm=2.0, overtravel_mm=1.0, margin_mm=0.4)
STEP = checked_profile([Line("cylinder", (40.0, -30.0), (40.0, 0.0)), Line("face", (40.0, 0.0), (0.0, 0.0))])
READ_AS = {
    "linuxcnc": "linuxcnc",
    "fanuc": "fanuc-lathe",
    "haas": "haas-lathe",
    "renishaw": "fanuc-lathe",
    "siemens": "siemens",
    "ge2000t": "ge2000t",
}
RESULTS = {"#5061": 0.0, "#5062": 0.0, "#5063": 0.0, "$AA_MW[X]": 0.0, "$AA_MW[Z]": 0.0, "$AC_MEA[1]": 1.0}
"""What a control puts into variables of its own when it has touched."""
OUTPUT = re.compile(r'^(?:DPRNT\[(.*)\]|WRITE\(FAULT,"\w+",("X".*)\))$', re.MULTILINE)
"""The statement that logs a touch: Fanuc's, or Siemens'."""
MILLIMETRES = Settings()
CHECK = re.compile(r"^IF.*\n", re.MULTILINE)
"""What a program does where a touch was missed or a way obstructed: `tests/unit/controllers` runs that."""
INCREMENT = {"X": "U", "Z": "W"}


@dataclass(frozen=True)
class ProbeMove:
    """One move of the ball's centre, (x, z) in mm with x a radius; a `touching` one is told to its programmed end."""

    start_mm: Point
    end_mm: Point
    touching: bool


def moves_of(text: str, control: str, plan: ProbePlan, program: Settings) -> list[ProbeMove]:
    """Every move of a probing program once both coordinates are known, as trueloop's reader of that control runs it.

    Nothing moves by what the control itself puts into variables.
    """
    if control == "renishaw":
        text = _without_macros(text, plan, program)
    read = read_program(CHECK.sub("", text).encode(), READ_AS[control])
    path = read.run({name: value for name, value in RESULTS.items() if name in text})
    findings = [*read.findings, *path.findings]
    assert not [found for found in findings if found.severity != Severity.NOTE], findings
    touching = (path.motion == Motion.PROBE) & (np.abs(path.feed - program.probe_feed_mm_per_min) < 1e-3)
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
        feed = program.feed(program.probe_feed_mm_per_min)
        return f"G31 {axis}{end:.5f} {feed}\nG1 {INCREMENT[axis]}{back:.5f} {feed}"

    return re.sub(r"G65 P9811 ([XZ])(\S+) Q(\S+)", touch, text.replace("G65 P9810", "G1"))


def plan_of(
    profile: Profile, counts: dict[str, int], approach: Approach = APPROACH, stylus: Stylus = STYLUS
) -> ProbePlan:
    spacings = {
        name: Spacing(count, 1.5 * stylus.ball_radius_mm, 1.5 * stylus.ball_radius_mm) for name, count in counts.items()
    }
    points = equally_spaced(profile, spacings)
    return probe_plan(profile, points, stock_obstacle(profile, approach.allowance_mm), stylus, approach)


def example(name: str) -> Inputs:
    return read_job(EXAMPLES / name / "job.toml").inputs


def points_of(inputs: Inputs) -> GaugingPoints:
    at = inputs.touches
    return GaugingPoints(at.feature_index, at.arc_length_mm, at.nominal_mm, at.outward_normal)


def example_plan(name: str, allowance_mm: float = 0.254) -> ProbePlan:
    """The plan of an example job, touched where its touches are."""
    inputs = example(name)
    approach = replace(APPROACH, allowance_mm=allowance_mm)
    obstacle = stock_obstacle(inputs.profile, allowance_mm)
    return probe_plan(inputs.profile, points_of(inputs), obstacle, STYLUS, approach, inputs.touches.point)


def log_of(
    plan: ProbePlan,
    centres_mm: Array,
    rows: Sequence[int] | None = None,
    control: str = "fanuc",
    program: Settings = MILLIMETRES,
) -> str:
    """What a control writes of touches at these centres, in this order: its probing program's own output statements."""
    statements = OUTPUT.findall(probing_program(plan, control, program))
    scale = np.array([2.0 if program.diameter else 1.0, 1.0]) / program.unit_mm
    rows = range(len(plan.touches)) if rows is None else rows
    return "".join(f"{_written(statements[k], scale * centres_mm[k])}\n" for k in rows)


def _written(statement: tuple[str, str], values: Array) -> str:
    dprnt, siemens = statement
    if siemens:
        names = dict(zip(("R1", "R2"), values, strict=True))
        return "".join(part.strip('"') if '"' in part else f"{names[part]:.10g}" for part in siemens.split("<<"))
    in_order = iter(values)
    # Leading zeros are blanks, and one stands for the sign.
    return re.sub(r"#\d+\[(\d)(\d)\]", lambda f: f"{next(in_order):{int(f[1]) + int(f[2]) + 2}.{f[2]}f}", dprnt)
