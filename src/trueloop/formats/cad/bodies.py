"""The bodies of a STEP or IGES file: closed solids, under the names that the file gives them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.errors import Code, Place
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.part21 import FACES, Records
from trueloop.formats.cad.step import STEP, CadFace, read_document, read_shape

SEWN_WITHIN_MM: Final = 1e-3
"""Edges of loose faces that lie closer are one edge."""


@dataclass(frozen=True, eq=False)
class Body:
    """A solid of a file, its name there ("" where it has none), and its faces, numbered from 1 within it."""

    name: str
    solid: Any
    faces: tuple[CadFace, ...]


@dataclass(frozen=True, eq=False)
class Solids:
    """All bodies of a file, and the kernel's reader of a STEP file, which knows the record of every face."""

    bodies: tuple[Body, ...]
    reader: Any = None

    def numbered(self, faces: Sequence[CadFace], records: Records) -> Iterator[tuple[int, CadFace]]:
        """Faces with the numbers of the records that they come from; nothing for a file without such."""
        if self.reader is None:
            return
        session = self.reader.ChangeReader().WS()
        model, made = session.Model(), session.TransferReader()
        if model.NbEntities() != len(records.numbers):
            return
        known = [(n, model.Value(k)) for k, n in enumerate(records.numbers, 1) if set(records.of[n].types) & FACES]
        number = {id(record): n for n, record in known}  # the kernel gives one object for one record, while it is kept
        for face in faces:
            record = made.EntityFromShapeResult(face.handle.Located(kernel().Location()), -1)
            if id(record) in number:
                yield number[id(record)], face


def read_solids(path: Path) -> Solids:
    """Reads the bodies in the file's order; loose faces, as IGES has them, are sewn together.

    Raises SRF-CAD for a file that cannot be read, SRF-CAD-KERNEL without the kernel, GEO-STEP where its faces close no
    solid.
    """
    if path.suffix.lower() in STEP:
        document, reader = read_document(path)
        named = list(_of_document(document))
    else:
        reader, named = None, [("", solid) for solid in _all(read_shape(path), kernel().SOLID)]
    if not named:
        named = [("", solid) for solid in _sewn(read_shape(path), path)]
    bodies = (Body(name, kernel().as_solid(solid), tuple(_faces(path, solid))) for name, solid in named)
    return Solids(tuple(bodies), reader)


def _of_document(document: Any) -> Iterator[tuple[str, Any]]:
    occ = kernel()
    roots = occ.Labels()
    occ.shapes_of(document.Main()).GetFreeShapes(roots)
    for root in roots:
        yield from _of_label(root, occ.Location(), "")


def _of_label(label: Any, place: Any, above: str) -> Iterator[tuple[str, Any]]:
    """The solids of one product, and those of the products that it is put together from, where they stand."""
    occ, name = kernel(), _name(label) or above
    parts = occ.Labels()
    if occ.ShapeTool.IsAssembly_s(label) and occ.ShapeTool.GetComponents_s(label, parts):
        for part in parts:
            product = occ.Label()
            if occ.ShapeTool.GetReferredShape_s(part, product):
                yield from _of_label(product, place * occ.ShapeTool.GetLocation_s(part), _name(part) or name)
        return
    solids = list(_all(occ.ShapeTool.GetShape_s(label), occ.SOLID))
    for k, solid in enumerate(solids, 1):
        yield (name if len(solids) == 1 else f"{name}/{k}"), solid.Moved(place)


def _name(label: Any) -> str:
    occ, found = kernel(), kernel().Name()
    return str(found.Get().ToExtString()) if label.FindAttribute(occ.Name.GetID_s(), found) else ""


def _sewn(shape: Any, path: Path) -> Iterator[Any]:
    occ = kernel()
    sewing = occ.Sewing(SEWN_WITHIN_MM)
    sewing.Add(shape)
    sewing.Perform()
    closed = [shell for shell in _all(sewing.SewedShape(), occ.SHELL) if shell.Closed()]
    if not closed:
        raise Code.GEO_STEP.refusal(
            f"the {sum(1 for _ in _all(shape, occ.FACE))} faces of {path.name!r} close 0 solids",
            hint="export the part as a solid",
            place=Place(str(path)),
        )
    for shell in closed:
        solid = occ.MakeSolid(occ.as_shell(shell)).Solid()
        occ.orient_closed(solid)
        yield solid


def _faces(path: Path, solid: Any) -> Iterator[CadFace]:
    occ = kernel()
    for number, face in enumerate(_all(solid, occ.FACE), 1):
        yield CadFace(path, number, occ.as_face(face))


def _all(shape: Any, kind: Any) -> Iterator[Any]:
    explorer = kernel().Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()
