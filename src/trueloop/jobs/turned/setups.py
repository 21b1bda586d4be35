"""The set-ups of a job with what each cuts: a job without set-ups has one, of one tool one with one edge."""

from collections.abc import Mapping
from dataclasses import dataclass

from trueloop.errors import Code
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.cuts import InSetups, Setup, in_setups
from trueloop.nc.program.called import Called


def decided_of(files: JobFiles, profile: Profile) -> Mapping[str, Called | None]:
    """Returns by feature the edge that the job names, None where it is to be left alone.

    Raises JOB-KEY for a feature that the part has not.
    """
    for name in files.job.feature:
        if name not in profile.names:
            with files.located.at("feature", name):
                raise Code.JOB_KEY.refusal(
                    f"'feature.{name}' is not one of the {len(profile.names)} features of the part",
                    hint=f"the part's features are: {', '.join(profile.names)}",
                    values={"key": f"feature.{name}"},
                )
    return {name: cut.called for name, cut in files.job.feature.items() if cut.tool is not None}


@dataclass(frozen=True)
class ReadSetups:
    """A part with its set-ups: `profile` in the part's frame, and what each set-up cuts of it. `files` is the job by
    set-up, as if that were its only one.
    """

    profile: Profile
    found: InSetups
    files: tuple[JobFiles, ...]


def read_setups(files: JobFiles) -> ReadSetups:
    """Reads every set-up of a job with what it cuts: its touches need not exist yet.

    Raises JOB, GEO, NC and SET errors, but not those of single features.
    """
    frames = files.frames or (PART,)
    of_setups = files.of_setups
    programs = [one.finish_program() for one in of_setups]
    profile = files.profile(programs[0])
    decided_of(files, profile)
    setups = [
        Setup(frame, program, one.run, one.edges, decided_of(one, profile), None if one.edges else one.nose_radius_mm)
        for frame, one, program in zip(frames, of_setups, programs, strict=True)
    ]
    given = files.job.feature
    decided = {
        name: None if cut.left_alone else cut.setup for name, cut in given.items() if cut.setup or cut.left_alone
    }
    return ReadSetups(profile, in_setups(profile, setups, decided), of_setups)
