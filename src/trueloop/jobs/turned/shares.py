"""A job of several edges, in one set-up or in several, as jobs of one edge each: what the store keeps of a part.

Whether one edge cuts in two set-ups: a number may be another tool on another day, and only a name says that it is
the same one.

One of several edges as the store has it: its share of a part is a part of its own, as of a job of that edge alone.

Its part type is named after the part, the set-up where there are several, and the edge, so that cuts, inspections and
corrections of two edges never mix, and what an edge learns comes from what it cuts. All of a share is in the frame of
its program: what a person reads of it there is what the machine shows.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final, Literal

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.jobs.turned.inputs import read_setups
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.part import EdgeCorrection, PartCorrection, SetupCorrection
from trueloop.loops.turned.share import index_in, reading_in, touch_in
from trueloop.nc.match.own_contour import OwnContour
from trueloop.nc.program.called import CalledOffset
from trueloop.turned.characteristics.measurand import place_of
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import MatchedReading, MatchedTouch
from trueloop.wording import wording


@dataclass(frozen=True)
class ShareOfEdge:
    """One edge: the job as if it were its only one, and what it cuts, in the frame of `setup`; None: the part's."""

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


def require_edges_named(files: JobFiles, corrected: PartCorrection) -> None:
    """Raises SET-EDGE where edges of two set-ups are one for the store and the job does not state both `name`s."""
    tables = {(setup.name, tool.called): tool for setup in files.job.setups for tool in setup.tools}
    for (correction, edge), (other, same) in combinations(_edges(corrected), 2):
        if correction is other or _identity(edge) != _identity(same):
            continue
        named = [tables[of.frame.name, called] for of, called in ((correction, _called(edge)), (other, _called(same)))]
        if not all(table.name for table in named):
            raise _unnamed(files, (correction, other), named)


def _edges(corrected: PartCorrection) -> list[tuple[SetupCorrection, EdgeCorrection]]:
    """Those that the store would have."""
    return [(setup, edge) for setup in corrected.setups for edge in setup.edges if _identity(edge) is not None]


def _called(of: EdgeCorrection) -> CalledOffset:
    assert of.contour is not None  # an edge of a set-up has its own
    return of.contour.edge.called


def _identity(of: EdgeCorrection) -> tuple[str, ...] | None:
    edge = None if of.inputs is None else of.inputs.edge
    return None if edge is None else edge.identity


def _unnamed(
    files: JobFiles, setups: tuple[SetupCorrection, SetupCorrection], tools: list[ToolsTable]
) -> TrueloopError:
    names = [setup.frame.name for setup in setups]
    called = " and ".join(dict.fromkeys(tool.called.words for tool in tools))
    return Code.SET_EDGE.refusal(
        wording(
            "{called} of set-ups {first} and {second} would be one edge in the store, and the job does not name it",
            called=called,
            first=names[0],
            second=names[1],
        ),
        hint="state `name` of both tables [[setups.tools]]: the same where it is one tool, else two",
        override="--no-store",
        place=Place(str(files.path)),
        values={"setups": names, "tool": called},
    )


def name_of_share(part: str, own: OwnContour, setup: SetupFrame | None) -> str:
    """Returns `grooved, T5 (left corner)`; of a set-up `shaft, second, T2`."""
    return ", ".join([part, *([] if setup is None else [setup.name]), own.edge.words])


def inspection_of_edge(
    inspection: Inspection,
    profile: Profile,
    own: OwnContour,
    names: Mapping[str, str] | None = None,
    setup: SetupFrame | None = None,
    allowance_mm: float = 0.0,
    drawn: Sequence[Characteristic] = (),
) -> Inspection:
    """Returns what was measured of the edge's own features, by their names on its contour and in its frame.

    `profile` is the whole part's, `names` are its names of features by those in the file; `setup` is the frame of the
    contour, None: the part's. What lies on no feature does not belong to it. A length from one of its faces to that of
    another edge, or to a zero that is not the program's, is kept beside what is measured of it alone: by the name and
    with the limits of `drawn`, where the drawing has it; no error of the edge follows from it. Where z counts from a
    touch of another edge's feature, the touches are kept in its frame: their z less the deviation of that touch from
    its nominal.
    """
    frame = setup or PART
    matched = match_inspection(profile, inspection, names)
    mine = {
        index: own.profile.names[own.index_of(there)]
        for index in range(len(profile.features))
        if (there := index_in(frame, index, len(profile.features))) in [k for parts in own.parts for k in parts]
    }
    reference = next((m for m in matched.touches if m.touch.point == inspection.z_reference), None)
    own_z = reference is None or reference.feature_index in mine
    off_mm = 0.0 if own_z or reference is None else _off_mm(profile, reference, allowance_mm)
    touches = [
        replace(touch_in(frame, _from_z(profile, m, off_mm)), feature=mine[m.feature_index])
        for m in matched.touches
        if m.feature_index in mine
    ]
    readings = [placed for m in matched.readings if (placed := _own_reading(frame, m, mine)) is not None]
    if touches or readings:
        readings += [
            one for m in matched.readings if (one := _shared_length(profile, m, mine, frame, drawn)) is not None
        ]
    values: tuple[Touch | Reading, ...] = (*touches, *readings)
    kind: Literal["touches", "readings"] = "touches" if touches else "readings"
    z_reference = inspection.z_reference if own_z else None
    return replace(inspection, measured=kind, values=values, count=len(values), z_reference=z_reference)


def _off_mm(profile: Profile, of: MatchedTouch, allowance_mm: float) -> float:
    """Returns the deviation of a touched face from its nominal along z, mm."""
    assert of.touch.error_mm is not None  # `match_inspection` takes it from the point
    return (of.touch.error_mm - allowance_mm) / _normal_z(profile, of)


def _from_z(profile: Profile, of: MatchedTouch, off_mm: float) -> Touch:
    """Returns a touch as seen from a zero that lies higher by `off_mm`."""
    touch = of.touch
    assert touch.error_mm is not None
    measured_mm = None if touch.measured_mm is None else (touch.measured_mm[0], touch.measured_mm[1] - off_mm)
    return replace(touch, measured_mm=measured_mm, error_mm=touch.error_mm - off_mm * _normal_z(profile, of))


def _normal_z(profile: Profile, of: MatchedTouch) -> float:
    feature = profile.features[of.feature_index]
    return float(feature.outward_normal(float(feature.locate(of.touch.nominal_mm)[0]))[1])


def _own_reading(frame: SetupFrame, of: MatchedReading, mine: Mapping[int, str]) -> Reading | None:
    if of.feature_index not in mine or (of.other_index is not None and of.other_index not in mine):
        return None
    other = "" if of.other_index is None else mine[of.other_index]
    placed = reading_in(frame, of.reading, other)
    return None if placed is None else replace(placed, feature=mine[of.feature_index], other=other)


ZERO: Final = "zero of the part"
"""From where a length counts whose part's zero is not that of the program: the name of no feature."""


def _shared_length(
    profile: Profile, of: MatchedReading, mine: Mapping[int, str], frame: SetupFrame, drawn: Sequence[Characteristic]
) -> Reading | None:
    """Returns a length with one end of this edge's as one of that end; None: it is none, or of this edge alone."""
    faces = [index for index in (of.feature_index, of.other_index) if index is not None]
    ends = [index for index in faces if index in mine]
    if of.reading.quantity is not Quantity.LENGTH or len(ends) != 1 or _own_reading(frame, of, mine) is not None:
        return None
    names = [profile.names[index] for index in faces]
    size = Characteristic("", Quantity.LENGTH, names[0], 0.0, other="" if len(names) == 1 else names[1])
    other = next((name for name in names if name != profile.names[ends[0]]), ZERO)
    reading = replace(of.reading, feature=mine[ends[0]], other=other, place_mm=())
    named = next(
        (characteristic for characteristic in drawn if place_of(characteristic, profile) == place_of(size, profile)),
        None,
    )
    return reading if named is None else of_characteristic(reading, named)


def of_characteristic(reading: Reading, characteristic: Characteristic) -> Reading:
    """Returns the reading with the name, the nominal and the limits of a characteristic."""
    return replace(
        reading,
        characteristic=characteristic.name,
        nominal=characteristic.nominal,
        lower_limit=characteristic.lower_limit,
        upper_limit=characteristic.upper_limit,
    )


def stored_inputs(
    inputs: Inputs, profile: Profile, own: OwnContour | None, drawn: Sequence[Characteristic] = ()
) -> Inputs:
    """Returns an edge's inputs as of its own part; `profile`: the whole part's; `drawn` as in `inspection_of_edge`."""
    if own is None:
        return inputs
    part = replace(inputs.part, name=name_of_share(inputs.part.name, own, inputs.setup))
    allowance_mm = inputs.measured_allowance_mm
    mine = (
        inspection_of_edge(inspection, profile, own, setup=inputs.setup, allowance_mm=allowance_mm, drawn=drawn)
        for inspection in inputs.inspections
    )
    inspections = tuple(
        replace(inspection, part=replace(inspection.part, part_type=part)) for inspection in mine if inspection.values
    )
    edge, number = inputs.edge, own.edge.called.edge
    if edge is not None and number > 1:
        edge = replace(edge, corner=f"{edge.corner} D{number}".strip())
    return replace(inputs, part=part, inspections=inspections, edge=edge)
