"""Contradictions to the store: files and records of another part, another stage, or a time that cannot be."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part
from trueloop.errors import Code, Finding, Severity
from trueloop.loops.turned.correction import Correction
from trueloop.statistics import rms
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import ON_PROFILE_MM
from trueloop.units import MM_PER_INCH, UM_PER_MM
from trueloop.wording import Um, wording


def require_serial(part: Part, file: str) -> None:
    """Raises STO-PART for a part without a serial number, by which parts are kept apart; `file` should state it."""
    if not part.serial:
        raise Code.STO_PART.refusal(
            f"{file!r} does not state its part: {part.part_type.name!r} without a serial number",
            hint="state it: --serial NUMBER, or `part.serial` of the job",
            override="--no-store",
            values={"file": file},
        )


def require_file_of_part(store: Store, inspection: Inspection) -> None:
    """Raises STO-OTHER-PART for what was kept before as measured on another part. A file may hold several parts."""
    part, sha256 = inspection.part, inspection.sha256[:16]
    for other in (kept.value for kept in find(store, Inspection, file_sha256=inspection.sha256)):
        same = (other.values, other.measured_at) == (inspection.values, inspection.measured_at)
        if same and other.part.identity != part.identity:
            raise Code.STO_OTHER_PART.refusal(
                wording(
                    "the file with sha256 {sha256} is kept as an inspection of part {serial!r} of {part_type!r}, "
                    "and now said to be of part {now!r}",
                    sha256=sha256,
                    serial=other.part.serial,
                    part_type=other.part.part_type.name,
                    now=part.serial,
                ),
                hint=wording("name the file of this part, or the serial number of the part that the file is of"),
                values={"file": sha256},
            )


def cuts_of(store: Store, part: Part, stage: Stage) -> list[Cut]:
    """Returns the cuts of a part of that stage, oldest first."""
    found = find(store, Cut, part_type=part.part_type.name, serial=part.serial, stage=stage)
    return [stored.value for stored in found if stored.value.part.identity == part.identity]


def link_of(store: Store, inspection: Inspection) -> InspectionLink | None:
    """Returns the link to the cut that an inspection shows; None: it is not known."""
    kept = find(store, InspectionLink, identity=joined(inspection.identity))
    return kept[-1].value if kept else None


def as_known(store: Store, inspection: Inspection) -> Inspection:
    """Returns the inspection as it was kept of the same file and part, where it has no time of measurement now."""
    if inspection.measured_at is not None:
        return inspection
    kept = (stored.value for stored in find(store, Inspection, file_sha256=inspection.sha256))
    same = (one for one in kept if (one.part.identity, one.values) == (inspection.part.identity, inspection.values))
    return next(same, inspection)


def finished_already(store: Store, inspections: Sequence[Inspection], finished: bool) -> Iterator[Finding]:
    """Yields a warning: finished before new touches of its rough surface; a note: before a further inspection."""
    for inspection in inspections[:1]:
        known = find(store, Inspection, identity=joined(inspection.identity))
        if not known and cuts_of(store, inspection.part, Stage.FINISH):
            now = "measured again: both inspections are of one cut" if finished else "touched before its finish cut"
            yield Finding(
                Severity.NOTE if finished else Severity.WARNING,
                Code.STO_STAGE,
                f"part {inspection.part.serial!r} is kept as finished, and is now {now}",
                hint="another part, or one that was cut again, has a serial number of its own: `part.serial` of the "
                "job, or --serial",
                values={"serial": inspection.part.serial},
            )


def require_later(earlier: tuple[str, datetime | None], later: tuple[str, datetime | None]) -> None:
    """Raises STO-CLOCK where what comes later has the earlier time; unknown times say nothing."""
    (first, before), (second, after) = earlier, later
    if before is None or after is None or after.astimezone(UTC) >= before.astimezone(UTC):
        return
    times = [one.astimezone(UTC).isoformat(timespec="minutes") for one in (before, after)]
    raise Code.STO_CLOCK.refusal(
        wording(
            "{second} at {second_at} is before {first} at {first_at}",
            second=second,
            second_at=times[1],
            first=first,
            first_at=times[0],
        ),
        hint="state the right time (`gauging.measured_at`), or name the file of this part",
        override="--accept STO-CLOCK",
        values={"earlier": times[0], "later": times[1]},
    )


LARGEST: Final = 2.0
"""A cut whose correction was not run leaves what was touched before it, one corrected twice as much on the other side:
errors this many times as large as those, and as the bands of the prediction, have another cause."""

MOVED_MM: Final = 0.1
"""A tool that was moved (an offset that nobody stated, a chip in its seat) leaves errors up to this size."""

SHOWS_MOVED: Final = 6
"""The least number of points that show a moved tool: two coordinates of any few explain all of them."""


def other_points(part: Part, before: Correction, after: ErrorVectors) -> Iterator[Finding]:
    """Yields a warning where the points are others than before the finish cut; with memory more may be inspected."""
    touched, found = len(before.touches.point), len(after.point)
    near = sum(bool(_distances_mm(before, place).min() <= ON_PROFILE_MM) for place in after.nominal_mm)
    fewer_touched = before.memory is not None and near == touched
    if (near, found) != (found, touched) and not fewer_touched:
        yield Finding(
            Severity.WARNING,
            Code.STO_PATTERN,
            f"part {part.serial!r} was inspected at {found} points, {near} of which are among the {touched} that were "
            "touched before its finish cut",
            hint="where a point belongs to another part or another plan, replace the inspection; else it counts",
            values={"serial": part.serial, "points": float(found)},
        )


def require_size(before: Correction, after: ErrorVectors) -> None:
    """Raises STO-UNIT for errors too large of a finish cut, moved or in another unit, and for all exactly zero."""
    size, touched = rms(after.error_mm), rms(before.model.vectors.error_mm)
    band = rms(before.prediction.expanded_u_mm)
    by_unit = _unlike_mm(before, after) > LARGEST * band and size / MM_PER_INCH <= band
    every = np.ones(len(after.point), dtype=np.bool_)
    moved = len(every) >= SHOWS_MOVED and size <= MOVED_MM and _unmoved_mm(after, every) <= LARGEST * band
    if size > 0.0 and (moved or size <= LARGEST * (touched + band)) and not by_unit:
        return
    factor = f"; {MM_PER_INCH} or {UM_PER_MM:g} times too much?" if size else ": filled in, not measured?"
    raise Code.STO_UNIT.refusal(
        wording(
            "the errors after the finish cut are {size} RMS, those before it {touched}{factor}",
            size=Um(size),
            touched=Um(touched),
            factor=factor,
        ),
        hint=wording("check the unit of the file (--unit), and that it holds errors of this part"),
        override="--accept STO-UNIT",
        values={"size_um": size * UM_PER_MM, "other_um": touched * UM_PER_MM},
    )


def _unlike_mm(before: Correction, after: ErrorVectors) -> float:
    """By how much the errors are other than nothing, than those before the cut (not corrected), than these with the
    other sign (corrected twice), and than what a tool leaves that was moved, RMS at common places; 0 without any.
    """
    distances = np.array([_distances_mm(before, place) for place in after.nominal_mm])
    common = distances.min(axis=1) <= ON_PROFILE_MM
    if not np.any(common):
        return 0.0
    found, was = after.error_mm[common], before.model.vectors.error_mm[distances.argmin(axis=1)[common]]
    return min(_unmoved_mm(after, common), *(rms(found - share * was) for share in (0.0, 1.0, -1.0)))


def _unmoved_mm(after: ErrorVectors, rows: Flags) -> float:
    """Returns what a moved tool does not leave, RMS at some points: in another unit it is as much too large as all."""
    found, normal = after.error_mm[rows], after.outward_normal[rows]
    return rms(found - normal @ np.linalg.lstsq(normal, found, rcond=None)[0])


def _distances_mm(before: Correction, place: Array) -> Array:
    return np.asarray(np.linalg.norm(before.touches.nominal_mm - place, axis=1))
