"""One of several edges as the store has it: its share of a part is a part of its own, as of a job of that edge alone.

Its part type is named after the part and the edge, so that cuts, inspections and corrections of two edges never mix,
and what an edge learns comes from what it cuts.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.domain.part import PartType
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.formats.option_tables import options_from
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.job import decided_of
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.edges import contours_of
from trueloop.nc.match.own_contour import OwnContour
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.touches.touches import Gauging


def part_type_of_edge(part: PartType, own: OwnContour) -> PartType:
    """`grooved, T5 (left corner)`."""
    return replace(part, name=f"{part.name}, {own.edge.words}")


def inspection_of_edge(
    one: Inspection, profile: Profile, own: OwnContour, names: Mapping[str, str] | None = None
) -> Inspection:
    """What was measured of the edge's own features, by their names on its contour; `profile` is the whole part's,
    `names` are its names of features by those in the file.

    What lies on no feature, and a length between features of two edges, is none of it.
    """
    mine = [index for parts in own.parts for index in parts]
    matched = match_inspection(profile, one, names)

    def name(index: int | None) -> str:
        return "" if index is None else own.profile.names[own.index_of(index)]

    touches = [replace(m.touch, feature=name(m.feature_index)) for m in matched.touches if m.feature_index in mine]
    readings = [
        replace(m.reading, feature=name(m.feature_index), other=name(m.other_index))
        for m in matched.readings
        if m.feature_index in mine and (m.other_index is None or m.other_index in mine)
    ]
    values: tuple[Touch | Reading, ...] = (*touches, *readings)
    kind: Literal["touches", "readings"] = "touches" if touches else "readings"
    return replace(one, measured=kind, values=values, count=len(values))


def stored_inputs(inputs: Inputs, profile: Profile, own: OwnContour) -> Inputs:
    """An edge's inputs as those of its own part; `profile` is the whole part's."""
    part = part_type_of_edge(inputs.part, own)
    mine = (inspection_of_edge(one, profile, own) for one in inputs.inspections)
    inspections = tuple(replace(one, part=replace(one.part, part_type=part)) for one in mine if one.values)
    edge, number = inputs.edge, own.edge.called.edge
    if edge is not None and number > 1:
        edge = replace(edge, corner=f"{edge.corner} D{number}".strip())
    return replace(inputs, part=part, inspections=inspections, edge=edge)


def files_of_edges(files: JobFiles) -> list[tuple[JobFiles, OwnContour]]:
    """For every edge that cuts: the job as if it were the only one, of its own part. Raises NC errors."""
    program = files.finish_program()
    profile = files.profile(program)
    contours = contours_of(program, files.run, profile, files.edges, decided_of(files, profile))
    tables = {tool.called: tool for tool in files.job.tools}
    return [(_own_files(files, tables[own.edge.called], own), own) for own in contours]


def _own_files(files: JobFiles, tool: ToolsTable, own: OwnContour) -> JobFiles:
    of_tool = files.with_tool(tool)
    job = of_tool.job
    part = job.part.model_copy(update={"name": f"{job.part.name}, {own.edge.words}"})
    return replace(of_tool, located=replace(of_tool.located, model=job.model_copy(update={"part": part})))


def require_kept_apart(files: JobFiles) -> None:
    """Raises JOB-TOOLS for a part whose z is taken from a touch: it is of one edge, and the others' z hang on it."""
    reference = options_from(Gauging, files.job).z_reference
    if reference is not None:
        raise TrueloopError(
            Code.JOB_TOOLS,
            f"the job has {len(files.job.tools)} tools and takes z from touch {reference!r}: the "
            "store keeps each edge's touches by themselves, and that one is of one edge",
            hint="take z from it at the device, and leave `gauging.z_reference` out; or keep nothing: --db none",
            place=Place(str(files.path)),
            values={"tools": [tool.called.words for tool in files.job.tools]},
        )
