"""From a job to what a coordinate measuring machine is to touch."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.errors import in_file
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.jobs.probe_toml import read_probe
from trueloop.jobs.probing import points_of_job
from trueloop.jobs.turned import ReadPart, read_part
from trueloop.probing.cmm_plan import CmmPlan, cmm_plan
from trueloop.probing.plan import MARGIN_MM


@dataclass(frozen=True)
class MeasuringJob:
    """A job's part and its points for a measuring machine; `files` are all that was read, and its programs."""

    part: ReadPart
    plan: CmmPlan
    files: tuple[Path, ...]


def read_measuring(path: Path, angles_deg: Sequence[float] = (0.0,), *, diameters: bool = False) -> MeasuringJob:
    """The points of `gauging.points` and `gauging.spacing_mm`, else those of the job's touches.

    They stay clear of a feature's ends by the ball's radius where the job names a probe, else by 2.54 mm
    (`probing.plan.MARGIN_MM`). Raises JOB, GEO, TCH and PRB errors.
    """
    job, part = read_turned_job(path), read_part(path)
    probe_file = None if job.gauging.probe is None else path.parent / job.gauging.probe
    margin_mm = MARGIN_MM if probe_file is None else read_probe(probe_file, 0.0).stylus.ball_radius_mm
    with in_file(path):
        given = points_of_job(path, job, part, margin_mm)
        plan = cmm_plan(part.profile, given.points, given.names, angles_deg, diameters=diameters)
    programs = [path.parent / named for named in (job.programs.finish, job.programs.semifinish) if named is not None]
    probe_files = [] if probe_file is None else [probe_file]
    return MeasuringJob(part, plan, (*part.files, *probe_files, *given.files, *programs))
