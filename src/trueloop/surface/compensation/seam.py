"""Steps that a correction of one face leaves where the program cuts on into the next face of the part."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.domain.option import Limits, allowed_by
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.geometry.surface import Surface, closest, near
from trueloop.nc.program.tool_path import ToolPath
from trueloop.surface.compensation.cutter import contacts
from trueloop.surface.compensation.shift import SAME_MM, Samples, SurfaceJob
from trueloop.surface.on_face import NextFace
from trueloop.units import UM_PER_MM

WIDE_MM: Final = 0.1
"""Over this length a step counts as a slope: the correction ends at one place, wherever the blocks around it end."""
LEVEL: Final = 1e-3
"""Slope, mm/mm, up to which a step is not reported: 0.1 µm over `WIDE_MM`."""
ALIKE: Final = 0.8
"""Cosine between the normals of two faces from which a cutter runs on from one to the other: not around an edge."""


@dataclass(frozen=True)
class Steps:
    """The other faces of the part, `beside` the corrected one, and the limits of the correction."""

    beside: tuple[NextFace, ...]
    limits: Limits

    def check(self, path: ToolPath, samples: Samples, nominal: Surface, job: SurfaceJob) -> tuple[Finding, ...]:
        """Returns a warning of the steps at places where the tool leaves or enters the face while it cuts a face beside
        it, which stays as it is. Raises CMP-SLOPE where the largest is steeper than the limit.
        """
        last, after = _changes(path, samples)
        moved_mm = np.linalg.norm(samples.after_mm[last] - samples.before_mm[last], axis=1)
        slope = moved_mm / WIDE_MM
        some = np.flatnonzero(slope > LEVEL)
        if not len(some) or not self.beside:
            return ()
        move, share = samples.move[last[some]], samples.share[last[some]]
        touch = contacts(nominal, job.cutter, samples.before_mm[last[some]], samples.axes.directions(move, share))
        foot, normal = touch.feet.point_mm, touch.feet.normal
        centre = foot + (touch.gap_mm + job.cutter.corner_mm)[:, None] * normal
        centre = centre + samples.before_mm[after[some]] - samples.before_mm[last[some]]
        onto = np.zeros(len(some), int)
        for face in self.beside:
            onto[(onto == 0) & _cuts(face, centre, normal, job)] = face.number
        if not np.any(onto):
            return ()
        worst = int(np.argmax(np.where(onto > 0, slope[some], 0.0)))
        x, y, z = foot[worst]
        um, reached, limit = (
            value * UM_PER_MM for value in (moved_mm[some[worst]], slope[some[worst]], self.limits.slope)
        )
        step = Finding(
            Severity.WARNING,
            Code.CMP_SLOPE,
            f"the correction ends with a step of up to {um:.1f} µm, at x {x:.3f}, y {y:.3f}, z {z:.3f} mm, where the "
            f"program cuts on from or into face {onto[worst]}, which stays as it is: {reached:.1f} µm/mm over "
            f"{WIDE_MM:g} mm, at {np.count_nonzero(onto)} places; the limit is {limit:.1f} µm/mm",
            hint="a program that cuts one face alone has no such step; compensation.weight makes it smaller",
            values=dict(zip(Code.CMP_SLOPE.values, (reached, limit), strict=True)),
        )
        if slope[some[worst]] > self.limits.slope:
            raise Code.CMP_SLOPE.refusal(step.message, hint=step.hint, override=allowed_by("slope"), values=step.values)
        return (step,)


def _changes(path: ToolPath, samples: Samples) -> tuple[Integers, Integers]:
    """Returns pairs of neighbouring places along the path of which one cuts and one does not: the cutting one first."""
    same = np.diff(samples.move) == 0
    joined = np.linalg.norm(np.diff(samples.before_mm, axis=0), axis=1) <= SAME_MM
    joined &= np.diff(samples.move) == 1
    first = np.flatnonzero((same | joined) & (samples.cutting[:-1] != samples.cutting[1:]))
    begins = samples.cutting[first + 1]
    return np.where(begins, first + 1, first), np.where(begins, first, first + 1)


def _cuts(face: NextFace, centre_mm: Array, normal: Array, job: SurfaceJob) -> np.ndarray:
    """Returns at which centres (n, 3) of the cutter's corner a face is cut that runs on from one with `normal` (n, 3).

    Which side of it the file takes for the outer one does not matter: models come with normals that point inwards.
    """
    found = np.zeros(len(centre_mm), bool)
    try:
        surface = face.surface
    except TrueloopError:  # the kernel makes no surface of it: a face beside must not be in the way
        return found
    some = near(surface, centre_mm, job.cutter.corner_mm + job.cuts_mm)
    if not len(some):
        return found
    feet = closest(surface, centre_mm[some])
    alike = np.einsum("nk,nk->n", feet.normal, normal[some])
    away_mm = np.sign(alike) * feet.distance_mm - job.cutter.corner_mm
    here = (np.abs(away_mm) <= job.cuts_mm) & (feet.beyond_mm <= SAME_MM) & (np.abs(alike) >= ALIKE)
    here[here] = ~face.trimmed_away(feet.u[here], feet.v[here]).astype(np.bool_)
    found[some[here]] = True
    return found
