"""Places where a corrected program, as it is written, would cut into the corrected surface.

Not only the pass: leads, links and rapid moves stay where they were while the surface may have been raised under them.
"""

from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface, closest
from trueloop.nc.program.along import points_along, said_ends
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import NO_COMPENSATION, ToolPath
from trueloop.surface.compensation.cutter import Cutter, ToolAxes, contacts, edge_centres_mm
from trueloop.surface.compensation.shift import SAME_MM, SurfaceJob, places
from trueloop.units import UM_PER_MM

AROUND: Final = 12
"""Places around a cutter's edge that are searched for gouges."""


def check_gouges(
    program: Program,
    path: ToolPath,
    axes: ToolAxes,
    cutting: Flags,
    nominal: Surface,
    corrected: Surface,
    job: SurfaceJob,
) -> None:
    """Refuses moves, at feed or rapid, that take the cutter into the corrected surface by more than `job.gouge_mm`.

    Looked at are the moves of the pass, `cutting` (n,), and all others of its tool and work offset that begin and end
    where the program says, without G41 or G42. Chords within `job.tolerance_mm` of what they stand for are allowed that
    much more. A place beside the pass that lay deeper than `job.cuts_mm` in the nominal surface already is left alone:
    it is on the other side of a wall, or as deep as its programmer meant. Raises SRF-GOUGE.
    """
    before, after = said_ends(program, path)
    like = np.isin(path.tool, path.tool[cutting]) & np.isin(path.work_offset, path.work_offset[cutting])
    beside = np.all(before & after, axis=1) & like & (path.compensation == NO_COMPENSATION) & ~axes.unsaid
    move, share = places(path, axes, np.flatnonzero(cutting | beside), job.sample_mm)
    tips, directions = points_along(path, move, share), axes.directions(move, share)
    depth_mm, points = depths_mm(corrected, job.cutter, tips, directions)
    deep = np.flatnonzero(depth_mm > job.gouge_mm + job.tolerance_mm)
    own_mm, _ = depths_mm(nominal, job.cutter, tips[deep], directions[deep])
    deep = deep[cutting[move[deep]] | (own_mm <= job.cuts_mm)]
    if len(deep):
        worst = deep[np.argmax(depth_mm[deep])]
        x, y, z = points[worst]
        what = "a rapid move" if path.rapid[move[worst]] else "the cutter"
        raise TrueloopError(
            Code.SRF_GOUGE,
            f"{what} would cut {depth_mm[worst] * UM_PER_MM:.1f} µm into the corrected surface at x {x:.3f}, "
            f"y {y:.3f}, z {z:.3f} mm; {job.gouge_mm * UM_PER_MM:.1f} µm is allowed, exceeded at {len(deep)} places",
            hint="the cutter is too large for a hollow there, a lead or link runs too near to the surface, or the "
            "program belongs to another surface or tool",
            values={
                "depth_um": float(depth_mm[worst]) * UM_PER_MM,
                "limit_um": job.gouge_mm * UM_PER_MM,
                "x_mm": float(x),
                "y_mm": float(y),
                "z_mm": float(z),
            },
        )


def depths_mm(surface: Surface, cutter: Cutter, tips_mm: Array, axes: Array) -> tuple[Array, Array]:
    """How deep a cutter at (n, 3) is in the surface at the most, (n,), −∞ beside the patch; and where, (n, 3).

    The nearest point of the surface is looked for afresh for each, wherever on the patch it is: a ball in a hollow
    narrower than itself is nearest to a rim it was not meant to touch. So it is for places all around the edge of a
    bull-nose or flat cutter, which in a hollow cuts where it does not lean.
    """
    if not len(tips_mm):
        return np.empty(0), np.empty((0, 3))
    found = contacts(surface, cutter, tips_mm, axes)
    feet, gap = [found.feet], [found.gap_mm]
    for centres in edge_centres_mm(cutter, tips_mm, axes, AROUND):
        feet.append(closest(surface, centres))
        gap.append(feet[-1].distance_mm - cutter.corner_mm)
    deep = np.where(np.stack([some.beyond_mm for some in feet]) <= SAME_MM, -np.stack(gap), -np.inf)
    most = np.argmax(deep, axis=0), np.arange(len(tips_mm))
    return deep[most], np.stack([some.point_mm for some in feet])[most]
