"""A job of several edges, in one set-up or in several, as jobs of one edge each: what the store keeps of a part."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from trueloop.geometry.setup_frame import SetupFrame
from trueloop.jobs.turned.job import read_setups
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.of_edge import name_of_share
from trueloop.nc.match.own_contour import OwnContour


@dataclass(frozen=True)
class ShareOfEdge:
    """One edge: the job as if it were its only one, of its own part, and what it cuts, in the frame of `setup`; None:
    the part's.
    """

    files: JobFiles
    own: OwnContour
    setup: SetupFrame | None


def shares_of(files: JobFiles) -> list[ShareOfEdge]:
    """Returns every edge that cuts, in the job's order. Raises NC errors, and SET errors for several set-ups."""
    read = read_setups(files)
    read.found.require_plain()
    pairs = zip(read.found.setups, read.files, strict=True)
    return [share for of, one in pairs for share in _shares(one, of.contours, of.setup.frame)]


def _shares(files: JobFiles, contours: Sequence[OwnContour | None], frame: SetupFrame) -> list[ShareOfEdge]:
    tables = {tool.called: tool for tool in files.job.tools}
    found = []
    setup = frame if frame.name else None
    for own in filter(None, contours):
        of_tool = files.with_tool(tables[own.edge.called])
        part = of_tool.job.part.model_copy(update={"name": name_of_share(of_tool.job.part.name, own, setup)})
        located = replace(of_tool.located, model=of_tool.job.model_copy(update={"part": part}))
        found.append(ShareOfEdge(replace(of_tool, located=located), own, setup))
    return found
