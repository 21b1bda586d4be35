"""Reads a profile from a turned solid in a STEP or IGES file: its section through the axis of its turned faces."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Final, Literal

import numpy as np

from trueloop.domain.characteristic import Characteristic
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cad.contour import Contour, Piece, crossing, cut_at
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.section import Body, Solids, contours_of, read_solids
from trueloop.formats.cad.step import CadFace
from trueloop.formats.cad.step_tolerances import Proposals, proposals, read_records, stated_in
from trueloop.formats.cad.turned_faces import WITHIN_MM, Axis, Meridian, axis_of, edge_places, meridians, run_on
from trueloop.formats.input_file import FilePath
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Feature, Line, Point
from trueloop.geometry.intersection import sign_changes
from trueloop.geometry.profile import Side, named_by_kind


def not_turned(body: Body, axis: Axis, section: Sequence[Feature]) -> Iterator[str]:
    """Yields a note on every kind of face that leaves nothing in the section, with their number and place."""
    groups: dict[str, list[tuple[float, float]]] = {}
    for face in body.faces:
        if run_on(meridians(face, axis), section):
            continue
        z = [at[1] for at in edge_places(face, axis)]
        groups.setdefault(_named(face, axis), []).append((min(z), max(z)) if z else (0.0, 0.0))
    for name, reach in groups.items():
        low, high = min(a for a, _ in reach), max(b for _, b in reach)
        faces = "1 face" if len(reach) == 1 else f"{len(reach)} faces"
        yield f"Not turned, left out: {name}, {faces} between z = {low:.3f} and z = {high:.3f} mm."


def _named(face: CadFace, axis: Axis) -> str:
    surface = kernel().surface_of(face.handle)
    if face.kind == "CylindricalSurface":
        direction = surface.Axis().Direction()
        if axis.is_parallel(direction):
            x = axis.flat(surface.Axis().Location())[0]
            return f"hole or round of radius {surface.Radius():.3f} mm along the axis, {x:.3f} mm from it"
        return f"cross hole or round of radius {surface.Radius():.3f} mm"
    if face.kind == "Plane":
        direction = surface.Axis().Direction()
        normal = np.array([direction.X(), direction.Y(), direction.Z()])
        along = abs(float(normal @ axis.direction)) < 1e-6
        return "planes along the axis (flats, keyways)" if along else "planes across the axis or oblique"
    return {"BSplineSurface": "B-spline surfaces (threads, free forms)"}.get(face.kind, face.kind)


AS_MUCH: Final = 0.9
"""Another axis about which this share of the area is turned that is turned about the first one is no lesser axis."""

HAS_TOLERANCES: Final = re.compile(r"DIMENSIONAL_(SIZE|LOCATION)|ANGULAR_(SIZE|LOCATION)|[A-Z]+_TOLERANCE\s*\(")
FEW: Final = 0.5
"""The share of the turn below which a feature is noted."""


@dataclass(frozen=True)
class StepProfile:
    """Features with the material on the right, not yet checked as a profile, and in words how the solid was read.

    An outside runs from chuck end to free end, a bore from free end to chuck end.
    """

    features: tuple[Feature, ...]
    notes: tuple[str, ...]
    characteristics: tuple[Characteristic, ...] = ()
    """Characteristics of these features that the file's tolerances limit (AP242)."""


def read_step_profile(
    path: FilePath,
    *,
    side: Literal["outside", "inside"] | Side = "outside",
    outline: int | None = None,
    turned_round: bool = False,
    from_z_mm: float | None = None,
    to_z_mm: float | None = None,
) -> StepProfile:
    """Reads the outside or the bore of a turned solid, exact, in mm; z runs along its axis from the file's origin.

    The axis is that about which most of the area is turned; z grows along it towards the file's +z, or the largest of
    its components, and the other way when `turned_round`. What is not turned (cross holes, flats, keyways) is left out
    and named. What lies below `from_z_mm` and above `to_z_mm` is cut off: a profile begins and ends where its finish
    program does. `outline` is the contour's number, from 1 from the chuck, where that side has several. Features are
    named cylinder-1, arc-1…
    Raises SRF-CAD for what cannot be read, GEO-STEP for a solid without an axis or with two, a side that it has not or
    has several times, one that is not turned all along, a curve that has a corner (GEO-CURVE).

    >>> trueloop.read_step_profile(trueloop.example("surface/nominal.step"))
    Traceback (most recent call last):
    trueloop.errors.TrueloopError
    """
    return read_step_solid(path, turned_round=turned_round).chosen(side, outline, from_z_mm, to_z_mm)


def read_step_solid(path: FilePath, *, turned_round: bool = False) -> "StepSolid":
    """Reads all contours of a solid, as `read_step_profile` does. Raises as that, but for the choice."""
    path = Path(path)
    solids = read_solids(path)
    bodies = solids.bodies
    if len(bodies) == 1:
        bodies = (replace(bodies[0], name=""),)
    parts = [_read(body, path, turned_round) for body in bodies]
    return StepSolid(path, solids, tuple(PlacedPiece(contour, part) for part in parts for contour in part.contours))


@dataclass(frozen=True)
class StepSolid:
    """A solid before a contour of it is chosen: what was found, body by body, first outside, each from the chuck."""

    file: Path
    solids: Solids
    found: "tuple[PlacedPiece, ...]"

    def chosen(
        self,
        side: Literal["outside", "inside"] | Side = "outside",
        outline: int | None = None,
        from_z_mm: float | None = None,
        to_z_mm: float | None = None,
    ) -> StepProfile:
        """Returns the profile of the contour chosen as in `read_step_profile`. Raises GEO-STEP."""
        low_mm, high_mm = -math.inf if from_z_mm is None else from_z_mm, math.inf if to_z_mm is None else to_z_mm
        chosen = _chosen(self.found, Side(side), outline, (low_mm, high_mm), self.file)
        clipped = _clipped(chosen.contour, low_mm, high_mm, self.file)
        features = named_by_kind(piece.feature for piece in clipped)
        few = [
            f"{feature.name} stands at {piece.share:.0%} of the turn only: the rest of it is taken for milled away."
            for feature, piece in zip(features, clipped, strict=True)
            if piece.share < FEW
        ]
        asked = _tolerances(self.solids, chosen.part, features, self.file)
        notes = (*chosen.part.notes, *_notes(self.found, chosen, features), *few, *asked.notes)
        return StepProfile(features, notes, asked.characteristics)


@dataclass(frozen=True)
class _Part:
    """A body, its axis, and what there is of contours."""

    body: Body
    axis: Axis
    contours: tuple[Contour, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class PlacedPiece:
    """A contour and the part that it is of."""

    contour: Contour
    part: _Part

    def __str__(self) -> str:
        (x0, z0), (x1, z1) = self.contour.ends
        of = f" of {self.contour.body!r}" if self.contour.body else ""
        gaps = f", open at {' and '.join(map(_at, self.contour.open_at))}" if self.contour.open_at else ""
        count = len(self.contour.pieces)
        return f"{self.contour.side}{of}, {count} features from {_at((x0, z0))} to {_at((x1, z1))}{gaps}"


def _read(body: Body, path: Path, turned_round: bool) -> _Part:
    axis = axis_of(body.faces)
    if axis is None:
        raise _refusal(
            path,
            f"0 of {len(body.faces)} faces{_of(body)} are turned about an axis",
            "a turned solid has cylinders, cones or fillets",
        )
    if axis.rival > AS_MUCH * axis.share:
        raise _refusal(
            path,
            f"2 axes{_of(body)}: {axis.share:.0%} of the area turns about one, {axis.rival:.0%} about another",
            "give the solid of one turned part, or its profile by hand or as a drawing",
        )
    if turned_round:
        axis = Axis(axis.origin, -axis.direction, axis.share, axis.rival)
    section = contours_of(body, axis)
    if (at := crossing(section)) is not None:
        raise _refusal(path, f"the section{_of(body)} crosses itself at {_at(at)}", "mend the solid in the CAD system")
    contours = tuple(contour for contour in section if math.dist(*contour.ends) > WITHIN_MM)
    (x, y, z), (dx, dy, dz) = axis.origin.tolist(), axis.direction.tolist()
    note = (
        f"The axis{_of(body)} runs through x {x:.4f}, y {y:.4f}, z {z:.4f} mm along ({dx:.6f}, {dy:.6f}, {dz:.6f}); "
        f"{axis.share:.0%} of the turned area is turned about it."
    )
    features = [piece.feature for contour in section for piece in contour.pieces]
    notes = [note, *not_turned(body, axis, features)]
    if len(contours) < len(section):
        notes.append(f"{len(section) - len(contours)} closed cavities{_of(body)} were left out.")
    return _Part(body, axis, contours, tuple(notes))


def _tolerances(solids: Solids, part: _Part, features: Sequence[Feature], path: Path) -> Proposals:
    """Returns the features' characteristics that tolerances in the file limit."""
    text = path.read_text(encoding="latin-1") if solids.reader is not None else ""
    if not HAS_TOLERANCES.search(text):
        return Proposals()
    records = read_records(text)
    curves: dict[int, list[Meridian]] = {}
    for number, face in solids.numbered(part.body.faces, records):
        curves.setdefault(number, []).extend(meridians(face, part.axis))

    def of_faces(numbers: Sequence[int]) -> list[Feature]:
        return [features[k] for k in run_on([meridian for n in numbers for meridian in curves.get(n, [])], features)]

    return proposals(list(stated_in(records)), of_faces)


def _chosen(
    pieces: Sequence[PlacedPiece], side: Side, number: int | None, range_mm: tuple[float, float], path: Path
) -> PlacedPiece:
    """The one contour of the side that reaches into the range, or that of the number among all of the side."""
    of_side = [piece for piece in pieces if piece.contour.side is side]
    within = [piece for piece in of_side if _between(piece.contour, *range_mm)]
    if number is None and len(within) == 1:
        return within[0]
    if number is not None and 1 <= number <= len(of_side):
        return of_side[number - 1]
    asked = "" if number is None else f", and number {number} was asked for"
    several = "; ".join(f"{k}: {piece}" for k, piece in enumerate(of_side[:6], 1))
    others = "; ".join(str(piece) for piece in pieces[:6])
    if of_side:
        raise _refusal(
            path,
            f"{len(of_side)} contours {side}{asked}: {several}",
            "choose one with its number (--outline, part.step_outline), or a range of z in which there is one "
            "(--from-z-mm, --to-z-mm)",
        )
    raise _refusal(path, f"0 contours {side}; found: {others or 'none'}", "choose the other side, or a turned solid")


def _notes(pieces: Sequence[PlacedPiece], chosen: PlacedPiece, features: Sequence[Feature]) -> list[str]:
    ends = features[0].start_mm[1], features[-1].end_mm[1]
    notes = [f"z is counted from the file's origin: the profile runs from z = {ends[0]:.4f} to z = {ends[1]:.4f} mm."]
    if chosen.contour.by_most:
        notes.append("What stands out at less than half of the angles about the axis was left out.")
    notes += [f"Also found: {piece}." for piece in pieces if piece is not chosen]
    return notes


def _clipped(contour: Contour, low: float, high: float, path: Path) -> list[Piece]:
    """The pieces between two z, those that cross them cut there."""
    kept = _between(contour, low, high)
    broken = any(math.dist(a.feature.end_mm, b.feature.start_mm) > 2 * WITHIN_MM for a, b in pairwise(kept))
    if not kept or broken:
        first, last = sorted(end[1] for end in contour.ends)
        raise _refusal(
            path,
            f"between z = {low:g} and {high:g} mm there are {len(kept)} features, {'not ' * broken}joined",
            f"the {contour.side} runs from z = {first:.4f} to z = {last:.4f} mm: choose another range",
        )
    return kept


def _between(contour: Contour, low: float, high: float) -> list[Piece]:
    kept = list[Piece]()
    for piece in contour.pieces:
        cuts = [*_at_z(piece.feature, low), *_at_z(piece.feature, high)]
        for part in cut_at(piece.feature, cuts, WITHIN_MM):
            ends = part.start_mm[1], part.end_mm[1]
            if min(ends) > low - WITHIN_MM and max(ends) < high + WITHIN_MM:
                kept.append(replace(piece, feature=part))
    return kept


def _at_z(feature: Feature, z: float) -> list[Point]:
    if not math.isfinite(z):
        return []
    if isinstance(feature, Curve):
        s = sign_changes(feature, lambda points: points[:, 1] - z)
        return [(float(x), z) for x, _ in feature.point_mm(s)]
    if isinstance(feature, Line):
        (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
        return [(x0 + (x1 - x0) * (z - z0) / (z1 - z0), z)] if (z0 - z) * (z1 - z) < 0 else []
    (cx, cz), r = feature.centre_mm, feature.radius_mm
    aside = math.sqrt(max(r * r - (z - cz) ** 2, 0.0))
    return [(cx - aside, z), (cx + aside, z)] if abs(z - cz) < r else []


def _of(body: Body) -> str:
    return f" of {body.name!r}" if body.name else ""


def _at(point: Point) -> str:
    x, z = (round(value, 4) + 0.0 for value in point)  # + 0.0 turns −0.0 into 0.0
    return f"x = {x:.4f}, z = {z:.4f} mm"


def _refusal(path: Path, message: str, hint: str) -> TrueloopError:
    return Code.GEO_STEP.refusal(message, hint=hint, place=Place(str(path)))
