"""One tool's offset (dX, dZ) for all characteristics of the features that it cuts.

A tool offset d moves every surface with the outward normal n by n·d, and so changes a characteristic by g·d, where
g = Σ gains · n over its places (`turned.characteristics.measurand`): a diameter by 2 dX, a length from the part's zero
by dZ. Wanted are the changes c of all characteristics of the tool: least squares of (g·d − c)/u, u the standard
deviation of one part. It is minimal where the characteristics leave an axis open: that one stays as it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.proposal import Proposal
from trueloop.domain.tool_offset import ExpandedU, HeldTool
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.propose import Made, effect_of, of_tool
from trueloop.loops.post_process.tracked import Tracked
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.programs import contour_tools, no_number
from trueloop.nc.program.program import Program
from trueloop.statistics import NORMAL_95
from trueloop.turned.characteristics.measurand import measurand
from trueloop.turned.program.wear import wear_offset
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.wording import Um

OPEN: Final = 1e-6
"""Share of the largest singular value below which characteristics say nothing of a direction."""
LEAST_U_MM: Final = 1e-4


@dataclass(frozen=True)
class JobTool:
    """What a job says of its part and tool, or of one of its tools and what that cuts. `asked`: the requested
    characteristics of its features, by name.

    `tool` is the number of the offset that the job names, `x_is_diameter` how the control counts offsets on X.
    """

    profile: Profile
    program: Program
    matched: Commanded
    asked: Mapping[str, Characteristic]
    tool: int | None = None
    x_is_diameter: bool | None = None
    edge: int = 1


def moved_by_offset(profile: Profile, asked: Characteristic) -> Array:
    """Returns the g of a characteristic, (2,): the change of its size per mm of tool offset on X (a radius) and on Z.

    Raises TOL-FEATURE and TOL-PLACE for what the part does not have.
    """
    sizes = measurand(profile, asked, np.zeros(len(profile.features), dtype=np.intp))
    places = zip(sizes.feature_index.tolist(), sizes.arc_length_mm.tolist(), strict=True)
    normals = np.array([profile.features[index].outward_normal(s) for index, s in places])
    return np.asarray((sizes.gains @ normals).mean(axis=0))


def fitted_offset(gains: Array, wanted_mm: Array, standard_u_mm: Array) -> tuple[tuple[float, float], ExpandedU]:
    """Returns the offset (x as a radius, z) mm that comes closest, and its expanded uncertainty (95 %); gains (m, 2),
    changes and uncertainties (m,).
    """
    u = np.maximum(standard_u_mm, LEAST_U_MM)
    terms = gains / u[:, None]
    inverse = np.linalg.pinv(terms, rcond=OPEN)
    x, z = inverse @ (wanted_mm / u)
    known = np.diag(inverse @ terms) > 1.0 - OPEN
    expanded = NORMAL_95 * np.linalg.norm(inverse, axis=1)
    x_u, z_u = (float(one) if determined else None for one, determined in zip(expanded, known, strict=True))
    return (float(x), float(z)), (x_u, z_u)


def tool_proposals(
    series: Sequence[Tracked], jobs: Sequence[JobTool], options: SeriesOptions, made: Made
) -> tuple[Proposal, ...]:
    """Returns a proposal for each tool of the finish pass whose offset is to change, in its control's step.

    Raises SER-TOOL where no characteristic of the series is a size of the job's part.
    """
    by_tool = [(job, number, of_it) for job in jobs for number, of_it in sorted(_by_tool(series, job).items())]
    if not by_tool:
        names = ", ".join(sorted(repr(one.series.name) for one in series)[:6])
        raise TrueloopError(
            Code.SER_TOOL,
            f"none of {len(series)} series ({names}) is a size of the job's features",
            hint="name them in `[[part.characteristic]]` of the job as the inspections do, each with its feature",
        )
    found = [_of_one(job, number, of_it, options, made) for job, number, of_it in by_tool]
    return tuple(one for one in found if one is not None)


def _by_tool(series: Sequence[Tracked], job: JobTool) -> dict[int, list[tuple[Tracked, Array]]]:
    """Groups by the number of its offset the series that a tool's offset moves, each with its g."""
    found: dict[int, list[tuple[Tracked, Array]]] = {}
    tools = contour_tools(job.program, job.matched, alone=True)
    for one in series:
        asked = job.asked.get(one.series.name)
        if one.series.latest and asked is not None:
            number = tools.cut_by[job.profile.names.index(asked.feature)]
            found.setdefault(_number(job, number, asked.feature), []).append((one, moved_by_offset(job.profile, asked)))
    return found


def _number(job: JobTool, cut_by: int | None, feature: str) -> int:
    """Returns the number of the offset that cuts a feature. Raises OFS-TOOL where program and job give none."""
    number = cut_by or job.tool
    if not number:
        index = job.profile.names.index(feature)
        raise no_number(job.program, job.matched.match.features[index].moves[0].move.line)
    return number


def _of_one(
    job: JobTool, number: int, of_it: Sequence[tuple[Tracked, Array]], options: SeriesOptions, made: Made
) -> Proposal | None:
    series, gains = [one for one, _ in of_it], np.array([gain for _, gain in of_it])
    wanted = np.array([-one.change_mm for one in series])
    u_mm = np.array([one.last.step.predicted_u_mm or 0.0 for one in series])
    offset_mm, known_mm = fitted_offset(gains, wanted, u_mm)
    cut = job.matched.match.features[0].moves[0].move.index
    wear = wear_offset(
        *(job.program, job.matched.path, cut, offset_mm, number, job.x_is_diameter, job.edge), expanded_u_mm=known_mm
    )
    kept = wear.as_offset(True, "", HeldTool(edge=job.edge))
    moved = gains @ np.array([kept.x_radius_mm, kept.z_mm])
    if np.all(np.abs(moved) <= options.least_mm):
        return None
    effects = [effect_of(one, float(size_mm)) for one, size_mm in zip(series, moved, strict=True)]
    return of_tool(series, effects, kept, job.program.dialect.wear_words, made, _why(wear, len(series), wanted - moved))


def _why(wear: WearOffset, count: int, left_mm: Array) -> str:
    left = Um(float(np.max(np.abs(left_mm))))
    return f"{wear.words}: the offset closest to what {count} characteristics ask for; it leaves up to {left} of that"


def characteristic_on(profile: Profile, asked: Characteristic) -> Characteristic | None:
    """Returns a characteristic that names its feature as the part does, of a kind that a tool offset changes; else
    None.
    """
    if asked.feature not in profile.names or asked.quantity not in (Quantity.DIAMETER, Quantity.LENGTH):
        return None
    try:
        moved_by_offset(profile, asked)
    except TrueloopError:
        return None
    return asked
