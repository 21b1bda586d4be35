"""From a job to what a coordinate measuring machine is to touch."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import in_file
from trueloop.formats.inspections.dmis.program import MeasuredCircle, dmis_program
from trueloop.formats.jobs.job import locate_turned_job
from trueloop.formats.jobs.probe_toml import read_probe
from trueloop.geometry.feature import Line
from trueloop.geometry.profile import Profile
from trueloop.jobs.measure.probing import points_of_job
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.job import ReadPart, read_part
from trueloop.probing.cmm_moves import CmmApproach, cmm_moves
from trueloop.probing.cmm_plan import CmmTouch, cmm_plan
from trueloop.probing.obstacle import stock_obstacle
from trueloop.probing.plan import MARGIN_MM

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
