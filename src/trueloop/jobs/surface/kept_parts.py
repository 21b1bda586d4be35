"""Measured parts of a surface in the store: kept with their points, and taken for the pattern with today's."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import CmmPoint, Inspection, Vector
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Finding, TrueloopError, in_file
from trueloop.geometry.surface import Surface, closest
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts, texts_of
from trueloop.jobs.store.of_this_part import cuts_of, require_file_of_part
from trueloop.jobs.store.opened import Beside, Choice, store_of
from trueloop.jobs.surface.job import ReadSurface, require_cut_stated, require_one_face
from trueloop.loops.surface.correction import RecordedCorrection, SurfaceInputs, enveloped
from trueloop.loops.surface.surface import HERE, Work, model_of
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find
from trueloop.surface.deviations.points import MeasuredPoints

PLACE: Final = re.compile(r"(\d+),(\d+)")
"""A point's name where it is one of a grid: row and column, from 1."""
COMPARED: Final = 500
"""So many points of a part tell whether it was measured on this surface."""
SAME_MM: Final = 1e-4
"""Nominal points of the same surface lie on it as closely: they were computed, and stored to the last digit."""
ALONG: Final = 0.999


def keep_parts(store: Store, read: ReadSurface) -> KeptFacts:
    """Keeps the job's parts with all their points, or none. Raises STO-OTHER-PART, and what keeping refuses."""
    return keep_facts(store, part_facts(store, read.inputs))


def part_facts(store: Store, inputs: SurfaceInputs) -> Iterator[Part | Inspection | Cut | InspectionLink]:
    """Yields the job's own parts as facts: those from the store are there already. Raises STO-OTHER-PART."""
    own, in_force = slice(inputs.earlier, None), inputs.cut_with.correction
    for measured, inspection in zip(inputs.parts[own], inputs.inspections[own], strict=True):
        pointed = replace(inspection, values=tuple(_points(inputs.surface, measured)))
        require_file_of_part(store, pointed)
        known = cuts_of(store, inspection.part, Stage.FINISH)
        made = Cut(inspection.part, Stage.FINISH, program_sha256=program_of(inputs), correction=in_force)
        cut = known[-1] if known else made
        if in_force and cut.correction != in_force:
            was = f"cut with correction {cut.correction}" if cut.correction else "cut without a correction"
            why = f"is kept as {was}, and the job states correction {in_force}"
            raise _refused(inspection, why, "state in gauging.cut_with what did cut it, or give another part its name")
        yield inspection.part
        yield cut
        yield pointed
        yield InspectionLink(inspection.identity, cut.identity, released=True)


def with_kept_parts(store: Store, read: ReadSurface) -> tuple[ReadSurface, tuple[str, ...]]:
    """Returns the job with the parts in the store before its own, in the order in which they were kept; notes of
    those that are left out.

    A part that the job names itself counts once, as the job has it. Parts cut by another program are left out: theirs
    is another pattern. Raises SRF-STORED for parts of another surface, or aligned otherwise, under the job's name,
    SRF-TWICE for a part that is there under another name.
    """
    inputs = read.inputs
    own, program = {part.name for part in inputs.parts}, program_of(inputs)
    files = {one.sha256: one.part.serial for one in inputs.inspections}
    parts, inspections, others = list[MeasuredPoints](), list[Inspection](), list[str]()
    for inspection, cut in _kept(store, inputs.name):
        if inspection.part.serial in own:
            continue
        if inspection.sha256 in files:
            raise _twice(inspection, files[inspection.sha256])
        if (cut.program_sha256, cut.correction) != (program, inputs.cut_with.correction):
            others.append(inspection.part.serial)
            continue
        _require_same_surface(inputs, inspection)
        parts.append(measured_of(inspection))
        inspections.append(replace(inspection, values=()))
    notes = [_of_other_program(others, program)] if others else []
    hashes = {f"store:{one.part.serial}": one.sha256 for one in inspections}
    together = replace(
        inputs,
        parts=(*parts, *inputs.parts),
        inspections=(*inspections, *inputs.inspections),
        sha256={**hashes, **inputs.sha256},
        earlier=len(parts),
    )
    return replace(read, inputs=together), tuple(notes)


def measured_of(inspection: Inspection) -> MeasuredPoints:
    """Returns the points of a part, with their places in the grid where they have any."""
    points = np.array([point.measured_mm for point in inspection.points], float).reshape(-1, 3)
    places = [PLACE.fullmatch(point.name) for point in inspection.points]
    name, ball = inspection.part.serial, inspection.ball_radius_mm
    gridded = [(int(place[1]), int(place[2])) for place in places if place is not None]
    if len(gridded) < len(places):
        return MeasuredPoints(points, ball, None, name)
    rows, columns = (max(along) for along in zip(*gridded, strict=True))
    grid = np.full((rows * columns, 3), np.nan)
    grid[[(row - 1) * columns + column - 1 for row, column in gridded]] = points
    return MeasuredPoints(grid, ball, (rows, columns), name)


def program_of(inputs: SurfaceInputs) -> str:
    """Returns the hash of the program that cut the parts, as far as the job states it; empty: not at all."""
    if inputs.cut_with.corrected:
        return inputs.cut_with.program_sha256
    if inputs.program_sha256:
        return inputs.program_sha256.lower()
    return "" if inputs.program is None else sha256_of(inputs.program.source)


def _points(surface: Surface, measured: MeasuredPoints) -> Iterator[CmmPoint]:
    """Every point that was measured, with the point of the nominal surface below it and the normal there."""
    there = np.flatnonzero(np.all(np.isfinite(measured.points_mm), axis=1))
    feet = closest(surface, measured.points_mm[there])
    columns = 0 if measured.shape is None else measured.shape[1]
    for k, point, nominal, normal in zip(there, measured.points_mm[there], feet.point_mm, feet.normal, strict=True):
        name = f"{k // columns + 1},{k % columns + 1}" if columns else ""
        yield CmmPoint(_vector(point), _vector(nominal), _vector(normal), name)


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def _kept(store: Store, name: str) -> Iterator[tuple[Inspection, Cut]]:
    """The latest inspection with points of each part of that name, with its cut."""
    of_inspection = {
        link.value.inspection: kept.value
        for kept in find(store, Cut, part_type=name)
        for link in find(store, InspectionLink, cut=joined(kept.value.identity))
    }
    found: dict[str, tuple[Inspection, Cut]] = {}
    for kept in find(store, Inspection, part_type=name):
        cut = of_inspection.get(kept.value.identity)
        if cut is not None and kept.value.points:
            found[kept.value.part.serial] = (kept.value, cut)
    yield from found.values()


def _require_same_surface(inputs: SurfaceInputs, inspection: Inspection) -> None:
    if inspection.frame != ("device" if inputs.options.best_fit else "part"):
        other = "best-fit" if inspection.frame == "device" else "datum"
        raise _refused(inspection, f"was aligned otherwise: {other!r}", "gauging.alignment is to be that of all parts")
    points = inspection.points[:: max(1, len(inspection.points) // COMPARED)]
    nominal = np.array([point.nominal_mm or (np.nan,) * 3 for point in points])
    normal = np.array([point.outward_normal or (np.nan,) * 3 for point in points])
    if not np.all(np.isfinite(nominal)):
        return
    feet = closest(inputs.surface, nominal)
    off = float(np.max(np.linalg.norm(nominal - feet.point_mm, axis=1)))
    turned = float(np.min(np.einsum("nk,nk->n", normal, feet.normal)))
    if off > SAME_MM or turned < ALONG:
        how = f"its nominal points are up to {off:.3g} mm off" if off > SAME_MM else "its normals are others"
        raise _refused(
            inspection,
            f"was measured on another surface: {how}",
            "give another surface another `name`, at the top of the job",
        )


def _refused(inspection: Inspection, why: str, hint: str) -> TrueloopError:
    part = inspection.part
    return Code.SRF_STORED.refusal(
        f"part {part.serial!r} of {part.part_type.name!r} in the store {why}",
        hint=hint,
        override="--no-store takes the job's own parts alone",
        values={"part": part.serial},
    )


def _twice(inspection: Inspection, name: str) -> TrueloopError:
    return Code.SRF_TWICE.refusal(
        f"part {name!r} is in the store as {inspection.part.serial!r} already: their files have the same bytes",
        hint="leave the copy out of gauging.points, or give it the name it has in the store",
    )


def _of_other_program(serials: Sequence[str], program: str) -> str:
    stated = f"{program[:16]}…" if program else "not stated"
    return (
        f"{len(serials)} parts in the store were cut by another program than this job's ({stated}), or with another "
        f"correction, and do not count: {', '.join(serials)}"
    )


def keep_surface(together: "Together", done: RecordedCorrection, *, supersede: bool) -> KeptFacts | None:
    """Keeps the parts, their inspections, the cuts that these show, the programs and the correction; None: no store.

    A part's serial number is its file's name. Raises STO-OTHER-PART and what keeping refuses.
    """
    store = together.store
    return None if store is None else keep_facts(store, _facts(store, together.read, done), supersede=supersede)


def _facts(store: Store, read: ReadSurface, done: RecordedCorrection) -> Iterator[Any]:
    program, written = read.inputs.program, done.correction.program
    yield from part_facts(store, read.inputs)
    yield from texts_of([None if program is None else program.source, None if written is None else written.source])
    yield enveloped(done)


@dataclass(frozen=True)
class Together:
    """A job with the parts of its store, which is None where there is none; notes of parts that do not count."""

    read: ReadSurface
    store: Store | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class AddedPart:
    """The kept values, the number of parts now in the store, and the findings about the new parts."""

    kept: KeptFacts
    parts: int
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]


def with_store(read: ReadSurface, db: Choice, beside: Beside = "used", *, keep_outliers: bool = False) -> Together:
    """Returns the job with the parts of the store requested, else of the one beside it; unchanged where there is none.

    `keep_outliers`: parts that are outlying beyond doubt count for the pattern too. Raises STO and SRF errors.
    """
    read = replace(read, inputs=replace(read.inputs, leave_out=not keep_outliers))
    store = store_of(read.job.parent, db, read.store_db, beside)
    if store is None:
        return Together(read, None, ())
    require_one_face(read)

    with in_file(read.job):
        together, notes = with_kept_parts(store, read)
    return Together(together, store, notes)


def add_parts(together: Together, work: Work = HERE) -> AddedPart:
    """Keeps the job's own parts and judges those that are new, each given the parts before it. Raises STO, SRF errors.

    Nothing is kept of parts that are refused: their points are compared with the surface first.
    """
    from trueloop.loops.surface.over_parts import as_findings, notice_in_order

    store, inputs = together.store, together.read.inputs
    assert store is not None
    require_cut_stated(together.read)
    with in_file(together.read.job):
        parts = model_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=work)
        kept = keep_parts(store, together.read)
    new = [stored.value.part.serial for stored in kept.new if isinstance(stored.value, Inspection)]
    counted = [part for part in parts if part.deviations.name not in inputs.options.exclude]
    noticed = notice_in_order(counted, new)
    findings = tuple(finding for one in noticed for finding in as_findings(one))
    return AddedPart(kept, len(parts), findings, together.notes)
