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
from trueloop.formats.measurements.touches_csv import read_planned, read_probe_log
from trueloop.geometry.feature import Line, Point
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.inputs import read_setups
from trueloop.jobs.turned.job import ReadPart, read_part
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.readings import DEVICES
from trueloop.loops.turned.share import touch_in
from trueloop.probing.calibration import BallCalibration, Obstacle, stock_obstacle, whole_obstacle
from trueloop.probing.cmm_plan import CmmApproach, CmmTouch, cmm_moves, cmm_plan
from trueloop.probing.probe_match import MatchedTouches, Trials, match_touches, match_trials, renamed, repeated
from trueloop.probing.probe_plan import MARGIN_MM, GaugingPoints, ProbePlan, Spacing, equally_spaced, probe_plan
from trueloop.turned.touches.touches import Gauging, error_vectors, in_order

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
class ProbedPart:
    """The surface that a probe touches in one clamping: the contour that one set-up cuts, in the frame of its program;
    of a job without set-ups the whole profile.

    `features` are what it cuts, by name; `whole` is the part's own profile; `nose_radius_mm` has to fit everywhere.
    `allowance_mm` is what the semi-finish cut leaves on. `bar_radius_mm`: how thick the part is behind that contour,
    where the probe's file does not state it.
    """

    name: str
    whole: Profile
    profile: Profile
    features: tuple[str, ...]
    frame: SetupFrame
    allowance_mm: float
    nose_radius_mm: float
    bar_radius_mm: float | None
    files: tuple[Path, ...]

    @property
    def reachable_mm(self) -> Array:
        """Returns the arc lengths from and to which the nose reaches every feature, (n, 2)."""
        return nose_centre_path(self.profile, self.nose_radius_mm).reachable_mm

    def of_part(self, touches: Sequence[Touch]) -> tuple[Touch, ...]:
        """Returns touches as the part's frame has them, in order along it."""
        if not self.frame.name:
            return tuple(touches)
        return tuple(in_order(self.whole, [touch_in(self.frame.back, touch) for touch in touches]))


def probed_part(path: Path, setup: str | None = None) -> ProbedPart:
    """Reads what is probed of a job's part, in the set-up of this name where it has several.

    Raises JOB, GEO, NC and SET errors, JOB-SETUPS where the job has set-ups and none of them is named, or another.
    """
    job = read_turned_job(path)
    names = [table.name for table in job.setups]
    if not names and setup is None:
        return _whole(job, read_part(path))
    if setup not in names:
        stated = "none is named" if setup is None else f"{setup!r} is none of them"
        raise Code.JOB_SETUPS.refusal(
            f"the job has {len(names)} set-ups ({', '.join(names) or 'no table [[setups]]'}), and {stated}",
            hint="a probe reaches what is cut in one clamping: name it, `--setup NAME`, and touch the others in theirs"
            if names
            else "leave `--setup` out",
            place=Place(str(path)),
            values={"setups": list(names)},
        )
    files = JobFiles.of(path)
    read = read_setups(files)
    read.found.require_plain()
    k = names.index(setup)
    of, one = read.found.setups[k], read.files[k]
    own = [index for index, name in enumerate(of.profile.names) if name in of.features]
    first, last = own[0], own[-1]
    features = of.profile.features
    profile = replace(of.profile, features=features[first : last + 1], junctions=of.profile.junctions[first:last])
    behind = max((max(f.start_mm[0], f.end_mm[0]) for f in features[:first]), default=0.0)
    bar_mm = max(behind, profile.features[0].start_mm[0])
    nose_mm, allowance_mm = min(edge.nose_radius_mm for edge in one.edges), _allowance_mm(one.job)
    frame, read_files = of.setup.frame, files.sources.files
    return ProbedPart(
        name=job.part.name,
        whole=read.profile,
        profile=profile,
        features=of.features,
        frame=frame,
        allowance_mm=allowance_mm,
        nose_radius_mm=nose_mm,
        bar_radius_mm=bar_mm,
        files=read_files,
    )


def _whole(job: Job, part: ReadPart) -> ProbedPart:
    whole = part.profile
    return ProbedPart(
        name=part.name,
        whole=whole,
        profile=whole,
        features=whole.names,
        frame=PART,
        allowance_mm=_allowance_mm(job),
        nose_radius_mm=part.nose_radius_mm,
        bar_radius_mm=None,
        files=part.files,
    )


def _allowance_mm(job: Job) -> float:
    """Returns what the semi-finish cut leaves on, the most of all set-ups."""
    return max(program.semifinish_allowance_mm or 0.0 for program in job.every_programs)


@dataclass(frozen=True)
class ProbingJob:
    """A job's part as it is probed, its probe, the plan that touches it, the probe's file; `files` were read."""

    part: ProbedPart
    probe: ReadProbe
    plan: ProbePlan
    probe_file: Path
    files: tuple[Path, ...]


def read_probing(
    path: Path,
    chosen: Sequence[CmmTouch] | None = None,
    setup: str | None = None,
    file: Path | None = None,
    trials: int = 1,
) -> ProbingJob:
    """Reads a job and its probe file, places the points and plans the ways, of the set-up of this name. Raises JOB,
    GEO, SET, TCH and PRB errors.

    `chosen` points of the part, read from `file`, take the place of the job's. `trials`: the tour of all points is made
    so many times.
    """
    job, part = read_turned_job(path), probed_part(path, setup)
    probe_file, probe, obstacle = _probe(path, job, part)
    with in_file(file or path):
        margin_mm = CLEAR_OF_ENDS * probe.stylus.ball_radius_mm
        points = points_of_job(path, job, part, margin_mm) if chosen is None else points_at(part, chosen)
    with in_file(path):
        plan = probe_plan(part.profile, points.points, obstacle, probe.stylus, probe.approach, points.names)
        if trials > 1:
            ends = points.chosen([-1, 0])
            back = probe_plan(part.profile, ends.points, obstacle, probe.stylus, probe.approach, ends.names)
            plan = repeated(plan, back, trials)
    listed = () if file is None else (file,)
    return ProbingJob(part, probe, plan, probe_file, (*part.files, probe_file, *points.files, *listed))


def _probe(path: Path, job: Job, part: ProbedPart) -> tuple[Path, ReadProbe, Obstacle]:
    """Returns the job's probe with its file, and what it must not touch. Raises PRB errors."""
    if job.gauging.probe is None:
        raise Code.PRB_FILE.refusal(
            "the job names no probe: `gauging.probe` is missing",
            hint="write a probe file (docs/probing.md) and name it in the job's table [gauging]",
            place=Place(str(path)),
        )
    probe_file = path.parent / job.gauging.probe
    probe = read_probe(probe_file, part.allowance_mm)
    bar_mm = part.bar_radius_mm if probe.bar_radius_mm is None else probe.bar_radius_mm
    return probe_file, probe, stock_obstacle(part.profile, probe.approach.allowance_mm, bar_mm)


def reached(path: Path, touches: Sequence[CmmTouch], setup: str | None = None) -> tuple[CmmTouch, ...]:
    """Returns the places that ball and stem of the job's probe reach. Raises as `read_probing`."""
    job, part = read_turned_job(path), probed_part(path, setup)
    _, probe, obstacle = _probe(path, job, part)

    def reach(touch: CmmTouch) -> bool:
        if touch.feature not in part.features:
            return False
        points = points_at(part, [touch])
        try:
            probe_plan(part.profile, points.points, obstacle, probe.stylus, probe.approach, points.names)
        except TrueloopError as error:
            if error.code not in (Code.PRB_BALL, Code.PRB_REACH):
                raise
            return False
        return True

    return tuple(cmm_touch for cmm_touch in touches if reach(cmm_touch))


def read_listed(path: Path, points: Path, setup: str | None = None) -> ProbingJob:
    """Reads a job and its probe with a list of points in place of the job's. Raises as `read_probing`, TCH errors."""
    with in_file(points):
        listed = read_cmm_plan(points)
    return read_probing(path, listed, setup, points)


def by_setup(path: Path, touches: Sequence[CmmTouch]) -> dict[str, list[CmmTouch]]:
    """Returns places of a job's part by the set-up that cuts them, "": none. Raises JOB, GEO, NC and SET errors."""
    names = [setup.name for setup in read_turned_job(path).setups]
    if not names:
        return {"": list(touches)}
    own = {name: probed_part(path, name).features for name in names}
    found = {name: [touch for touch in touches if touch.feature in own[name]] for name in names}
    return {name: of_it for name, of_it in found.items() if of_it}


def read_logged_touches(probing: ProbingJob, log: Path, control: str) -> MatchedTouches:
    """Converts a log's touches to part errors of the job's plan, in the part's frame. Raises PRB errors."""
    places, lines, surfaces = _logged(probing, log, control)
    with in_file(log if surfaces or probing.probe.calibration is not None else probing.probe_file):
        matched = match_touches(probing.plan, places, lines, probing.probe.calibration, reports_surface=surfaces)
    return MatchedTouches(probing.part.of_part(matched.touches), renamed(matched.findings, str(log)))


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


def points_of_job(path: Path, job: Job, part: ProbedPart, margin_mm: float) -> JobPoints:
    """Returns the points by the job's counts and spacing, or, without any, those of its touches. Raises TCH errors.

    `margin_mm` is what stays free between the first and last point of a feature and the ends of what the nose reaches.
    """
    profile = part.profile
    if job.gauging.points or job.gauging.spacing_mm is not None:
        reachable = part.reachable_mm
        points = equally_spaced(profile, _spacings(job, part, reachable, margin_mm), reachable)
        before = f"{part.frame.name}-" if part.frame.name else ""
        return JobPoints(points, [f"{before}{k + 1}" for k in range(len(points.arc_length_mm))])
    files = [path.parent / name for name in job.gauging.touches_files]
    if not files:
        raise Code.TCH_PLAN.refusal(
            "the job names 0 points to touch: it has readings of gauges alone",
            hint="say how many with `gauging.points`, or how far apart with `gauging.spacing_mm`",
        )
    touches: list[Touch] = []
    for file in files:
        with in_file(file):
            touches += read_planned(file)
    with in_file(files[0]):
        ordered = touches if len(files) == 1 else in_order(part.whole, touches)
        vectors = error_vectors(part.whole, ordered, Gauging())
    names, places = part.whole.names, vectors.nominal_mm.tolist()
    rows = zip(vectors.point, vectors.feature_index.tolist(), places, vectors.outward_normal.tolist(), strict=True)
    listed = [CmmTouch(point, names[i], (x, z), (n_x, n_z)) for point, i, (x, z), (n_x, n_z) in rows]
    return replace(points_at(part, listed), files=tuple(files))


def points_at(part: ProbedPart, touches: Sequence[CmmTouch]) -> JobPoints:
    """Returns places on a part's contour to probe. Raises TCH-PLAN: no such feature, or none on the contour."""
    for touch in touches:
        if touch.feature not in part.whole.names:
            raise Code.TCH_PLAN.refusal(
                f"point {touch.name!r} is on {touch.feature!r}, which is not one of the {len(part.whole.names)} "
                "features",
                hint=f"the part's features are: {', '.join(part.whole.names)}",
            )
    profile, frame = part.profile, part.frame
    own = [touch for touch in touches if touch.feature in part.features]
    if not own:
        raise Code.TCH_PLAN.refusal(
            f"0 of {len(touches)} points are on what set-up {frame.name!r} cuts",
            hint=f"it cuts: {', '.join(part.features)}",
        )
    index = np.array([profile.names.index(cmm_touch.feature) for cmm_touch in own], dtype=np.intp)
    places = frame.points([cmm_touch.place_mm for cmm_touch in own])
    normals = frame.directions([cmm_touch.normal for cmm_touch in own])
    along = [float(profile.features[i].locate(place)[0]) for i, place in zip(index.tolist(), places, strict=True)]
    order = np.lexsort((np.array(along), index)) if frame.backwards else np.arange(len(own))
    points = GaugingPoints(index[order], np.array(along)[order], places[order], normals[order])
    return JobPoints(points, [own[k].name for k in order.tolist()])


def _spacings(job: Job, part: ProbedPart, reachable_mm: Array, margin_mm: float) -> dict[str, Spacing]:
    profile = part.profile
    unknown = [name for name in job.gauging.points if name not in part.whole.names]
    spacings = {name: Spacing(1) for name in unknown}  # refused, with its name, by `equally_spaced`
    for name, (low, high) in zip(profile.names, reachable_mm, strict=True):
        if name not in part.features:
            continue
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
        given = points_of_job(path, job, _whole(job, part), margin_mm)
        touches = cmm_plan(part.profile, given.points, given.names, angles_deg, diameters=diameters)
    tables = job.every_programs
    named = [name for table in tables for name in (table.finish, table.semifinish) if name is not None]
    programs = [path.parent / name for name in named]
    probe_files = [] if probe_file is None else [probe_file]
    return MeasuringJob(
        part=part,
        touches=touches,
        characteristics=characteristics_of(located, part.profile),
        angles_deg=tuple(angles_deg),
        allowance_mm=_allowance_mm(job),
        files=(*part.files, *probe_files, *given.files, *programs),
    )


def program_of(measuring: MeasuringJob, approach: CmmApproach, source: str) -> str:
    """Writes the DMIS program of all points and the drawing's diameters. Raises PRB and TCH errors: out of reach."""
    profile = measuring.part.profile
    obstacle = whole_obstacle(profile, approach.allowance_mm)
    angles = list(dict.fromkeys(touch.angle_deg for touch in measuring.touches))
    touches = sorted(measuring.touches, key=lambda touch: angles.index(touch.angle_deg))
    asked = [
        (characteristic, _around(characteristic, profile, measuring.angles_deg[0]))
        for characteristic in measuring.characteristics
    ]
    circles = [(characteristic, around) for characteristic, around in asked if around]
    moves = cmm_moves([*touches, *(touch for _, around in circles for touch in around)], obstacle, approach)
    points, rest = moves[: len(touches)], iter(moves[len(touches) :])
    measured = [
        MeasuredCircle(characteristic, around[0].place_mm[1], tuple(next(rest) for _ in around))
        for characteristic, around in circles
    ]
    return dmis_program(measuring.part.name, points, measured, approach, source)


def _around(characteristic: Characteristic, profile: Profile, from_deg: float) -> tuple[CmmTouch, ...]:
    """The touches of a diameter on a cylinder or at one place of a cone; none of what is measured otherwise."""
    feature = profile.features[profile.names.index(characteristic.feature)]
    if characteristic.quantity is not Quantity.DIAMETER or not isinstance(feature, Line):
        return ()
    (x_start, z_start), (x_end, z_end) = feature.start_mm, feature.end_mm
    if z_start == z_end or (characteristic.at_z_mm is None and x_start != x_end):
        return ()
    z = (z_start + z_end) / 2 if characteristic.at_z_mm is None else characteristic.at_z_mm
    along = feature.length_mm * (z - z_start) / (z_end - z_start)
    place, normal = feature.point_mm(along), feature.outward_normal(along)
    return tuple(
        CmmTouch(
            characteristic.name,
            characteristic.feature,
            (float(place[0]), float(place[1])),
            (float(normal[0]), float(normal[1])),
            (from_deg + turn) % 360.0,
        )
        for turn in AROUND_DEG
    )
