"""From a job to its probing plan, and from what a control logged to touches that the job can be corrected by."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Inspection, Touch
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.inspections.dmis.results import MeasuredCircle, dmis_program
from trueloop.formats.jobs.job import Job, locate_turned_job, read_turned_job
from trueloop.formats.jobs.probe_toml import ReadProbe, read_probe
from trueloop.formats.measurements.cmm_plan_csv import read_cmm_plan
from trueloop.formats.measurements.touches_csv import read_probe_log, read_touches
from trueloop.geometry.feature import Line, Point
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.job import ReadPart, read_part
from trueloop.jobs.turned.readings import DEVICES
from trueloop.probing.calibration import BallCalibration
from trueloop.probing.cmm_plan import CmmApproach, CmmTouch, cmm_moves, cmm_plan
from trueloop.probing.plan import MARGIN_MM, GaugingPoints, Spacing, equally_spaced
from trueloop.probing.probe_match import MatchedTouches, match_touches, renamed
from trueloop.probing.probe_plan import ProbePlan, probe_plan
from trueloop.probing.stylus import Obstacle, stock_obstacle
from trueloop.probing.trials import Trials, match_trials, repeated
from trueloop.turned.touches.touches import Gauging, error_vectors

REPORTING_SURFACES: Final = ("renishaw",)
"""Controls whose probing macros take the ball off by themselves."""
CLEAR_OF_ENDS: Final = 1.0
"""The first and last point of a feature lie this many ball radii from what the nose reaches of it."""


@dataclass(frozen=True)
class JobPoints:
    """Where a job's part is to be touched, the points' names, and the files they were read from beside the job's."""

    points: GaugingPoints
    names: list[str]
    files: tuple[Path, ...] = ()

    def chosen(self, positions: Sequence[int]) -> "JobPoints":
        """Returns some of the points, by their positions."""
        k, at = list(positions), self.points
        points = GaugingPoints(at.feature_index[k], at.arc_length_mm[k], at.nominal_mm[k], at.outward_normal[k])
        return JobPoints(points, [self.names[i] for i in k], self.files)


@dataclass(frozen=True)
class ProbingJob:
    """A job's part, its probe, the plan that touches it, the probe's file; `files` are all that was read."""

    part: ReadPart
    probe: ReadProbe
    plan: ProbePlan
    probe_file: Path
    files: tuple[Path, ...]


def read_probing(path: Path, chosen: JobPoints | None = None, trials: int = 1) -> ProbingJob:
    """Reads a job and its probe file, places the points and plans the ways. Raises JOB, GEO, TCH and PRB errors.

    `chosen` points take the place of the job's. `trials`: the tour of all points is made so many times.
    """
    job, part = read_turned_job(path), read_part(path)
    probe_file, probe, obstacle = _probe(path, job, part)
    with in_file(path):
        margin_mm = CLEAR_OF_ENDS * probe.stylus.ball_radius_mm
        points = points_of_job(path, job, part, margin_mm) if chosen is None else chosen
        plan = probe_plan(part.profile, points.points, obstacle, probe.stylus, probe.approach, points.names)
        if trials > 1:
            ends = points.chosen([-1, 0])
            back = probe_plan(part.profile, ends.points, obstacle, probe.stylus, probe.approach, ends.names)
            plan = repeated(plan, back, trials)
    return ProbingJob(part, probe, plan, probe_file, (*part.files, probe_file, *points.files))


def _probe(path: Path, job: Job, part: ReadPart) -> tuple[Path, ReadProbe, Obstacle]:
    """Returns the job's probe with its file, and what it must not touch. Raises PRB errors."""
    if job.gauging.probe is None:
        raise TrueloopError(
            Code.PRB_FILE,
            "the job names no probe: `gauging.probe` is missing",
            hint="write a probe file (docs/probing.md) and name it in the job's table [gauging]",
            place=Place(str(path)),
        )
    probe_file = path.parent / job.gauging.probe
    probe = read_probe(probe_file, job.own_programs.semifinish_allowance_mm or 0.0)
    return probe_file, probe, stock_obstacle(part.profile, probe.approach.allowance_mm, probe.bar_radius_mm)


def reached(path: Path, touches: Sequence[CmmTouch]) -> tuple[CmmTouch, ...]:
    """Returns the places that ball and stem of the job's probe reach. Raises as `read_probing`."""
    job, part = read_turned_job(path), read_part(path)
    _, probe, obstacle = _probe(path, job, part)

    def reach(touch: CmmTouch) -> bool:
        try:
            points = points_at(part.profile, [touch])
            probe_plan(part.profile, points.points, obstacle, probe.stylus, probe.approach, points.names)
        except TrueloopError as error:
            if error.code not in (Code.PRB_BALL, Code.PRB_REACH):
                raise
            return False
        return True

    return tuple(one for one in touches if reach(one))


def read_listed(path: Path, points: Path) -> ProbingJob:
    """Reads a job and its probe with a list of points in place of the job's. Raises as `read_probing`, TCH errors."""
    with in_file(points):
        chosen = points_at(read_part(path).profile, read_cmm_plan(points))
    return read_probing(path, replace(chosen, files=(points,)))


def read_logged_touches(probing: ProbingJob, log: Path, control: str) -> MatchedTouches:
    """Converts a log's touches to part errors of the job's plan. Raises PRB errors that name the log and its line."""
    places, lines, surfaces = _logged(probing, log, control)
    with in_file(log if surfaces or probing.probe.calibration is not None else probing.probe_file):
        matched = match_touches(probing.plan, places, lines, probing.probe.calibration, reports_surface=surfaces)
    return MatchedTouches(matched.touches, renamed(matched.findings, str(log)))


def read_logged_trials(probing: ProbingJob, log: Path, control: str) -> Trials:
    """Converts the log of repeated trials to part errors. Raises PRB errors that name the log and its line.

    A probe that is not calibrated is taken to have the ball's own radius: that shifts all trials alike.
    """
    places, lines, surfaces = _logged(probing, log, control)
    calibration = probing.probe.calibration or BallCalibration(probing.probe.stylus.ball_radius_mm)
    with in_file(log):
        return match_trials(probing.plan, places, lines, calibration, reports_surface=surfaces)


def _logged(probing: ProbingJob, log: Path, control: str) -> tuple[list[Point], list[int], bool]:
    """Returns the logged positions, their lines, and whether the control takes the ball off."""
    program = probing.probe.program
    logged = read_probe_log(log, control, inch=program.unit == "inch", diameter=program.x_is == "diameter")
    places, lines = [touch.position_mm for touch in logged], [touch.line for touch in logged]
    return places, lines, control in REPORTING_SURFACES


def inspection_of_log(log: Path, touches: Sequence[Touch]) -> Inspection:
    """Makes an inspection by the machine's own probe of a log's touches; the job names the part."""
    sha256 = sha256_of(log.read_bytes())
    return Inspection(Part(PartType("")), "touches", sha256, len(touches), tuple(touches), device=DEVICES["machine"])


def points_of_job(path: Path, job: Job, part: ReadPart, margin_mm: float) -> JobPoints:
    """Returns the points by the job's counts and spacing, or, without any, those of its touches. Raises TCH errors.

    `margin_mm` is what stays free between the first and last point of a feature and the ends of what the nose reaches.
    """
    profile = part.profile
    if job.gauging.points or job.gauging.spacing_mm is not None:
        reachable = part.centre_path.reachable_mm
        points = equally_spaced(profile, _spacings(job, profile, reachable, margin_mm), reachable)
        return JobPoints(points, [str(k + 1) for k in range(len(points.arc_length_mm))])
    if job.gauging.touches is None:
        raise TrueloopError(
            Code.TCH_PLAN,
            "the job names 0 points to touch: it has readings of gauges alone",
            hint="say how many with `gauging.points`, or how far apart with `gauging.spacing_mm`",
        )
    file = path.parent / job.gauging.touches
    with in_file(file):
        vectors = error_vectors(profile, read_touches(file), Gauging())
    points = GaugingPoints(vectors.feature_index, vectors.arc_length_mm, vectors.nominal_mm, vectors.outward_normal)
    return JobPoints(points, list(vectors.point), (file,))


def points_at(profile: Profile, touches: Sequence[CmmTouch]) -> JobPoints:
    """Returns places on features of a profile as points to probe. Raises TCH-PLAN for a feature it does not have."""
    for one in touches:
        if one.feature not in profile.names:
            raise TrueloopError(
                Code.TCH_PLAN,
                f"point {one.name!r} is on {one.feature!r}, which is not one of the {len(profile.names)} features",
                hint=f"the part's features are: {', '.join(profile.names)}",
            )
    index = np.array([profile.names.index(one.feature) for one in touches], dtype=np.intp)
    pairs = zip(index.tolist(), touches, strict=True)
    along = np.array([float(profile.features[i].locate(one.place_mm)[0]) for i, one in pairs])
    places, normals = (np.array([getattr(one, name) for one in touches]) for name in ("place_mm", "normal"))
    return JobPoints(GaugingPoints(index, along, places, normals), [one.name for one in touches])


def _spacings(job: Job, profile: Profile, reachable_mm: Array, margin_mm: float) -> dict[str, Spacing]:
    unknown = [name for name in job.gauging.points if name not in profile.names]
    spacings = {name: Spacing(1) for name in unknown}  # refused, with its name, by `equally_spaced`
    for name, (low, high) in zip(profile.names, reachable_mm, strict=True):
        count = job.gauging.points.get(name)
        if count is None and job.gauging.spacing_mm is not None:
            room = float(high - low) - 2 * margin_mm
            count = max(1, math.ceil(room / job.gauging.spacing_mm) + 1) if room > 0 else None
        if count is not None:
            spacings[name] = Spacing(count, margin_mm, margin_mm)
    return spacings


AROUND_DEG = (0.0, 90.0, 180.0, 270.0)
"""Where a circle is touched, from the first angle of the plan on: one touch more than centre and diameter need."""


@dataclass(frozen=True)
class MeasuringJob:
    """A job's part, its points for a measuring machine, and what its drawing asks for.

    `allowance_mm` is what the semi-finish cut leaves on, the most of all set-ups. `files` are all that was read, and
    the job's programs.
    """

    part: ReadPart
    touches: tuple[CmmTouch, ...]
    characteristics: tuple[Characteristic, ...]
    angles_deg: tuple[float, ...]
    allowance_mm: float
    files: tuple[Path, ...]


def read_measuring(path: Path, angles_deg: Sequence[float] = (0.0,), *, diameters: bool = False) -> MeasuringJob:
    """Reads the points of `gauging.points` and `gauging.spacing_mm`, else those of the job's touches.

    They stay clear of a feature's ends by the ball's radius where the job names a probe, else by 2.54 mm
    (`probing.plan.MARGIN_MM`). Raises JOB, GEO, TCH, TOL and PRB errors.
    """
    located = locate_turned_job(path)
    job, part = located.model, read_part(path)
    probe_file = None if job.gauging.probe is None else path.parent / job.gauging.probe
    margin_mm = MARGIN_MM if probe_file is None else read_probe(probe_file, 0.0).stylus.ball_radius_mm
    with in_file(path):
        given = points_of_job(path, job, part, margin_mm)
        touches = cmm_plan(part.profile, given.points, given.names, angles_deg, diameters=diameters)
    tables = job.every_programs
    named = [name for one in tables for name in (one.finish, one.semifinish) if name is not None]
    programs = [path.parent / name for name in named]
    probe_files = [] if probe_file is None else [probe_file]
    return MeasuringJob(
        part,
        touches,
        characteristics_of(located, part.profile),
        tuple(angles_deg),
        max(one.semifinish_allowance_mm or 0.0 for one in tables),
        (*part.files, *probe_files, *given.files, *programs),
    )


def program_of(measuring: MeasuringJob, approach: CmmApproach, source: str) -> str:
    """Writes the DMIS program of all points, half plane by half plane, and of the diameters that the drawing requests.

    Raises PRB and TCH errors for what cannot be reached.
    """
    profile = measuring.part.profile
    obstacle = stock_obstacle(profile, approach.allowance_mm)
    angles = list(dict.fromkeys(touch.angle_deg for touch in measuring.touches))
    touches = sorted(measuring.touches, key=lambda touch: angles.index(touch.angle_deg))
    asked = [(one, _around(one, profile, measuring.angles_deg[0])) for one in measuring.characteristics]
    circles = [(one, around) for one, around in asked if around]
    moves = cmm_moves([*touches, *(touch for _, around in circles for touch in around)], obstacle, approach)
    points, rest = moves[: len(touches)], iter(moves[len(touches) :])
    measured = [
        MeasuredCircle(one, around[0].place_mm[1], tuple(next(rest) for _ in around)) for one, around in circles
    ]
    return dmis_program(measuring.part.name, points, measured, approach, source)


def _around(asked: Characteristic, profile: Profile, from_deg: float) -> tuple[CmmTouch, ...]:
    """The touches of a diameter on a cylinder or at one place of a cone; none of what is measured otherwise."""
    feature = profile.features[profile.names.index(asked.feature)]
    if asked.quantity is not Quantity.DIAMETER or not isinstance(feature, Line):
        return ()
    (x_start, z_start), (x_end, z_end) = feature.start_mm, feature.end_mm
    if z_start == z_end or (asked.at_z_mm is None and x_start != x_end):
        return ()
    z = (z_start + z_end) / 2 if asked.at_z_mm is None else asked.at_z_mm
    along = feature.length_mm * (z - z_start) / (z_end - z_start)
    place, normal = feature.point_mm(along), feature.outward_normal(along)
    return tuple(
        CmmTouch(
            asked.name,
            asked.feature,
            (float(place[0]), float(place[1])),
            (float(normal[0]), float(normal[1])),
            (from_deg + turn) % 360.0,
        )
        for turn in AROUND_DEG
    )
