"""One of several edges as the store has it: its share of a part is a part of its own, as of a job of that edge alone.

Its part type is named after the part, the set-up where there are several, and the edge, so that cuts, inspections and
corrections of two edges never mix, and what an edge learns comes from what it cuts. All of a share is in the frame of
its program: what a person reads of it there is what the machine shows.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.domain.part import PartType
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.option_tables import options_from
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.share import index_in, reading_in, touch_in
from trueloop.nc.match.own_contour import OwnContour
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matched import MatchedReading
from trueloop.turned.touches.touches import Gauging


def name_of_share(part: str, own: OwnContour, setup: SetupFrame | None) -> str:
    """Returns `grooved, T5 (left corner)`; of a set-up `shaft, second, T2`."""
    return ", ".join([part, *([] if setup is None else [setup.name]), own.edge.words])


def inspection_of_edge(
    one: Inspection,
    profile: Profile,
    own: OwnContour,
    names: Mapping[str, str] | None = None,
    setup: SetupFrame | None = None,
) -> Inspection:
    """Returns what was measured of the edge's own features, by their names on its contour and in its frame.

    `profile` is the whole part's, `names` are its names of features by those in the file; `setup` is the frame of the
    contour, None: the part's. What lies on no feature, a length between features of two edges, and one that counts from
    a zero which is not the program's, does not belong to it.
    """
    frame = setup or PART
    matched = match_inspection(profile, one, names)
    mine = {
        index: own.profile.names[own.index_of(there)]
        for index in range(len(profile.features))
        if (there := index_in(frame, index, len(profile.features))) in [k for parts in own.parts for k in parts]
    }
    touches = [
        replace(touch_in(frame, m.touch), feature=mine[m.feature_index])
        for m in matched.touches
        if m.feature_index in mine
    ]
    readings = [placed for m in matched.readings if (placed := _own_reading(frame, m, mine)) is not None]
    values: tuple[Touch | Reading, ...] = (*touches, *readings)
    kind: Literal["touches", "readings"] = "touches" if touches else "readings"
    return replace(one, measured=kind, values=values, count=len(values))


def _own_reading(frame: SetupFrame, of: MatchedReading, mine: Mapping[int, str]) -> Reading | None:
    if of.feature_index not in mine or (of.other_index is not None and of.other_index not in mine):
        return None
    other = "" if of.other_index is None else mine[of.other_index]
    placed = reading_in(frame, of.reading, other)
    return None if placed is None else replace(placed, feature=mine[of.feature_index], other=other)


def stored_inputs(inputs: Inputs, profile: Profile, own: OwnContour | None) -> Inputs:
    """Returns an edge's inputs as those of its own part; `profile` is the whole part's. A job's only tool has all."""
    if own is None:
        return inputs
    part = replace(inputs.part, name=name_of_share(inputs.part.name, own, inputs.setup))
    mine = (inspection_of_edge(one, profile, own, setup=inputs.setup) for one in inputs.inspections)
    inspections = tuple(_of_type(one, part) for one in mine if one.values)
    edge, number = inputs.edge, own.edge.called.edge
    if edge is not None and number > 1:
        edge = replace(edge, corner=f"{edge.corner} D{number}".strip())
    return replace(inputs, part=part, inspections=inspections, edge=edge)


def _of_type(one: Inspection, part: PartType) -> Inspection:
    return replace(one, part=replace(one.part, part_type=part))


def require_kept_apart(files: JobFiles) -> None:
    """Raises JOB-TOOLS, of several set-ups JOB-SETUPS, for a part whose z is taken from a touch: it is of one edge, and
    the z of all others depends on it.
    """
    reference = options_from(Gauging, files.job).z_reference
    if reference is None or not (files.job.setups or files.job.tools):
        return
    why = (
        f"takes z from touch {reference!r}: the store keeps each edge's touches by themselves, and that one is of one "
        "edge"
    )
    hint = "take z from it at the device, and leave `gauging.z_reference` out; or keep nothing: --no-store"
    place, setups, tools = Place(str(files.path)), files.job.setups, files.job.tools
    if setups:
        names = [one.name for one in setups]
        said = f"the job has {len(names)} set-ups and {why}"
        raise TrueloopError(Code.JOB_SETUPS, said, hint=hint, place=place, values={"setups": names})
    called = [tool.called.words for tool in tools]
    said = f"the job has {len(called)} tools and {why}"
    raise TrueloopError(Code.JOB_TOOLS, said, hint=hint, place=place, values={"tools": called})
