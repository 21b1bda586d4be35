"""Both inspections of one part, on the machine and on a measuring machine, kept in a store."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from trueloop.arrays import Array
from trueloop.diagnosis.components import Inspections
from trueloop.domain.inspection import CmmPoint, Inspection, Vector
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.store.of_this_part import require_file_of_part
from trueloop.jobs.store.where import store_of


def keep_both(
    path: Path, points: Sequence[str], seen: Inspections, part_type: str, serial: str, keeping: Keeping
) -> KeptFacts | None:
    """Keeps the part with what either device found on it; None: there is no store.

    Raises STO-OTHER-PART for a file that is kept as another part's, and what keeping refuses.
    """
    store = store_of(path.parent, keeping.db, None)
    if store is None:
        return None
    part = Part(PartType(part_type), serial)
    both = tuple(_both(path, points, seen, part))
    for one in both:
        require_file_of_part(store, one)
    return keep_facts(store, (part, *both), supersede=keeping.supersede)


def _both(path: Path, points: Sequence[str], seen: Inspections, part: Part) -> Iterator[Inspection]:
    """One inspection a device. What tells them apart is the hash: of the file, and of which of its columns it is."""
    sha256 = sha256_of(path.read_bytes())
    for device, measured_mm in (("machine's probe", seen.controller_mm), ("measuring machine", seen.cmm_mm)):
        values = tuple(_points(points, seen, measured_mm))
        own = sha256_of(f"{sha256} {device}".encode())
        yield Inspection(part, "CMM points", own, len(values), values, device)


def _points(points: Sequence[str], seen: Inspections, measured_mm: Array) -> Iterator[CmmPoint]:
    for k, name in enumerate(points):
        measured, nominal, normal = (_vector(of[k]) for of in (measured_mm, seen.nominal_mm, seen.normal))
        yield CmmPoint(measured, nominal, normal, name)


def _vector(of: Array) -> Vector:
    x, y, z = of.tolist()
    return x, y, z
