"""Points of a scan of the whole part that are on one face, by distance and normal."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Finding, Severity
from trueloop.geometry.surface import Surface, closest
from trueloop.surface.deviations.points import MeasuredPoints

FACING: Final = 0.9
"""Cosine between a point's normal and the face's from which the point may be on it: at a sharp edge a mesh has the mean
of both faces' normals.
"""
NEIGHBOURS: Final = 12
"""Points whose plane is the normal of a point, where the file has none."""


def on_face(
    surface: Surface,
    scan: MeasuredPoints,
    normal: Array | None,
    farthest_mm: float,
    trim: Callable[[Array, Array], np.ndarray] | None = None,
) -> MeasuredPoints:
    """Returns the points of a scan that are on the face, with a note of the others: how many, and why.

    On the face is a point within `farthest_mm` of it, whose foot is inside its edges, and whose normal is that of the
    face. `normal` (n, 3) points out of the material; without it that of neighbouring points counts, of either sign.
    Raises SRF-OFF where no point is left.
    """
    points, total = scan.points_mm, len(scan.points_mm)
    control = surface.control_mm.reshape(-1, 3)
    reach = farthest_mm + scan.ball_radius_mm
    near = np.flatnonzero(np.all((points >= control.min(0) - reach) & (points <= control.max(0) + reach), axis=1))
    feet = closest(surface, points[near]) if len(near) else None
    if feet is not None:
        here = (np.abs(feet.distance_mm - scan.ball_radius_mm) <= farthest_mm) & (feet.beyond_mm == 0)
        if trim is not None and np.any(here):
            here[here] = ~trim(feet.u[here], feet.v[here]).astype(np.bool_)
        near, of_face = near[here], feet.normal[here]
    beside = total - len(near)
    facing: Flags = np.ones(len(near), dtype=np.bool_)
    if len(near) > NEIGHBOURS:
        own = _normals(points, near) if normal is None else normal[near]
        cosine = np.einsum("nk,nk->n", own, of_face)
        facing = (np.abs(cosine) if normal is None else cosine) >= FACING
    kept = near[facing]
    if not len(kept):
        raise Code.SRF_OFF.refusal(
            f"0 of {total} points of {scan.name!r} are on the face: {beside} are more than {farthest_mm:g} mm off it "
            f"or beside it, {total - beside} face elsewhere",
            hint="look at unit, frame, face and gauging.columns: the scan has to be in the frame of the CAD model",
            override="gauging.farthest_mm in the job",
            values={"part": scan.name, "limit_mm": farthest_mm},
        )
    note = Finding(
        Severity.NOTE,
        Code.SRF_OUTSIDE,
        f"{len(kept)} of {total} points of {scan.name!r} are on the face: {beside} are more than {farthest_mm:g} mm "
        f"off it or beside it, {total - beside - len(kept)} face elsewhere",
        "nothing to do where the scan is of more than the face",
        values={"part": scan.name},
    )
    lines = None if scan.lines is None else scan.lines[kept]
    return replace(scan, points_mm=points[kept], lines=lines, findings=(note,))


def _normals(points_mm: Array, some: np.ndarray) -> Array:
    """Normals (m, 3) of the planes through the neighbours of some of the points, of either sign."""
    from scipy.spatial import KDTree  # slow to import

    _, near = KDTree(points_mm).query(points_mm[some], k=NEIGHBOURS)
    off = points_mm[near] - np.mean(points_mm[near], axis=1, keepdims=True)
    _, turned = np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))
    return np.asarray(turned[:, :, 0])
