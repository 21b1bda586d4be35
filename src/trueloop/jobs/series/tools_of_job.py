"""The tools of a job: what each cuts, and which series are sizes of that. Touches need not exist."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from trueloop.domain.characteristic import Characteristic
from trueloop.factory.book import Book
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.shares import shares_of
from trueloop.loops.post_process.by_tool import JobTool, characteristic_on
from trueloop.loops.turned.commanded import commanded
from trueloop.nc.match.own_contour import OwnContour


def tools_of_job(path: Path, book: Book) -> tuple[JobTool, ...]:
    """Each tool of a job, or its only one, with its contour, its moves and the series of sizes of it alone.

    A size between features of two edges is of neither. Raises JOB, GEO and NC errors.
    """
    files = JobFiles.of(path)
    program = files.finish_program()
    profile = files.profile(program)
    asked = _asked(files, profile, book)
    x_is = files.job.own_programs.offset_x_is
    x_is_diameter = None if x_is is None else x_is == "diameter"
    if not files.job.tools:
        matched = commanded(program, None, profile, files.nose_radius_mm, 0.0, files.run)
        tool = files.tool
        return (JobTool(profile, program, matched, asked, tool.number, x_is_diameter, tool.table_edge),)
    found = []
    for share in shares_of(files):
        own, called = share.own, share.own.edge.called
        run = replace(share.files.run, called=called)
        matched = commanded(program, None, own.profile, own.edge.nose_radius_mm, 0.0, run)
        mine = _own_asked(asked, profile, own)
        found.append(JobTool(own.profile, program, matched, mine, called.number, x_is_diameter, called.edge))
    return tuple(found)


def _asked(files: JobFiles, profile: Profile, book: Book) -> Mapping[str, Characteristic]:
    """The part's characteristics by name: as the job has them, else as the inspections name features of it."""
    stated = {one.name: one for one in characteristics_of(files.located, profile)}
    series = [one.series.characteristic for one in book.tracked]
    named = {one.name: stated.get(one.name) or characteristic_on(profile, one) for one in series}
    return {name: one for name, one in named.items() if one is not None}


def _own_asked(asked: Mapping[str, Characteristic], profile: Profile, own: OwnContour) -> dict[str, Characteristic]:
    """Those of an edge's features alone, by their names on its contour."""
    names = {profile.names[i]: own.profile.names[k] for k, parts in enumerate(own.parts) for i in parts}
    return {
        name: replace(one, feature=names[one.feature], other=names.get(one.other, ""))
        for name, one in asked.items()
        if one.feature in names and (not one.other or one.other in names)
    }
