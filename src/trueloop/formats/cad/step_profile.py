"""Reads a profile from a turned solid in a STEP or IGES file: its section through the axis of its turned faces."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cad.dxf_chain import Segment
from trueloop.formats.cad.dxf_outline import alike, cut_at, outlines, upper_half
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import read_faces, read_shape
from trueloop.formats.input_file import FilePath
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.names import named_by_kind

WITHIN_MM: Final = 1e-4
"""Ends of the section's edges that lie closer are one point, axes that lie closer are one axis."""
PARALLEL: Final = 1e-6
NO_ARC: Final = "spline"
"""Stands where a drawing has the layer, for curves that are neither lines nor arcs."""
SECTIONS_RAD: Final = (0.6, 1.7, 2.9)
"""Half planes through the axis that are cut: away from seams, and no cross hole is likely in two of them."""


@dataclass(frozen=True)
class StepProfile:
    """Features from chuck end to free end, not yet checked as a profile, and in words how the solid was read."""

    features: tuple[Feature, ...]
    notes: tuple[str, ...]


def read_step_profile(
    path: FilePath, *, turned_round: bool = False, from_z_mm: float | None = None, to_z_mm: float | None = None
) -> StepProfile:
    """The outside of a turned solid as exact lines and arcs, in mm, z along its axis from the file's origin.

    The axis is that about which most of the area is turned; z grows along it towards the file's +z, or the largest of
    its components, and the other way when `turned_round`. Bores are left out. What lies below `from_z_mm` and above
    `to_z_mm` is cut off: a profile begins and ends where its finish program does. Features are named cylinder-1, arc-1…
    Raises SRF-CAD for what cannot be read, GEO-STEP for a solid without an axis, one whose sections differ, and
    outlines that are neither lines nor arcs.

    >>> trueloop.read_step_profile(trueloop.example("surface/nominal.step"))
    Traceback (most recent call last):
    trueloop.errors.TrueloopError
    """
    path = Path(path)
    axis = _axis(path)
    origin, along = axis.origin, axis.direction * (-1.0 if turned_round else 1.0)
    shape, found = read_shape(path), list[tuple[Feature, ...]]()
    for turn in SECTIONS_RAD:
        found.append(_outside(_section(shape, origin, along, turn), path))
    first, second = next(
        ((a, b) for a, b in combinations(found, 2) if a and _same(a, b)),
        (None, None),
    )
    if first is None or second is None:
        counts = ", ".join(str(len(features)) for features in found)
        raise _refusal(
            path,
            f"sections through the axis differ: {counts} features at {len(found)} angles",
            "the outside is not turned about one axis: give the profile by hand or as a drawing",
        )
    low_mm, high_mm = -math.inf if from_z_mm is None else from_z_mm, math.inf if to_z_mm is None else to_z_mm
    clipped = _clipped(first, low_mm, high_mm, path)
    (x0, y0, z0), (dx, dy, dz) = origin.tolist(), along.tolist()
    ends = [clipped[0].start_mm[1], clipped[-1].end_mm[1]]
    notes = [
        f"The axis runs through x {x0:.4f}, y {y0:.4f}, z {z0:.4f} mm along ({dx:.6f}, {dy:.6f}, {dz:.6f}); "
        f"{axis.share:.0%} of the turned area is turned about it.",
        f"z is counted from the file's origin: the profile runs from z = {ends[0]:.4f} to z = {ends[1]:.4f} mm.",
    ]
    return StepProfile(named_by_kind(clipped), tuple(notes))


@dataclass(frozen=True, eq=False)
class _Axis:
    origin: Array
    direction: Array
    share: float


def _axis(path: Path) -> _Axis:
    """The line about which most of the area is turned, its point nearest to the file's origin."""
    groups: list[tuple[Array, Array, float]] = []
    for face in read_faces(path):
        surface = kernel().surface_of(face.handle)
        if face.kind not in ("CylindricalSurface", "ConicalSurface", "ToroidalSurface", "SurfaceOfRevolution"):
            continue
        own = surface.Axis()
        point, direction = (np.array([v.X(), v.Y(), v.Z()]) for v in (own.Location(), own.Direction()))
        direction = direction * np.sign(direction[np.argmax(np.abs(np.round(direction, 6)))])
        foot = point - (point @ direction) * direction
        for k, (at, along, area) in enumerate(groups):
            if np.linalg.norm(at - foot) < WITHIN_MM and np.linalg.norm(along - direction) < PARALLEL:
                groups[k] = at, along, area + face.area_mm2
                break
        else:
            groups.append((foot, direction, face.area_mm2))
    if not groups:
        raise _refusal(
            path, "0 of its faces are turned about an axis", "a turned solid has cylinders, cones or fillets"
        )
    at, along, area = max(groups, key=lambda group: group[2])
    return _Axis(at, along, area / sum(group[2] for group in groups))


def _section(shape: Any, origin: Array, along: Array, turn: float) -> list[Segment]:
    """The edges of the solid's section with a plane through the axis, both sides of it: x aside, z along."""
    occ = kernel()
    first = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    first /= np.linalg.norm(first)
    aside = math.cos(turn) * first + math.sin(turn) * np.cross(along, first)
    normal = np.cross(along, aside)
    cut = occ.Section(shape, occ.Plane(occ.Pnt(*origin.tolist()), occ.Dir(*normal.tolist())), False)
    cut.Build()
    edges, found = occ.Explorer(cut.Shape(), occ.EDGE), list[Segment]()
    while edges.More():
        segment = _segment(occ.Curve(occ.as_edge(edges.Current())), origin, along, aside)
        known = any(alike(segment.feature, other.feature, WITHIN_MM) for other in found)
        if segment.feature.length_mm > WITHIN_MM and not known:
            found.append(segment)
        edges.Next()
    return found


def _segment(curve: Any, origin: Array, along: Array, aside: Array) -> Segment:
    """An edge in the plane of the section. Of a spline there is the chord, which may not be on the outside."""
    occ = kernel()

    def flat(point: Any) -> Point:
        xyz = np.array([point.X(), point.Y(), point.Z()])
        return float((xyz - origin) @ aside), float(xyz @ along)

    low, high = curve.FirstParameter(), curve.LastParameter()
    start, end = flat(curve.Value(low)), flat(curve.Value(high))
    if curve.GetType() != occ.CIRCLE:
        return Segment(Line("", start, end), "" if curve.GetType() == occ.LINE else NO_ARC)
    centre, middle = flat(curve.Circle().Location()), flat(curve.Value((low + high) / 2))
    # Whether the middle lies to the left or to the right of the chord says which way the arc turns; half circles too.
    (x0, z0), (x1, z1) = start, end
    left = (z1 - z0) * (middle[0] - x0) - (x1 - x0) * (middle[1] - z0)
    return Segment(Arc("", start, end, centre, math.copysign(high - low, left)), "")


def _outside(segments: Sequence[Segment], path: Path) -> tuple[Feature, ...]:
    """The outline from its left end to its right one, without what bores leave; empty where there is no one outline."""
    half = upper_half([s for s in segments if not _on_axis(s.feature)], WITHIN_MM).segments
    if not half:
        return ()
    ends = np.array([end for segment in half for end in segment.ends])
    closing = [Segment(Line("axis", (0.0, z), (x, z)), "axis") for x, z in _corners(ends)]
    found = outlines([*half, *closing], WITHIN_MM)
    if len(found) != 1:
        return ()
    for segment in found[0].chain:
        if segment.layer == NO_ARC:
            (x, z), (x1, z1) = segment.ends
            raise _refusal(
                path,
                f"the outside from x = {x:.4f}, z = {z:.4f} to x = {x1:.4f}, z = {z1:.4f} mm is no line and no arc",
                "a profile consists of lines and arcs: approximate the spline by them in the CAD system",
            )
    chain = [segment.feature for segment in found[0].chain if segment.layer != "axis"]
    low, high = (float(f(ends[:, 1])) for f in (np.min, np.max))
    first = next((k for k, f in enumerate(chain) if abs(f.start_mm[1] - low) < WITHIN_MM), 0)
    last = max((k for k, f in enumerate(chain) if abs(f.end_mm[1] - high) < WITHIN_MM), default=len(chain) - 1)
    return tuple(chain[first : last + 1])


def _corners(ends: Array) -> Iterator[Point]:
    """Where a hollow part's end faces begin, next to the bore: the outline is closed on the axis from there."""
    for end in (float(np.min(ends[:, 1])), float(np.max(ends[:, 1]))):
        x = float(np.min(ends[np.abs(ends[:, 1] - end) < WITHIN_MM, 0]))
        if x > WITHIN_MM:
            yield x, end


def _on_axis(feature: Feature) -> bool:
    return isinstance(feature, Line) and max(abs(feature.start_mm[0]), abs(feature.end_mm[0])) < WITHIN_MM


def _same(a: Sequence[Feature], b: Sequence[Feature]) -> bool:
    return len(a) == len(b) and all(alike(f, g, WITHIN_MM) for f, g in zip(a, b, strict=True))


def _clipped(features: Sequence[Feature], low: float, high: float, path: Path) -> list[Feature]:
    """The features between two z, those that cross them cut there."""
    kept = list[Feature]()
    for feature in features:
        for piece in cut_at(feature, [*_at_z(feature, low), *_at_z(feature, high)], WITHIN_MM):
            ends = piece.start_mm[1], piece.end_mm[1]
            if min(ends) > low - WITHIN_MM and max(ends) < high + WITHIN_MM:
                kept.append(piece)
    broken = any(math.dist(a.end_mm, b.start_mm) > WITHIN_MM for a, b in pairwise(kept))
    if not kept or broken:
        first, last = features[0].start_mm[1], features[-1].end_mm[1]
        raise _refusal(
            path,
            f"between z = {low:g} and {high:g} mm there are {len(kept)} features, {'not ' * broken}joined",
            f"the outside runs from z = {first:.4f} to z = {last:.4f} mm: choose another range",
        )
    return kept


def _at_z(feature: Feature, z: float) -> list[Point]:
    if not math.isfinite(z):
        return []
    if isinstance(feature, Line):
        (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
        return [(x0 + (x1 - x0) * (z - z0) / (z1 - z0), z)] if (z0 - z) * (z1 - z) < 0 else []
    (cx, cz), r = feature.centre_mm, feature.radius_mm
    aside = math.sqrt(max(r * r - (z - cz) ** 2, 0.0))
    return [(cx - aside, z), (cx + aside, z)] if abs(z - cz) < r else []


def _refusal(path: Path, message: str, hint: str) -> TrueloopError:
    return TrueloopError(Code.GEO_STEP, message, hint=hint, place=Place(str(path)))
