"""Surfaces from and to CAD files: STEP (AP203, AP214, AP242) and IGES, through Open CASCADE.

The CAD kernel (`cad_kernel`) is an optional extra; without it a refusal says how to get it. Lengths are converted
to millimetres by the kernel, from the unit that the file states.
"""

import re
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.loops import Loop, Outline, exchanged, loops_of, outline_of, trimmed_face
from trueloop.geometry.surface import Surface, closest, near

RUNS_ON_DEG: Final = 8.0
"""Faces whose normals differ by no more along their common edge run on into each other."""
JOINED_MM: Final = 0.01
"""Edges of two faces as near as this are one edge: CAD systems state theirs to a hundredth at worst."""
JOINED_PLACES: Final = 4
"""Fewer places of an edge are a corner."""
EDGE_PLACES: Final = 65
STEP: Final = {".step", ".stp", ".p21"}
IGES: Final = {".igs", ".iges"}
IGES_TEXT: Final = 72
"""Columns of text in a line of IGES."""
FULL_TURN: Final = 1e-9
"""An interval that lacks less than this share of a turn is a full turn: less than edges are stated to."""


@dataclass(frozen=True, eq=False)
class CadFace:
    """A face of a CAD model: `number` from 1 in the file's order, the kernel's own handle, and the faces that were not
    named with it; `group` is alike for named faces that run on into each other. All else is computed when it is used:
    other faces cost nothing, and none of them can be in the way.
    """

    file: Path
    number: int
    handle: Any
    others: "tuple[CadFace, ...]" = ()
    group: int = 0

    @cached_property
    def surface(self) -> Surface:
        """Returns the face's surface as an exact B-spline patch, normals out of the material. Raises SRF-CAD."""
        return _surface_of(self)

    @property
    def kind(self) -> str:
        """Returns the kernel's name of the surface, such as CylindricalSurface."""
        return type(kernel().surface_of(self.handle)).__name__.removeprefix("Geom_")

    @property
    def area_mm2(self) -> float:
        """Returns the area inside the face's edges."""
        occ = kernel()
        properties = occ.Properties()
        occ.measure(self.handle, properties)
        return float(properties.Mass())

    def __str__(self) -> str:
        return f"{self.number}: {self.kind}, {self.area_mm2:.1f} mm²"

    def trimmed_away(self, u: Array, v: Array) -> np.ndarray:
        """Returns which places (n,) lie beyond the face's trimming curves by more than a touch may."""
        return self._outline.cut_away(u, v)

    @cached_property
    def loops(self) -> tuple[Loop, ...]:
        """Returns the loops that bound the face on its surface; none where it is the whole patch."""
        return loops_of(self.surface, self.handle)

    @cached_property
    def _outline(self) -> Outline:
        return outline_of(self.surface, self.handle)


def read_faces(path: Path) -> list[CadFace]:
    """Reads every face of a STEP or IGES file. Raises SRF-CAD: unreadable or without a face, SRF-CAD-KERNEL."""
    occ = kernel()
    explorer = occ.Explorer(read_shape(path), occ.FACE)
    faces: list[CadFace] = []
    while explorer.More():
        faces.append(CadFace(path, len(faces) + 1, occ.as_face(explorer.Current())))
        explorer.Next()
    if not faces:
        raise Code.SRF_CAD.refusal(
            f"{path.name!r} holds no surface, 0 faces",
            hint="export the surface itself: curves and meshes alone are not enough",
            place=Place(str(path)),
        )
    return faces


def named_faces(path: Path, numbers: Sequence[int | None] = (None,)) -> list[CadFace]:
    """Reads faces by their numbers from 1, None: the only face. Raises SRF-CAD-CHOICE with a list of the faces."""
    faces, named = read_faces(path), list[CadFace]()
    for number in numbers:
        k = 1 if number is None and len(faces) == 1 else number or 0
        if not 1 <= k <= len(faces):
            chosen = "none was chosen" if number is None else f"face {number} was asked for"
            raise Code.SRF_CAD_CHOICE.refusal(
                f"{path.name!r} has {len(faces)} faces and {chosen}",
                hint="choose one with its number, for `compensate` all that the program cuts, as face = [2, 3]: "
                + ", ".join(map(str, faces[:20])),
                place=Place(str(path)),
                values={"file": path.name, "faces": len(faces)},
            )
        named.append(faces[k - 1])
    others = tuple(face for face in faces if face not in named)
    return [replace(face, others=others, group=group) for face, group in zip(named, _groups(named), strict=True)]


def _groups(faces: Sequence[CadFace]) -> list[int]:
    """Returns a number for each face, equal for those joined along edges with normals within `RUNS_ON_DEG`."""
    group = list(range(len(faces)))
    for k, face in enumerate(faces):
        for j in range(k):
            if group[j] != group[k] and _runs_on(face, faces[j]):
                group = [group[j] if one == group[k] else one for one in group]
    return group


def _runs_on(face: CadFace, other: CadFace) -> bool:
    edge = _edge_places(face)
    (u0, u1), (v0, v1) = face.surface.domain
    at = face.surface.partials(u0 + (u1 - u0) * edge[:, 0], v0 + (v1 - v0) * edge[:, 1])
    points, normal = at.point_mm, face.surface.normal_of(at)
    some = near(other.surface, points, JOINED_MM)
    if not len(some):
        return False
    feet = closest(other.surface, points[some])
    here = (np.abs(feet.distance_mm) <= JOINED_MM) & (feet.beyond_mm <= JOINED_MM)
    here[here] = ~other.trimmed_away(feet.u[here], feet.v[here]).astype(np.bool_)
    alike = np.einsum("nk,nk->n", feet.normal[here], normal[some[here]])
    return bool(len(alike) >= JOINED_PLACES and np.min(alike) >= np.cos(np.radians(RUNS_ON_DEG)))


def _edge_places(face: CadFace) -> Array:
    """Returns places along a face's edges, (n, 2) as shares of its parameters."""
    line = np.linspace(0.0, 1.0, EDGE_PLACES)
    whole = [np.column_stack(pair) for end in (0 * line, 0 * line + 1) for pair in ((line, end), (end, line))]
    pieces = [piece for loop in face.loops for piece in loop] or whole
    return np.clip(np.concatenate(pieces), 0.0, 1.0)


def write_surface(surface: Surface, path: Path, loops: Sequence[Loop] = ()) -> None:
    """Writes one surface, bounded by loops or whole: STEP AP242 or IGES, by the name's ending, millimetres.

    Outward normals are those of the patch itself, u before v: IGES knows no other.
    Raises SRF-CAD for another ending and where the kernel refuses the surface or the place, SRF-TRIM where loops bound
    no face.
    """
    occ = kernel()
    outward, around = (surface.exchanged(), exchanged(loops)) if surface.flipped else (surface, loops)
    patch = to_kernel(occ, outward)
    face = trimmed_face(patch, outward, around) if loops else occ.MakeFace(patch, 1e-6).Face()
    if face is None:
        raise Code.SRF_TRIM.refusal(
            f"the surface cannot be trimmed by the {len(loops)} loops of edges of its nominal face",
            hint="the whole patch can be written: trim it in the CAD system, by the nominal face's edges",
        )
    ending = path.suffix.lower()
    if ending in STEP:
        writer = occ.StepWriter()  # it makes the settings known that follow
        occ.set_text("write.step.schema", "AP242DIS")
        occ.set_text("write.step.unit", "MM")
        done = writer.Transfer(face, occ.AS_IS) == occ.DONE and writer.Write(str(path)) == occ.DONE
    elif ending in IGES:
        writer = occ.IgesWriter("MM", 1)
        writer.AddShape(face)
        writer.ComputeModel()
        done = writer.Write(str(path))
    else:
        raise _unknown_ending(path)
    if not done:
        raise Code.SRF_CAD.refusal(f"{path.name!r} could not be written: 1 face", hint="is the folder there?")


def surface_to_bytes(surface: Surface, ending: str, description: str, loops: Sequence[Loop] = ()) -> bytes:
    """Returns what `write_surface` writes, for files that are written together or not at all, described where the
    format has a place for that: STEP's FILE_DESCRIPTION, the start section of IGES.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"surface.{ending}"
        write_surface(surface, path, loops)
        content = path.read_bytes()
    if f".{ending}" in IGES:
        return description.encode("ascii").ljust(IGES_TEXT)[:IGES_TEXT] + content[IGES_TEXT:]
    return re.sub(rb"(FILE_DESCRIPTION\(\(')[^']*", rb"\g<1>" + description.encode("ascii"), content, count=1)


def read_shape(path: Path) -> Any:
    """Reads all of a STEP or IGES file as one shape of the kernel. Raises as `read_faces`."""
    occ, ending = kernel(), _checked_ending(path)
    reader = occ.StepReader() if ending in STEP else occ.IgesReader()
    if reader.ReadFile(str(path)) != occ.DONE or not reader.TransferRoots() or reader.OneShape().IsNull():
        raise _unreadable(path)
    return reader.OneShape()


def read_document(path: Path) -> tuple[Any, Any]:
    """Reads a STEP file: the kernel's document, shapes with names, and the reader of it. Raises as `read_faces`."""
    occ = kernel()
    _checked_ending(path)
    document, reader = occ.Document(occ.Text("XCAF")), occ.DocumentReader()
    reader.SetNameMode(True)
    if reader.ReadFile(str(path)) != occ.DONE or not reader.Transfer(document):
        raise _unreadable(path)
    return document, reader


def _checked_ending(path: Path) -> str:
    """The ending of a file that is there and whose format is known."""
    if not path.is_file():
        raise Code.SRF_CAD.refusal(f"no file {path.name!r}", hint="look at the path in the job", place=Place(str(path)))
    ending = path.suffix.lower()
    if ending not in STEP | IGES:
        raise _unknown_ending(path)
    return ending


def _unreadable(path: Path) -> TrueloopError:
    form = "STEP" if path.suffix.lower() in STEP else "IGES"
    return Code.SRF_CAD.refusal(
        f"{path.name!r} cannot be read as {form}, or holds no surface",
        hint="export it again as STEP AP214 or AP242, with surfaces",
        place=Place(str(path)),
    )


def _unknown_ending(path: Path) -> TrueloopError:
    known = ", ".join(sorted(STEP | IGES))
    return Code.SRF_CAD.refusal(f"{path.suffix!r} does not end the name of a CAD file", hint=f"known endings: {known}")


def _surface_of(face: CadFace) -> Surface:
    occ = kernel()
    try:
        whole = occ.surface_of(face.handle)
        patch = occ.to_bspline(occ.Trimmed(whole, *_extent(occ, face.handle, whole), True, True))
        if patch.IsUPeriodic():
            patch.SetUNotPeriodic()
        if patch.IsVPeriodic():
            patch.SetVNotPeriodic()
    except occ.Failure as fault:
        raise Code.SRF_CAD.refusal(
            f"the CAD kernel cannot make a B-spline surface of face {face} of {face.file.name!r}: {fault}",
            hint="export that face as a B-spline surface (NURBS), or choose another one",
            place=Place(str(face.file)),
        ) from None
    return _from_kernel(patch, flipped=face.handle.Orientation() == occ.REVERSED)


def _extent(occ: Any, face: Any, whole: Any) -> tuple[float, ...]:
    """The face's (u0, u1, v0, v1), not beyond its surface: edges are stated to a tolerance, and may pass the end."""
    (u0, u1, v0, v1), (a0, a1, b0, b1) = occ.uv_bounds(face), whole.Bounds()
    return *_within(u0, u1, a0, a1, whole.IsUPeriodic()), *_within(v0, v1, b0, b1, whole.IsVPeriodic())


def _within(low: float, high: float, first: float, last: float, periodic: bool) -> tuple[float, float]:
    """An interval of a parameter from first to last; of a full turn exactly one, as the kernel demands."""
    if not periodic:
        return max(low, first), min(high, last)
    if high - low < (last - first) * (1 - FULL_TURN):
        return low, high
    return (first, last) if abs(low - first) < (last - first) * FULL_TURN else (low, low + (last - first))


def _from_kernel(patch: Any, *, flipped: bool) -> Surface:
    n, m = patch.NbUPoles(), patch.NbVPoles()
    poles = [[patch.Pole(i, j) for j in range(1, m + 1)] for i in range(1, n + 1)]
    control = np.array([[(p.X(), p.Y(), p.Z()) for p in row] for row in poles])
    rational = patch.IsURational() or patch.IsVRational()
    weights = [[patch.Weight(i, j) for j in range(1, m + 1)] for i in range(1, n + 1)]
    knots_u = _repeated((patch.UKnot(k), patch.UMultiplicity(k)) for k in range(1, patch.NbUKnots() + 1))
    knots_v = _repeated((patch.VKnot(k), patch.VMultiplicity(k)) for k in range(1, patch.NbVKnots() + 1))
    degrees = (patch.UDegree(), patch.VDegree())
    return Surface(
        degrees=degrees,
        knots_u=knots_u,
        knots_v=knots_v,
        control_mm=control,
        weights=np.array(weights) if rational else None,
        flipped=flipped,
    )


def _repeated(knots: Iterator[tuple[float, int]]) -> Array:
    return np.concatenate([np.full(count, knot) for knot, count in knots])


def to_kernel(occ: Any, surface: Surface) -> Any:
    """Returns a surface as the kernel's B-spline."""
    n, m = surface.control_mm.shape[:2]
    poles, weights = occ.Points(1, n, 1, m), occ.Reals2(1, n, 1, m)
    for i in range(n):
        for j in range(m):
            poles.SetValue(i + 1, j + 1, occ.Pnt(*map(float, surface.control_mm[i, j])))
            weights.SetValue(i + 1, j + 1, 1.0 if surface.weights is None else float(surface.weights[i, j]))
    (ku, mu), (kv, mv) = (_counted(occ, knots) for knots in (surface.knots_u, surface.knots_v))
    return occ.BSpline(poles, weights, ku, kv, mu, mv, *surface.degrees, False, False)


def _counted(occ: Any, knots: Array) -> tuple[Any, Any]:
    values, counts = np.unique(knots, return_counts=True)
    reals, integers = occ.Reals(1, len(values)), occ.Integers(1, len(values))
    for k, (value, count) in enumerate(zip(values, counts, strict=True), 1):
        reals.SetValue(k, float(value))
        integers.SetValue(k, int(count))
    return reals, integers
